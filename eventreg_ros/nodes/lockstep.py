"""Lockstep: step n uses exactly sample n of every input, whatever the load and the order.

A deterministic dataflow. Samples are told apart by the number that their writer gives them
(``publication_sequence_number``), not by time. The clock node grants steps, a window at a time;
each participant says how far it got, and a step whose sample does not come within a limit stops
the node with a message that names the link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.time import Time
from std_msgs.msg import Header, UInt64

from ..runtime.tick_grid import TickGrid
from ..scenario.parameter import ACTIVE
from .managed import OK, FaultError, ManagedNode
from .topics import GRANT, REACHED

if TYPE_CHECKING:
    from .signal import SignalNode

EVERY = 75
"""A participant tells every so many steps how far it got, and where the grant ends."""

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
        self._name = node.get_fully_qualified_name()
        self._grid = TickGrid(node.values['rate'])
        self._patience: float = node.values['lockstep_timeout']
        self.granted = 0
        self.reached = self._told = -1
        self._armed = False
        self._standstill = Standstill()
        self._publisher = node.publisher_of(REACHED)
        self._subscription = node.subscription_of(GRANT, self._on_grant)
        self._watchdog = node.steady_timer(WATCH, self._watch)

    def end(self) -> None:
        """Leave the exchange."""
        self._node.destroy_publisher(self._publisher)
        self._node.destroy_subscription(self._subscription)
        self._node.destroy_timer(self._watchdog)

    def stamp(self, n: int) -> int:
        """Return the simulation time of sample ``n`` in nanoseconds."""
        return self._grid.stamp(n)

    def reach(self, n: int) -> None:
        """Note that all samples up to ``n`` are made, and tell the clock where it has to know."""
        before, self.reached = self.reached, n
        if n // EVERY > before // EVERY or n == self.granted:
            self._tell(n)

    def _tell(self, n: int) -> None:
        self._told = n
        stamp = Time(nanoseconds=self._grid.stamp(n)).to_msg()
        self._node.send(self._publisher, Header(stamp=stamp, frame_id=self._name))

    def _on_grant(self, message: UInt64) -> None:
        self.granted = message.data
        self._armed = True  # before the first grant somebody may still be starting
        self._go()
        if self.reached == self.granted:
            self._tell(self.reached)

    def _watch(self) -> None:
        """Tell the clock of slow progress, and break off where there is none."""
        if self._node.stage != ACTIVE or self._node.fault is not None:
            return
        if several := self._node.several_writers():
            self._node.break_off(f'lockstep: {several}')
            return
        if self.reached != self._told:
            self._tell(self.reached)
        still = self._standstill.look((self.reached, self.granted))
        if self._armed and self.reached < self.granted and still >= self._patience:
            self._node.break_off(
                f'lockstep stopped: {self._node.kind} waits for '
                f'{", ".join(self._missing()) or "nothing"}, which did not come within '
                f'{self._patience:g} s; look at who publishes it'
            )


class Lockstep:
    """Publishes sample n + 1 as soon as sample n of every input is there and the step granted."""

    def __init__(self, node: SignalNode) -> None:
        self._node = node
        self.n = -1
        if node.published:
            raise FaultError(
                f'in lockstep {node.kind} starts but once, since its samples are numbered; '
                'cleanup and configure it first'
            )
        self.participant = Participant(node, self.go, self._missing)
        node.published = True
        self._put(node.first())
        self.go()

    def end(self) -> None:
        """Stop."""
        self.participant.end()

    def _missing(self) -> list[str]:
        n = max(self.n, 0)
        return [f'sample {n} of {what}' for what in self._node.missing(n)]

    def go(self) -> None:
        """Take every step that is granted and whose samples are there."""
        node, granted = self._node, self.participant.granted
        if node.fault is not None:
            return
        try:
            while self.n < granted and node.ready(self.n):
                self._put(node.following(self.n))
        except FaultError as fault:
            node.break_off(str(fault))

    def _put(self, value: float) -> None:
        node = self._node
        value = node.sound(value)
        self.n += 1
        node.put(value)
        self.participant.reach(self.n)

    def report(self) -> tuple[bytes, str, dict[str, Any]]:
        """Return the step reached and the steps granted."""
        return OK, 'in lockstep', {'step': self.n, 'granted': self.participant.granted}
