# SPDX-License-Identifier: Apache-2.0
"""What counts as an event, and when events match: the numbers that every verdict rests on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from ..errors import EventregError, ParameterError
from ..models.neuron import FOLD

THRESHOLD = FOLD
RESET = 0.0
SETTLE = 100.0
WINDOW = 5.0
BLIND = 5.0

SEEDS = 20
"""Runs of a random impairment that must all be rejected, for a margin. Where they are, at least
84 % of all such runs are (the lower end of Wilson's interval, 95 %)."""

JUDGED = 300.0
"""Model time after ``settle`` over which a run is judged, unless its duration is given."""


@dataclass(frozen=True)
class Criteria:
    """The limits of the event detector and of the verdict; times in model time.

    Raises ParameterError, one line, unless all are finite, ``reset`` lies below ``threshold``,
    ``blind`` is positive and the other times are not negative.
    """

    threshold: float = THRESHOLD
    """An event begins where the signal rises through this."""
    reset: float = RESET
    """An event ends, and the next may begin, once the signal is at or below this."""
    settle: float = SETTLE
    """Events before this time are not judged."""
    window: float = WINDOW
    """Events at most this far apart may match."""
    blind: float = BLIND
    """Samples further apart than this leave the signal unseen between them."""
    refractory: float = 0.0
    """Dead time: a rise this soon after an event is no event of its own; 0: off."""
    min_width: float = 0.0
    """An event must last at least this long, from its rise to its end; 0: off."""

    @property
    def detector(self) -> tuple[float, float, float, float]:
        """What the event detector takes: threshold, reset, refractory, min_width."""
        return self.threshold, self.reset, self.refractory, self.min_width

    @classmethod
    def of(cls, monitor: Mapping[str, Any]) -> Criteria:
        """Return those in the parameters of a spike monitor."""
        return cls(**{field.name: monitor[field.name] for field in fields(cls)})

    def overridden(self, **given: float | None) -> Criteria:
        """Return the criteria with those of ``given`` that are not None."""
        return replace(self, **{name: x for name, x in given.items() if x is not None})

    def duration(self, usual: float) -> float:
        """Return how long a run takes by default: ``usual``, or longer where it settles late."""
        return max(usual, self.settle + JUDGED)

    def __post_init__(self) -> None:
        if not self.reset < self.threshold:
            raise ParameterError(
                f'reset must be < threshold ({self.threshold:g}), got {self.reset:g}; lower it'
            )
        for field in fields(self):
            _check(field.name, getattr(self, field.name))


def _check(name: str, value: float) -> None:
    signed = name in ('threshold', 'reset')
    positive = name == 'blind'
    if math.isfinite(value) and (signed or value > 0.0 or (value == 0.0 and not positive)):
        return
    rule = 'finite' if signed else f'finite and {">" if positive else ">="} 0'
    raise ParameterError(f'{name} must be {rule}, got {value:g}; give another value')


def need_span(criteria: Criteria, end: float, *, settle: float | None, until: float | None) -> None:
    """Raise EventregError when an explicit ``settle`` or ``until`` leaves nothing to judge.

    ``criteria`` are those with ``settle``, ``end`` is the end of the run; all in model time.
    """
    if settle is not None and settle > end:
        raise EventregError(
            f'settle must lie within the run, which ends at {end:g} of model time, got '
            f'{settle:g}; give an earlier time'
        )
    if until is not None and until <= criteria.settle:
        raise EventregError(
            f'until must be later than {criteria.settle:g}, from when on events count, got '
            f'{until:g}; give a later time'
        )
