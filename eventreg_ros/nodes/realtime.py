"""The pace of the ROS clock: all nodes tick on a common grid, and nobody is late for long."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

from ..runtime.duration_histogram import DurationHistogram
from ..runtime.tick_grid import SECOND, TickGrid
from .managed import ERROR, OK, WARN, FaultError

if TYPE_CHECKING:
    from .signal import SignalNode


_AWAKE = 500_000
"""Nanoseconds for which the start of the timer is awaited awake: sleep is not that precise."""


_TRIES = 10
_LONG = 20_000_000
"""Nanoseconds of a period from which on its phase is not worth waiting for."""


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
        self.grid = TickGrid(self._rate)
        most = 0.5 * self.grid.period
        early = min(node.values['precision'] * SECOND, most)
        self._early = 0 if node.in_simulation_time else round(early)
        self._timer = node.create_timer(1.0 / self._rate, self._tick)
        self._fractional = self.grid.period != int(self.grid.period)
        if not node.in_simulation_time:
            self._align()
        self._start = round(node.values['start_time'] * SECOND)
        self.origin = self._first_instant()
        self.n = -1
        self.caught_up = self.dropped = self.clock_jumps = 0
        self.lateness = DurationHistogram()
        self.overruns = 0
        self._told_dropped = 0
        self.now = 0
        """ROS time of the tick under way, in nanoseconds."""

    def _align(self) -> None:
        """Let the timer go off at the instants of the grid, or ``precision`` before them.

        rcl timers keep the phase in which they were reset. On a busy machine we may be put aside
        just then, so look, and try again.
        """
        for _ in range(_TRIES if self.grid.period < _LONG else 0):
            now = self._now()
            begin = self.grid.stamp(self.grid.after(now + self._early + _AWAKE)) - self._early
            time.sleep((begin - now - _AWAKE) / SECOND)
            while self._now() < begin:
                pass
            self._timer.reset()
            next_call = self._now() + self._timer.time_until_next_call() + self._early
            if next_call - self.grid.stamp(self.grid.index(next_call)) < _AWAKE // 10:
                return

    def end(self) -> None:
        """Stop ticking."""
        self._timer.cancel()
        self._node.destroy_timer(self._timer)

    def _first_instant(self) -> int | None:
        """Return the instant of sample 0; None while simulation time has not begun."""
        now = self._now()
        return self.grid.after(max(now + self._early, self._start - 1)) if now else None

    def _now(self) -> int:
        return int(self._clock.now().nanoseconds)

    def _tick(self) -> None:
        now = self._now()
        if self._early:
            instant = self.grid.stamp(self.grid.after(now))
            while now < instant <= now + self._early:
                now = self._now()
        self.now = now
        if self.origin is None:
            self.origin = self._first_instant()
            return
        if self._fractional:
            # rcl counts whole nanoseconds; the period after the next instant makes up for it.
            k = self.grid.index(now)
            self._timer.timer_period_ns = self.grid.stamp(k + 2) - self.grid.stamp(k + 1)
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
        late = now - self.grid.stamp(self.origin + (self.n + 1 if self.n >= 0 else due))
        try:
            self._node.put(self._until(due))
        except FaultError as fault:
            self._node.break_off(str(fault))
            return
        self.lateness.add(late / SECOND)
        if self._now() > self.grid.stamp(self.origin + self.n + 1):
            self.overruns += 1

    def _until(self, due: int) -> float:
        """Take the steps up to sample ``due``, as many as may be caught up, and return the last."""
        node, value = self._node, math.nan
        if self.n < 0:
            value, self.n = node.sound(node.first()), 0
        assert self.origin is not None
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
            'overruns': self.overruns,
            **self.lateness.figures('lateness'),
        }
        steps_late = self.lateness.take_recent() * self._rate
        warn, error = self._node.values['late_warn'], self._node.values['late_error']
        if steps_late >= warn:
            level = ERROR if steps_late >= error else WARN
            return level, f'the last second had a tick {steps_late:.1f} steps late', values
        if self.dropped > self._told_dropped:
            self._told_dropped = self.dropped
            return WARN, f'{self.dropped} steps dropped', values
        return OK, 'running', values
