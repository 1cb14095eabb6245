# SPDX-License-Identifier: Apache-2.0
"""The common grid of ROS time on which all blocks tick: time is a step count times a step size."""

from __future__ import annotations

from fractions import Fraction

SECOND = 1_000_000_000


class TickGrid:
    """Instants k / rate, k = 0, 1, ..., in integer nanoseconds since the clock's zero.

    Nodes of one host, or of hosts with synchronised clocks, share it without talking.
    """

    def __init__(self, rate: float) -> None:
        self._period = SECOND / Fraction(rate).limit_denominator(1_000_000)
        self.period = float(self._period)
        """Nanoseconds between two instants."""

    def stamp(self, k: int) -> int:
        """Return instant ``k`` in nanoseconds, rounded up."""
        return -((-k * self._period.numerator) // self._period.denominator)

    def stamps(self, count: int) -> list[int]:
        """Return the first ``count`` instants in nanoseconds."""
        return [self.stamp(k) for k in range(count)]

    def index(self, stamp: int) -> int:
        """Return the last instant at or before ``stamp`` (nanoseconds)."""
        return stamp * self._period.denominator // self._period.numerator

    def after(self, stamp: int) -> int:
        """Return the first instant strictly after ``stamp`` (nanoseconds)."""
        return self.index(stamp) + 1
