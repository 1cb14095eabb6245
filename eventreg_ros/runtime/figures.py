# SPDX-License-Identifier: Apache-2.0
"""What nodes measure of themselves, as figures: how diagnostics write it, and how it is read back.

The keys of the diagnostics are written here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

STATE = 'state'
"""The state of the node's life, in every node."""

STEP, GRANTED, WAITING_FOR = 'step', 'granted', 'waiting_for'
"""In lockstep: the step reached, the last one that may be made, and who all others wait for."""

LEARNING = 'learning'
LEAD = 'lead'
MARGIN_USED = 'margin_used'
"""The part of the delay margin that the largest delay of the last second takes."""

LATE = 'the last second had a tick'
"""How the message begins that a node's ticks were late."""


def publishers_of(topic: str) -> str:
    """Return the key of how many publishers the subscription of ``topic`` is matched with."""
    return f'{topic}.publishers'


def subscribers_of(topic: str) -> str:
    """Return the key of how many subscriptions the publisher of ``topic`` is matched with."""
    return f'{topic}.subscribers'


def received_of(signal: str) -> str:
    """Return the key of how many samples of an input came."""
    return f'{signal}{_RECEIVED}'


_RECEIVED = '.received'


def events_of(signal: str) -> str:
    """Return the key of how many events a spike monitor has counted."""
    return f'{signal}.count'


def recorded_of(topic: str) -> str:
    """Return the key of how many messages a recorder has written."""
    return f'{topic}.recorded'


def lead_figures(signal: str, late: int, lead: float) -> dict[str, object]:
    """Return what an input has that waits for its time: the samples too late, and the lead."""
    return {f'{signal}.late': late, f'{signal}.{LEAD}': f'{lead:g}'}


class Percentiles(NamedTuple):
    """The 50th and the 99th percentile and the largest of some durations, in seconds."""

    p50: float
    p99: float
    largest: float

    def values(self, name: str) -> dict[str, str]:
        """Return them as diagnostics show them."""
        return {
            f'{name}.p50': f'{self.p50:.6f}',
            f'{name}.p99': f'{self.p99:.6f}',
            f'{name}.max': f'{self.largest:.6f}',
        }

    @classmethod
    def read(cls, values: Mapping[str, str], name: str) -> Percentiles | None:
        """Return what :meth:`values` wrote, None where it is not there."""
        keys = [f'{name}.{part}' for part in ('p50', 'p99', 'max')]
        if any(key not in values for key in keys):
            return None
        return cls(*(float(values[key]) for key in keys))


class TickFigures(NamedTuple):
    """How a node ticked: the step it is at, and what went wrong so far (in steps or times)."""

    step: int
    caught_up: int
    dropped: int
    clock_jumps: int
    overruns: int
    lateness: Percentiles

    def values(self) -> dict[str, object]:
        """Return them as diagnostics show them."""
        counts = self._asdict()
        del counts['lateness']
        return {**counts, **self.lateness.values('lateness')}

    @classmethod
    def read(cls, values: Mapping[str, str]) -> TickFigures | None:
        """Return what :meth:`values` wrote, None where it is not there."""
        lateness = Percentiles.read(values, 'lateness')
        if lateness is None or STEP not in values:
            return None
        step, caught_up, dropped, jumps, overruns = (int(values[n]) for n in cls._fields[:-1])
        return cls(step, caught_up, dropped, jumps, overruns, lateness)


class LinkFigures(NamedTuple):
    """What a link did since it was activated, in samples, and how punctually (nanoseconds)."""

    received: int
    sent: int
    dropped: int
    duplicated: int
    overtaken: int
    in_flight: int
    delay_p50: object
    delay_p99: object
    error_p50: object
    error_p99: object


class InputFigures(NamedTuple):
    """How the samples of one input came: counts, and durations where there are samples.

    ``age`` is that of the sample used, at the time of the step; ``delay`` the same, at the instant
    of the step.
    """

    received: int
    lost: int
    gaps: int
    out_of_order: int
    not_finite: int
    out_of_range: int
    outliers: int
    period: Percentiles | None
    jitter: Percentiles | None
    age: Percentiles | None
    delay: Percentiles | None

    def values(self, signal: str) -> dict[str, object]:
        """Return them as diagnostics show them."""
        found: dict[str, object] = {}
        for name, value in self._asdict().items():
            if isinstance(value, Percentiles):
                found.update(value.values(f'{signal}.{name}'))
            elif value is not None:
                found[f'{signal}.{name}'] = value
        return found

    @classmethod
    def read(cls, values: Mapping[str, str], signal: str) -> InputFigures | None:
        """Return what :meth:`values` wrote, None where it is not there."""
        if any(f'{signal}.{name}' not in values for name in cls._fields[:7]):
            return None
        received, lost, gaps, late, bad, far, alone = (
            int(values[f'{signal}.{name}']) for name in cls._fields[:7]
        )
        period, jitter, age, delay = (
            Percentiles.read(values, f'{signal}.{name}') for name in cls._fields[7:]
        )
        return cls(received, lost, gaps, late, bad, far, alone, period, jitter, age, delay)


def inputs_in(values: Mapping[str, str]) -> dict[str, InputFigures]:
    """Return the figures of every input that a node reported, by signal."""
    signals = [key.removesuffix(_RECEIVED) for key in values if key.endswith(_RECEIVED)]
    found = {signal: InputFigures.read(values, signal) for signal in signals}
    return {signal: figures for signal, figures in found.items() if figures is not None}
