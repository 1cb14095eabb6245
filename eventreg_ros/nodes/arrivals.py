# SPDX-License-Identifier: Apache-2.0
"""The inputs of a block that reads them by number: each sample once, by the step that made it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Protocol

from ..control.predicting_block import Heard
from ..runtime.figures import LEAD
from ..runtime.stamped_input import GUARD
from ..runtime.tick_grid import SECOND
from ..runtime.waiting_input import WaitingInput
from .endpoints import Endpoints
from .managed import OK, WARN, Status
from .pace import Lines, Tick
from .sequenced import SequencedInputs
from .stamped import StampedInputs


class Arrivals(Protocol):
    """Inputs that hand out what has come since the step before."""

    def heard(self, tick: Tick) -> list[Heard]:
        """Return the samples that came, but those of the step's end or later."""


class SequencedArrivals(SequencedInputs):
    """In lockstep: one sample of every input for every step."""

    def heard(self, tick: Tick) -> list[Heard]:
        """Return the samples that the step uses."""
        found = enumerate(samples.newest(tick.n) for samples in self.samples)
        return [Heard(i, *newest) for i, newest in found if newest is not None]


class StampedArrivals(StampedInputs):
    """In real time: samples by their time stamps, those of before any relay.

    A sample belongs to the last instant of the grid before its stamp, or to the next one where it
    is only a little early.
    """

    silence = 'it is skipped'

    def __init__(self, signals: Iterable[str], node: Endpoints) -> None:
        super().__init__({signal: WaitingInput() for signal in signals}, node)

    def over(self, tick: Tick) -> Lines:
        """Use up what has come."""
        self.heard(tick)
        return Lines((), ())

    def heard(self, tick: Tick) -> list[Heard]:
        """Return the samples that came since the step before."""
        end = tick.start + (1.0 - GUARD) * tick.period
        patience = (self.timeout + self.lead.seconds) * SECOND
        found = []
        for i, samples in enumerate(self.samples):
            assert isinstance(samples, WaitingInput)
            for stamp, value in samples.take(end):
                n = tick.n + math.floor((stamp - tick.start) / tick.period + GUARD)
                found.append(Heard(i, n, value))
            last = samples.last_stamp
            self._watch(i, last is not None and tick.start - last > patience)
            if last is not None:
                self.ages[i].add((tick.now - last) / SECOND)
        return found

    def _judge_lead(self) -> list[Status]:
        """Return what to report where y is so late that it is skipped before it comes."""
        found = []
        patience = self.timeout + self.lead.seconds
        for i, signal in enumerate(self.signals):
            delay = self.delays[i].take_recent()
            if delay > patience:
                words = (
                    f'{signal} takes {delay * 1e3:.0f} ms, more than lead and input_timeout '
                    f'({patience * 1e3:.0f} ms), so that it is skipped; set -p '
                    f'/**.lead:={self.lead.needed(delay):g}'
                )
                found.append(Status(WARN, words, {}))
        return found or [Status(OK, '', {LEAD: f'{self.lead.lead:g}'})]
