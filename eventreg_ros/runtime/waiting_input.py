# SPDX-License-Identifier: Apache-2.0
"""What has arrived of one input ahead of its time: samples wait until they are due."""

from __future__ import annotations

import heapq

from .stamped_input import GUARD, JUMP, RESTART, StampedInput
from .tick_grid import SECOND


class WaitingInput(StampedInput):
    """The samples of one input, each due ``lead`` ns after its time stamp.

    One that was overtaken by others is used like them as long as its time has not come.
    """

    def __init__(self) -> None:
        super().__init__()
        self.lead = 0
        self.late = 0
        """Samples that came after the step that would have used them first."""
        self._waiting: list[tuple[int, float]] = []
        self._taken: float | None = None

    def push(self, stamp: int, value: float, number: int | None = None) -> bool:
        """Take a sample; see :meth:`.stamped_input.StampedInput.push`."""
        past = self._taken is not None and stamp < self._taken
        self.late += past
        newest = self._newest
        if newest is not None and not past and 0 < newest[0] - stamp <= RESTART * SECOND:
            return self._insert(stamp, value, newest[1])
        return super().push(stamp, value, number)

    def _insert(self, stamp: int, value: float, near: float) -> bool:
        """Take a sample that was overtaken, and so counted as lost."""
        if not abs(value) <= self.limit or abs(value - near) > JUMP:
            self._drop(value)
            return False
        self.received += 1
        self.lost = max(0, self.lost - 1)
        heapq.heappush(self._waiting, (stamp, value))
        return True

    def _keep(self, sample: tuple[int, float]) -> None:
        self._newest = sample
        heapq.heappush(self._waiting, sample)

    def _forget(self) -> None:
        super()._forget()
        self._waiting.clear()
        self._taken = None

    @property
    def begun(self) -> bool:
        """Whether a sample has been due yet."""
        return bool(self._kept)

    def over(
        self, start: int, period: float, timeout: float, horizon: float
    ) -> tuple[float, float] | None:
        """Return the input's line over a step, as it is played."""
        played = start - self.lead
        self.take(played + (1.0 - GUARD) * period)
        return super().over(played, period, timeout, horizon)

    def take(self, end: float) -> list[tuple[int, float]]:
        """Return what was stamped before ``end`` (ns) and not taken before, in order."""
        taken: list[tuple[int, float]] = []
        self._taken = end
        while self._waiting and self._waiting[0][0] < end:
            sample = heapq.heappop(self._waiting)
            if not self._kept or sample[0] > self._kept[-1][0]:
                self._kept.append(sample)
                taken.append(sample)
        return taken
