# SPDX-License-Identifier: Apache-2.0
"""The clock: publishes simulation time, and grants the steps of lockstep.

Publishes /clock and lockstep/grant, listens to lockstep/reached. Services: ~/pause, ~/resume,
~/step.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header, UInt64
from std_srvs.srv import Trigger

from ..runtime.figures import GRANTED, STEP, WAITING_FOR
from ..runtime.reached import signed_by
from ..runtime.tick_grid import SECOND, TickGrid
from ..scenario.parameter import ACTIVE
from . import topics
from .lockstep import WATCH, Standstill
from .managed import OK, WARN, ManagedNode, Status
from .ros import run_node

Service = Callable[[], str | None]

TICK, IDLE = 0.001, 0.1
"""Seconds between looks at the wall clock: where it holds the steps back, and where not."""

BETWEEN = 0.01
"""Seconds at least between two messages on /clock, while steps go as fast as they can."""

PATIENCE = 2.0
"""Seconds beyond the participants' own limit, so that who knows the link speaks first."""


class ClockNode(ManagedNode):
    """Grants steps to its participants, a window ahead of the slowest; time is the slowest's.

    Without participants it publishes /clock at ``rate`` times ``real_time_factor`` (1 where that is
    0).
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('clock', **kwargs)

    def open(self) -> None:
        """Create the topics and the services pause, resume and step."""
        self.grid = TickGrid(self.values['rate'])
        self.reached = {self._full(name): -1 for name in self.values['participants']}
        self.steady_timer(WATCH, self._watch)
        self.time_publisher = self.publisher_of(topics.CLOCK)
        self.grant_publisher = self.publisher_of(topics.GRANT)
        self.subscription_of(topics.ALL_REACHED, self._on_reached)
        services = {'pause': self._pause, 'resume': self._resume, 'step': self._step}
        for name, work in services.items():
            self.service_of(Trigger, f'~/{name}', self._while_active(work))

    def begin(self) -> None:
        """Start at step 0, granting nothing before every participant is there."""
        self.granted = self.announced = -1
        self._standstill = Standstill()
        self._announce_at = 0.0
        self.paused = False
        self.allowance = 0
        rate = self.values['rate']
        self.pauses = sorted({round(t * rate) for t in self.values['pause_at']})
        self._paced_from = max(self.now_at, 0)
        self._begun = time.monotonic()
        paced = self.values['real_time_factor'] or not self.reached
        self._wall = self.steady_timer(TICK if paced else IDLE, self._move)
        self._move()

    def changed(self) -> None:
        """Pace from here on with the new real_time_factor."""
        if self.stage == ACTIVE:
            self._restart_pace()

    def _full(self, name: str) -> str:
        namespace = self.get_namespace().rstrip('/')
        return name if name.startswith('/') else f'{namespace}/{name}'

    def _on_reached(self, message: Header) -> None:
        stamp = message.stamp.sec * SECOND + message.stamp.nanosec
        name, rate = signed_by(message.frame_id)
        if name not in self.reached:
            return
        if rate != self.values['rate'] and self.stage == ACTIVE and self.fault is None:
            self.fail(
                f'lockstep stopped: {name} has rate {rate}, the clock {self.values["rate"]:g}; '
                'give all nodes the same rate'
            )
            return
        self.reached[name] = max(self.grid.index(stamp), self.reached[name])
        if self.stage == ACTIVE:
            self._move()

    @property
    def now_at(self) -> int:
        """The step that everybody has reached."""
        return min(self.reached.values(), default=self.granted)

    def _move(self) -> None:
        """Grant what may be granted, and publish the time."""
        at = self.now_at
        if at < 0 and self.reached:
            return  # somebody is not there yet
        may = self._limit(at)
        if may > self.granted:
            self.granted = may
            self.send(self.grant_publisher, UInt64(data=may))
        at, wall = self.now_at, time.monotonic()
        if at > self.announced and (wall >= self._announce_at or at == self.granted):
            self.announced, self._announce_at = at, wall + BETWEEN
            now = Time(nanoseconds=self.grid.stamp(at)).to_msg()
            self.send(self.time_publisher, Clock(clock=now))

    def _watch(self) -> None:
        """Fail when those that are behind do not say why: they may be stopped or gone."""
        if self.stage != ACTIVE or self.fault is not None or not self.behind():
            return
        limit = self.values['lockstep_timeout'] + PATIENCE
        still = self._standstill.look((self.now_at, self.granted))
        if self.now_at >= 0 and still >= limit:
            self.fail(
                f'lockstep stopped: {", ".join(self.behind())} made no step beyond {self.now_at} '
                f'for {limit:g} s though {self.granted} are granted; look whether it still runs'
            )

    def behind(self) -> list[str]:
        """Return the participants that all others wait for; before the start, those not there."""
        at = self.now_at
        waits = at < 0 or at < self.granted
        return [name for name, n in self.reached.items() if n == at and waits]

    def _limit(self, at: int) -> int:
        """Return the last step that may be granted when everybody has reached ``at``."""
        if self.paused:
            return self.allowance
        limit = at + int(self.values['window']) if self.reached else self.granted + 10**9
        factor = self.values['real_time_factor'] or (0.0 if self.reached else 1.0)
        if factor:
            elapsed = time.monotonic() - self._begun
            limit = min(limit, self._paced_from + int(elapsed * factor * self.values['rate']))
        if self.pauses:
            limit = min(limit, self.pauses[0])
        steps = int(self.values['steps'])
        return min(limit, steps) if steps else limit

    def _restart_pace(self) -> None:
        self._paced_from = max(self.granted, 0)
        self._begun = time.monotonic()
        paced = self.values['real_time_factor'] or not self.reached
        self._wall.timer_period_ns = round((TICK if paced else IDLE) * SECOND)
        self._wall.reset()
        self._move()

    def _while_active(self, work: Service) -> Callable[[Trigger.Request, Any], Trigger.Response]:
        """Return a service that does ``work`` while the clock is active, and else refuses.

        ``work`` returns why it refuses, None when it has done what was asked.
        """

        def serve(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            active = self.stage == ACTIVE
            refusal = work() if active else f'the clock is {self.stage}; activate it first'
            response.success = refusal is None
            at = f'at step {self.now_at}, granted up to {self.granted}' if active else ''
            response.message = refusal or at
            return response

        return serve

    def _pause(self) -> None:
        self.paused = True
        self.allowance = self.granted

    def _resume(self) -> None:
        self.paused = False
        self.pauses = [step for step in self.pauses if step > self.granted]
        self._restart_pace()

    def _step(self) -> str | None:
        if not self.paused:
            return 'the clock runs; pause it first'
        wanted, steps = max(self.granted, 0) + 1, int(self.values['steps'])
        if steps and wanted > steps:
            return f'step {steps} was the last one'
        self.allowance = wanted
        self._move()
        return None

    def report(self) -> Status:
        """Return the step, the grant, and who is behind; WARN while somebody is not there yet."""
        at = self.now_at
        values = {STEP: at, GRANTED: self.granted, WAITING_FOR: ' '.join(self.behind())}
        if at < 0 and self.reached:
            return Status(WARN, f'waiting for {", ".join(self.behind())}', values)
        return Status(OK, 'paused' if self.paused else 'running', values)


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(ClockNode)


if __name__ == '__main__':
    sys.exit(main())
