"""The pace of the ROS clock: all nodes tick on a common grid, and nobody is late for long."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

from ..simulation.grid import SECOND, Grid
from .managed import OK, WARN, FaultError

if TYPE_CHECKING:
    from .signal import SignalNode


class RealTime:
    """Publishes sample n at the instant n of the grid after the start.

    How many steps are due is read from the clock at every tick: late and skipped ticks are caught
    up, and only the newest sample is published, so that model time follows ROS time.
    """

    def __init__(self, node: SignalNode) -> None:
        """Start ticking at the next instant of the grid, or at ``start_time``."""
        self._node = node
        self._clock = node.get_clock()
        self._rate: float = node.values['rate']
        self.grid = Grid(self._rate)
        if not node.in_simulation_time:
            # rcl timers keep the phase in which they were created: begin at an instant.
            now = self._now()
            time.sleep((self.grid.stamp(self.grid.after(now)) - now) / SECOND)
        self._timer = node.create_timer(1.0 / self._rate, self._tick)
        start = round(node.values['start_time'] * SECOND)
        self.origin = self.grid.after(max(self._now(), start - 1))
        self.n = -1
        self.caught_up = self.dropped = self.clock_jumps = 0
        self._lateness = self._worst_lateness = 0.0

    def end(self) -> None:
        """Stop ticking."""
        self._timer.cancel()
        self._node.destroy_timer(self._timer)

    def _now(self) -> int:
        return int(self._clock.now().nanoseconds)

    def _tick(self) -> None:
        now = self._now()
        due = self.grid.index(now) - self.origin
        if self.n >= 0 and due < self.n - self._rate:
            self.origin -= self.n - due
            self.clock_jumps += 1
            self._node.get_logger().warning(
                'the clock went back; model time goes on from where it was'
            )
            return
        if due <= self.n:
            return
        try:
            self._node.put(self._until(due))
        except FaultError as fault:
            self._node.break_off(str(fault))
            return
        self._lateness = (now - self.grid.stamp(self.origin + self.n)) / SECOND
        self._worst_lateness = max(self._worst_lateness, self._lateness)

    def _until(self, due: int) -> float:
        """Take the steps up to sample ``due``, as many as may be caught up, and return the last."""
        node, value = self._node, math.nan
        if self.n < 0:
            value, self.n = node.sound(node.first()), 0
        excess = due - self.n - max(1, int(node.values['max_catch_up'] * self._rate))
        if excess > 0:
            self.origin += excess
            self.dropped += excess
            due -= excess
            node.get_logger().warning(
                f'{excess} steps dropped after a pause: model time is late by '
                f'{self.dropped / self._rate:.3f} s'
            )
        self.caught_up += max(0, due - self.n - 1)
        while self.n < due:
            value = node.sound(node.following(self.n))
            self.n += 1
        return value

    def report(self) -> tuple[bytes, str, dict[str, Any]]:
        """Return the figures of the ticks; WARN when model time was lost."""
        values: dict[str, Any] = {
            'step': self.n,
            'caught_up': self.caught_up,
            'dropped': self.dropped,
            'clock_jumps': self.clock_jumps,
            'lateness': f'{self._lateness:.6f}',
            'worst_lateness': f'{self._worst_lateness:.6f}',
        }
        self._worst_lateness = 0.0
        if self.dropped:
            return WARN, f'{self.dropped} steps dropped', values
        return OK, 'running', values
