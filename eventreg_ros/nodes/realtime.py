# SPDX-License-Identifier: Apache-2.0
"""The pace of the ROS clock: all nodes tick on a common grid, and nobody is late for long."""

from __future__ import annotations

import math
import time
from typing import Any, NamedTuple

from ..runtime.duration_histogram import DurationHistogram
from ..runtime.figures import LATE, TickFigures
from ..runtime.tick_grid import SECOND, TickGrid
from .endpoints import Endpoints
from .managed import ERROR, OK, WARN, FaultError, Status
from .pace import Tick, Work

_AWAKE = 500_000
"""Nanoseconds for which the start of the timer is awaited awake: sleep is not that precise."""

_TRIES = 10
_LONG = 20_000_000
"""Nanoseconds of a period from which on its phase is not worth waiting for."""


class Timing(NamedTuple):
    """The parameters of the pace: steps per second, and seconds or steps as the table says."""

    rate: float
    precision: float
    start_time: float
    max_catch_up: float
    late_warn: float
    late_error: float


class RealTime:
    """Publishes sample n at the instant n of the grid after the start.

    How many steps are due is read from the clock at every tick: late and skipped ticks are caught
    up, and only the newest sample is published, so that model time follows ROS time.
    """

    def __init__(self, work: Work, timing: Timing, endpoints: Endpoints) -> None:
        """Take the clock and the timer of ``endpoints``."""
        self._work, self._timing, self._endpoints = work, timing, endpoints
        self._clock, self._log = endpoints.get_clock(), endpoints.get_logger()
        self.grid = TickGrid(timing.rate)
        self._fractional = self.grid.period != int(self.grid.period)
        self._start = round(timing.start_time * SECOND)
        self.origin: int | None = None
        self.n = -1
        self.caught_up = self.dropped = self.clock_jumps = 0
        self.lateness = DurationHistogram()
        self.overruns = 0
        self._reported_dropped = 0
        self._reported_n = -1
        self._now_at_tick = 0

    def begin(self) -> None:
        """Start ticking at the next instant of the grid, or at ``start_time``."""
        simulated = self._endpoints.in_simulation_time
        early = min(self._timing.precision * SECOND, 0.5 * self.grid.period)
        self._early = 0 if simulated else round(early)
        self._timer: Any = self._endpoints.ros_timer(1.0 / self._timing.rate, self._tick)
        if not simulated:
            self._align()
        self.origin = self._first_instant()

    def go(self) -> None:
        """Do nothing: steps are due by the clock."""

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
        if self.origin is None:
            self.origin = self._first_instant()
            return
        if self._fractional:
            # rcl counts whole nanoseconds; the period after the next instant makes up for it.
            k = self.grid.index(now)
            self._timer.timer_period_ns = self.grid.stamp(k + 2) - self.grid.stamp(k + 1)
        due = self.grid.index(now) - self.origin
        if self.n >= 0 and due < self.n - self._timing.rate:
            self.origin -= self.n - due
            self.clock_jumps += 1
            self._log.warning('the clock went back; model time goes on from where it was')
        elif due > self.n:
            self._take(due, now, self.origin)

    def _take(self, due: int, now: int, origin: int) -> None:
        """Take all steps up to sample ``due`` and publish it."""
        late = now - self.grid.stamp(origin + (self.n + 1 if self.n >= 0 else due))
        self._work.poll()
        try:
            self._work.put(self._until(due, now, origin))
        except FaultError as fault:
            self._work.fail(str(fault))
            return
        self.lateness.add(late / SECOND)
        assert self.origin is not None
        if self._now() > self.grid.stamp(self.origin + self.n + 1):
            self.overruns += 1

    def _until(self, due: int, now: int, origin: int) -> float:
        """Take the steps up to sample ``due``, as many as may be caught up, and return the last."""
        work, value = self._work, math.nan
        if self.n < 0:
            value, self.n = work.first(), 0
        excess = due - self.n - max(1, int(self._timing.max_catch_up * self._timing.rate))
        if excess > 0:
            origin += excess
            self.origin = origin
            self.dropped += excess
            due -= excess
            self._log.warning(
                f'{excess} steps dropped after a pause: model time is late by '
                f'{self.dropped / self._timing.rate:.3f} s'
            )
        self.caught_up += max(0, due - self.n - 1)
        grid = self.grid
        while self.n < due:
            value = work.following(Tick(self.n, grid.stamp(origin + self.n), now, grid.period))
            self.n += 1
        return value

    def report(self) -> Status:
        """Return the figures of the ticks; WARN when model time was lost."""
        figures = TickFigures(
            self.n,
            self.caught_up,
            self.dropped,
            self.clock_jumps,
            self.overruns,
            self.lateness.percentiles,
        )
        level, message = self._judge()
        return Status(level, message, figures.values())

    def _judge(self) -> tuple[bytes, str]:
        if self._endpoints.in_simulation_time and self.n == self._reported_n:
            return WARN, 'waits for /clock' if self.n < 0 else '/clock stands still'
        self._reported_n = self.n
        steps_late = self.lateness.take_recent() * self._timing.rate
        if steps_late >= self._timing.late_warn:
            level = ERROR if steps_late >= self._timing.late_error else WARN
            return level, f'{LATE} {steps_late:.1f} steps late'
        if self.dropped > self._reported_dropped:
            self._reported_dropped = self.dropped
            return WARN, f'{self.dropped} steps dropped'
        return OK, 'running'
