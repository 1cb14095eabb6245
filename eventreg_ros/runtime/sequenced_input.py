# SPDX-License-Identifier: Apache-2.0
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
    """The samples of one input, by number from 0.

    Sample s comes ``delay`` steps after it was made and is played ``lead`` steps after that; until
    then the input counts as 0.
    """

    def __init__(self, delay: int = 0, lead: int = 0) -> None:
        self.late = max(delay, lead)
        """Steps after it was made at which a sample is used first."""
        self._age = float(self.late - lead)
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
        """Say whether all has come that step ``n`` uses."""
        return n - self.late < self.received

    def over(self, n: int, horizon: float) -> tuple[float, float]:
        """Return the input's (base, slope) over step ``n``.

        Steps are asked for in order, each once ``has`` says so. ``horizon`` is in steps, see
        :func:`.hold.line`.
        """
        newest = self.newest(n)
        if newest is None:
            return 0.0, 0.0
        number, value = newest
        previous = value if number == 0 else self._kept[number - 1 - self._first]
        return line(value, previous, self._age, 1.0, horizon)

    def newest(self, n: int) -> tuple[int, float] | None:
        """Return number and value of the last sample that step ``n`` uses, None before the first.

        Asked for as :meth:`over` is.
        """
        number = n - self.late
        if number < 0:
            return None
        while self._first < number - 1:
            self._kept.popleft()
            self._first += 1
        return number, self._kept[number - self._first]
