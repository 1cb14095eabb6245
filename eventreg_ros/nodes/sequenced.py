# SPDX-License-Identifier: Apache-2.0
"""The inputs of a node in lockstep: by the number that the writer gave each sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ..runtime.cdr import unpacked
from ..runtime.figures import received_of
from ..runtime.sequenced_input import SequencedInput
from .endpoints import InfoCallback
from .info import number_of
from .managed import OK, Status
from .pace import Lines, Tick


class Schedule(NamedTuple):
    """When the samples of an input come and when they are played, in steps after they were made."""

    delay: int = 0
    lead: int = 0


class SequencedInputs:
    """All inputs of a node, by their names in the order in which they are summed.

    ``horizons`` are those of their lines, in steps.
    """

    def __init__(self, signals: Mapping[str, Schedule]) -> None:
        self.signals = tuple(signals)
        self.horizons: Sequence[float] = [0.0] * len(signals)
        self.quiet: list[str] = []  # nobody falls silent here: a step waits
        self.samples = [SequencedInput(*schedule) for schedule in signals.values()]

    def receiver(self, i: int, go: Callable[[], None]) -> InfoCallback:
        """Return the callback of input ``i``; a step may have waited for its sample."""
        push = self.samples[i].push

        def receive(data: bytes, info: dict[str, Any]) -> None:
            push(number_of(info), unpacked(data))
            go()

        return receive

    def ready(self, n: int) -> bool:
        """Say whether all samples have come that step ``n`` uses."""
        for samples in self.samples:  # noqa: SIM110 (all() takes twice as long)
            if samples.received <= n - samples.late:
                return False
        return True

    def missing(self, n: int) -> list[str]:
        """Return the samples that step ``n`` waits for, and what is wrong with them."""
        return [
            f'sample {n - samples.late} of input {signal}'
            + (f' ({samples.flaw})' if samples.flaw else '')
            for signal, samples in zip(self.signals, self.samples, strict=True)
            if not samples.has(n)
        ]

    def over(self, tick: Tick) -> Lines:
        """Return the lines of all inputs, from their samples up to the tick's."""
        base, slope = [], []
        for samples, horizon in zip(self.samples, self.horizons, strict=True):
            b, s = samples.over(tick.n, horizon)
            base.append(b)
            slope.append(s)
        return Lines(base, slope)

    def report(self) -> list[Status]:
        """Return how many samples came."""
        pairs = zip(self.signals, self.samples, strict=True)
        return [Status(OK, '', {received_of(signal): s.received for signal, s in pairs})]
