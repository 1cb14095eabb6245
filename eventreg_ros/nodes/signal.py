"""A node that publishes one signal on the common grid of the ROS clock."""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.qos import QoSProfile
from std_msgs.msg import Float64

from ..simulation.grid import SECOND, Grid
from .managed import OK, WARN, FaultError, ManagedNode

SIGNAL_QOS = QoSProfile(depth=100)
"""Reliable and volatile; deep enough for half a second at the default rate."""


class SignalNode(ManagedNode):
    """Publishes sample n of ``output`` at the instant n of the grid after its start.

    A subclass gives ``first() -> value`` and ``following(n) -> value``, the step from sample n to
    sample n + 1. How many steps are due is read from the clock at every tick: late and skipped
    ticks are caught up, and only the newest sample is published, so that model time follows ROS
    time.
    """

    def first(self) -> float:
        """Return sample 0."""
        raise NotImplementedError

    def following(self, n: int) -> float:
        """Take the step from sample ``n`` and return sample ``n`` + 1."""
        raise NotImplementedError

    def open(self) -> None:
        """Create the publisher of the output."""
        self.publisher = self.advertise(Float64, self.values['output'], SIGNAL_QOS)

    def shut(self) -> None:
        """Destroy the publisher."""
        if hasattr(self, 'publisher'):
            self.destroy_lifecycle_publisher(self.publisher)
            del self.publisher

    def begin(self) -> None:
        """Start ticking at the next instant of the grid, or at ``start_time``."""
        clock = self.get_clock()
        self.grid = Grid(self.values['rate'])
        if not self.in_simulation_time:
            # rcl timers keep the phase in which they were created: begin at an instant.
            now = clock.now().nanoseconds
            time.sleep((self.grid.stamp(self.grid.after(now)) - now) / SECOND)
        self.timer = self.create_timer(1.0 / self.values['rate'], self._tick)
        start = round(self.values['start_time'] * SECOND)
        self.origin = self.grid.after(max(clock.now().nanoseconds, start - 1))
        self.n = -1
        self.caught_up = self.dropped = self.clock_jumps = 0
        self.lateness = self.worst_lateness = 0.0

    def end(self) -> None:
        """Stop ticking and leave the output at 0."""
        self.timer.cancel()
        self.destroy_timer(self.timer)
        self.send(self.publisher, Float64(data=0.0))

    def _tick(self) -> None:
        now = self.get_clock().now().nanoseconds
        due = self.grid.index(now) - self.origin
        if self.n >= 0 and due < self.n - self.values['rate']:
            self.origin -= self.n - due
            self.clock_jumps += 1
            self.get_logger().warning('the clock went back; model time goes on from where it was')
            return
        if due <= self.n:
            return
        try:
            self.send(self.publisher, Float64(data=self._until(due)))
        except FaultError as fault:
            self.break_off(str(fault))
            return
        self.lateness = (now - self.grid.stamp(self.origin + self.n)) / SECOND
        self.worst_lateness = max(self.worst_lateness, self.lateness)

    def _until(self, due: int) -> float:
        """Take the steps up to sample ``due``, as many as may be caught up, and return the last."""
        value = math.nan
        if self.n < 0:
            value, self.n = self._sound(self.first()), 0
        excess = due - self.n - max(1, int(self.values['max_catch_up'] * self.values['rate']))
        if excess > 0:
            self.origin += excess
            self.dropped += excess
            due -= excess
            self.get_logger().warning(
                f'{excess} steps dropped after a pause: model time is late by '
                f'{self.dropped / self.values["rate"]:.3f} s'
            )
        self.caught_up += max(0, due - self.n - 1)
        while self.n < due:
            value = self._sound(self.following(self.n))
            self.n += 1
        return value

    def _sound(self, value: float) -> float:
        if not math.isfinite(value):
            raise FaultError(
                f'the state of {self.kind} stopped being finite at step {self.n + 1}; '
                'lower time_scale or raise rate, and look at the inputs'
            )
        return value

    def report(self) -> tuple[bytes, str, dict[str, object]]:
        """Return the figures of the ticks; WARN when model time was lost."""
        values: dict[str, Any] = {
            'step': self.n,
            'caught_up': self.caught_up,
            'dropped': self.dropped,
            'clock_jumps': self.clock_jumps,
            'lateness': f'{self.lateness:.6f}',
            'worst_lateness': f'{self.worst_lateness:.6f}',
        }
        self.worst_lateness = 0.0
        if self.dropped:
            return WARN, f'{self.dropped} steps dropped', values
        return OK, 'running', values

    def matches(self) -> dict[str, int]:
        """Return the number of subscribers of the output."""
        if not hasattr(self, 'publisher'):
            return {}
        return {f'{self.values["output"]}.subscribers': self.publisher.get_subscription_count()}
