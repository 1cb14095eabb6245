# SPDX-License-Identifier: Apache-2.0
"""Lockstep: step n uses exactly sample n of every input, whatever the load and the order.

A deterministic dataflow. Samples are identified by the number that their writer gives them
(``publication_sequence_number``), not by time. The clock node grants steps, a window at a time;
each participant reports how far it got, and a step whose sample does not come within a limit stops
the node with a message that names the link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.time import Time
from std_msgs.msg import Header, UInt64

from ..runtime.figures import GRANTED, STEP
from ..runtime.reached import signature
from ..runtime.tick_grid import TickGrid
from ..scenario.parameter import UNCONFIGURED
from .managed import OK, FaultError, ManagedNode, Status
from .pace import Inputs, Tick, Work
from .topics import GRANT, REACHED

EVERY = 75
"""A participant reports every so many steps how far it got, and where the grant ends."""

WATCH = 0.5
"""Seconds between looks at whether there is progress."""


class Standstill:
    """For how long nothing has moved, by looks every :data:`WATCH` seconds.

    Not by time: after a stop of our own the messages of others come after the timer that looks.
    """

    def __init__(self) -> None:
        self._state: Any = None
        self._looks = 0

    def look(self, state: object) -> float:
        """Return the seconds for which ``state`` has been the same."""
        self._looks = self._looks + 1 if state == self._state else 0
        self._state = state
        return self._looks * WATCH


class Participant:
    """One node's part in the exchange with the clock.

    ``go`` is called when more steps are granted; ``missing()`` names the samples that the node
    waits for. ``granted`` is the number of the last sample that may be made. Raises FaultError when
    a signal has two writers: their numbers mix.
    """

    def __init__(
        self, node: ManagedNode, go: Callable[[], None], missing: Callable[[], list[str]]
    ) -> None:
        self._node, self._go, self._missing = node, go, missing
        if several := node.several_writers():
            raise FaultError(f'lockstep: {several}')
        rate = node.values['rate']
        self._signature = signature(node.get_fully_qualified_name(), rate)
        self._grid = TickGrid(rate)
        self._patience: float = node.values['lockstep_timeout']
        self.granted = 0
        self.reached = self._reported = -1
        self._armed = False
        self._standstill = Standstill()
        self._publisher = node.publisher_of(REACHED)
        node.subscription_of(GRANT, self._on_grant)
        self._watchdog = node.steady_timer(WATCH, self._watch)

    def stamp(self, n: int) -> int:
        """Return the simulation time of sample ``n`` in nanoseconds."""
        return self._grid.stamp(n)

    @property
    def period(self) -> float:
        """Nanoseconds between two samples."""
        return self._grid.period

    def reach(self, n: int) -> None:
        """Note that all samples up to ``n`` are made, and report it where the clock has to know."""
        before, self.reached = self.reached, n
        if n // EVERY > before // EVERY or n == self.granted:
            self._report(n)

    def _report(self, n: int) -> None:
        self._reported = n
        stamp = Time(nanoseconds=self._grid.stamp(n)).to_msg()
        self._node.send(self._publisher, Header(stamp=stamp, frame_id=self._signature))

    def _on_grant(self, message: UInt64) -> None:
        self.granted = message.data
        self._armed = True  # before the first grant somebody may still be starting
        self._go()
        if self.reached == self.granted:
            self._report(self.reached)

    def _watch(self) -> None:
        """Report slow progress to the clock, and stop where there is none."""
        if self._node.stage == UNCONFIGURED or self._node.fault is not None:
            return
        if several := self._node.several_writers():
            self._node.fail(f'lockstep: {several}')
            return
        if self.reached != self._reported:
            self._report(self.reached)
        still = self._standstill.look((self.reached, self.granted))
        if self._armed and self.reached < self.granted and still >= self._patience:
            self._node.fail(
                f'lockstep stopped: {self._node.label} waits for '
                f'{", ".join(self._missing()) or "nothing"}, which did not come within '
                f'{self._patience:g} s; look at who publishes it'
            )


class Lockstep:
    """Publishes sample n + 1 as soon as sample n of every input is there and the step granted."""

    def __init__(
        self, work: Work, inputs: Inputs, join: Callable[[Callable[[], None]], Participant]
    ) -> None:
        """``join`` makes this pace a participant: it is given :meth:`go`."""
        self._work, self._inputs, self._join = work, inputs, join
        self.n = -1
        self._stopped = False

    def begin(self) -> None:
        """Publish sample 0 and take the steps that are granted already."""
        self.participant = self._join(self.go)
        self._put(self._work.first())
        self.go()

    def missing(self) -> list[str]:
        """Return the samples that the next step waits for."""
        return self._inputs.missing(max(self.n, 0))

    def go(self) -> None:
        """Take every step that is granted and whose samples are there."""
        if self._stopped or self.n < 0:
            return
        participant = self.participant
        try:
            while self.n < participant.granted and self._inputs.ready(self.n):
                stamp = participant.stamp(self.n)
                tick = Tick(self.n, stamp, stamp, participant.period)
                self._put(self._work.following(tick))
        except FaultError as fault:
            self._stopped = True
            self._work.fail(str(fault))

    def _put(self, value: float) -> None:
        self.n += 1
        self._work.put(value)
        self.participant.reach(self.n)

    def report(self) -> Status:
        """Return the step reached and the steps granted."""
        granted = self.participant.granted
        return Status(OK, 'in lockstep', {STEP: self.n, GRANTED: granted})
