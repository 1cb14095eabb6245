"""What has arrived of one input in lockstep: its samples by number, without a gap."""

from __future__ import annotations

import math
from collections import deque

from ..simulation.hold import line

UNNUMBERED = 'a sample came without a number, which lockstep needs; use rmw_fastrtps_cpp'


def flaw(number: int | None, expected: int, whose: str = '') -> str | None:
    """Say what is wrong when sample ``number`` comes in place of ``expected``; None: a repetition.

    ``whose`` follows the sample's number in the words, as ' of y' does.
    """
    if number is None:
        return UNNUMBERED
    return f'sample {expected}{whose} was lost' if number > expected else None


class SequencedInput:
    """The samples of one input, by number from 0."""

    def __init__(self) -> None:
        self._kept: deque[float] = deque()
        self._first = 0
        self.received = 0
        self.flaw: str | None = None
        """What went wrong with the samples, None while they are sound and complete."""

    def push(self, number: int | None, value: float) -> None:
        """Take sample ``number``; a gap or a value that is not finite is noted as the flaw."""
        if self.flaw is not None:
            return
        if number != self.received:
            self.flaw = flaw(number, self.received)
        elif not math.isfinite(value):
            self.flaw = f'sample {number} is {value}'
        else:
            self._kept.append(value)
            self.received += 1

    def has(self, n: int) -> bool:
        """Say whether sample ``n`` has come."""
        return n < self.received

    def over(self, n: int, horizon: float) -> tuple[float, float]:
        """Return the input's (base, slope) over step ``n``, from the samples up to ``n``.

        Steps are asked for in order, each once ``has`` says so. ``horizon`` is in steps, see
        :func:`.hold.line`.
        """
        while self._first < n - 1:
            self._kept.popleft()
            self._first += 1
        newest = self._kept[n - self._first]
        if n == 0:
            return line(newest, newest, 0.0, 1.0, horizon)
        return line(newest, self._kept[n - 1 - self._first], 0.0, 1.0, horizon)
