# SPDX-License-Identifier: Apache-2.0
"""The link: relays one signal and delays, jitters, drops or duplicates its samples.

Listens to the signal that the parameter input names, publishes the one that output names.
"""

from __future__ import annotations

import sys
import time
from dataclasses import fields
from typing import Any

from ..runtime.cdr import age_of, with_age
from ..runtime.figures import LinkFigures
from ..runtime.relay import Impairment, Relay
from ..runtime.tick_grid import SECOND
from .info import received_at
from .managed import OK, ManagedNode, Status
from .ros import run_node
from .topics import SIGNAL

SOONEST = 1_000
"""Nanoseconds to which the timer is set when a sample is due at once or was so already."""


class LinkNode(ManagedNode):
    """Relays ``input`` to ``output`` through a :class:`.wire.Wire`, without unpacking the samples.

    Delays count from a sample's arrival and pass in real time, under simulation time too. What is
    sent gets a new source time stamp, as every message does; how old the sample is by then goes
    with it (:func:`..runtime.cdr.with_age`).
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('link', **kwargs)

    def open(self) -> None:
        """Create the subscription of the input and the publisher of the output."""
        self.publisher = self.advertise(SIGNAL, self.values['output'])
        self.subscribe(SIGNAL, self.values['input'], self._receive)

    def begin(self) -> None:
        """Relay from now on, with new random numbers. What is in flight at the end is lost."""
        self._new_wire()
        self._alarm = self.steady_timer(1.0, self._deliver)
        self._alarm.cancel()

    def changed(self) -> None:
        """Take over the impairment for the samples to come; a new seed begins anew."""
        if self.stage != 'active':
            return
        if self.values['seed'] != self._seed:
            self._new_wire()
        self.wire.impairment = impairment(self.values)

    def _new_wire(self) -> None:
        # Links with the same seed are not to drop the same samples.
        self._seed = self.values['seed']
        topic = self.resolve_topic_name(self.values['input'])
        self.wire: Relay[tuple[int, bytes]] = Relay(
            impairment(self.values), f'{self._seed} {topic}'
        )
        self._delays: list[int] = []
        self._errors: list[int] = []

    def _receive(self, data: bytes, info: dict[str, Any]) -> None:
        if self.stage != 'active':
            return
        arrived = received_at(info)
        waited = max(0, time.time_ns() - arrived)
        made = min(info['source_timestamp'], arrived) - age_of(data)
        self.wire.push(time.monotonic_ns() - waited, (made, data))
        self._deliver()

    def _deliver(self) -> None:
        """Send what is due, and set the timer to when the next sample is."""
        for departure in self.wire.pop(time.monotonic_ns()):
            made, data = departure.item
            self.send(self.publisher, with_age(data, time.time_ns() - made))
            now = time.monotonic_ns()
            self._delays.append(now - departure.entered)
            self._errors.append(now - departure.due)
        due_next = self.wire.next_due
        if due_next is None:
            self._alarm.cancel()
        else:
            self._alarm.timer_period_ns = max(due_next - time.monotonic_ns(), SOONEST)
            self._alarm.reset()

    def report(self) -> Status:
        """Return the counts since activation, and delay and error since the last report."""
        wire = self.wire
        measured = []
        for times in (self._delays, self._errors):
            times.sort()
            measured += [percentile(times, part) for part in (50, 99)]
            times.clear()
        figures = LinkFigures(
            wire.received,
            wire.sent,
            wire.dropped,
            wire.duplicated,
            wire.overtaken,
            wire.in_flight,
            *measured,
        )
        return Status(OK, 'relaying', figures._asdict())


def impairment(values: dict[str, Any]) -> Impairment:
    """Return the impairment that the parameters ask for."""
    return Impairment(**{field.name: values[field.name] for field in fields(Impairment)})


def percentile(times: list[int], part: int) -> str:
    """Return a percentile of sorted ``times`` (nanoseconds) in seconds, or a dash without any."""
    return f'{times[(len(times) - 1) * part // 100] / SECOND:.6f}' if times else '-'


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(LinkNode)


if __name__ == '__main__':
    sys.exit(main())
