# SPDX-License-Identifier: Apache-2.0
"""The recorder: writes signals and spikes to a rosbag2, as they come, without unpacking them.

Listens to the signals that the parameter signals names, to their spikes/SIGNAL/count and
spikes/SIGNAL/event, to verdict, and to what the nodes say of parameters and transitions.
"""

from __future__ import annotations

import sys
import time
from typing import Any

from ..bags.writer import BagWriter
from ..errors import BagError
from ..runtime.figures import recorded_of
from ..runtime.sequenced_input import flaw
from ..scenario.parameter import ACTIVE
from .changes import Change, ChangeTap
from .endpoints import InfoCallback
from .info import number_of
from .lockstep import Participant
from .managed import OK, ManagedNode, Status
from .ros import run_node
from .stored import scenario_text
from .topics import COUNT, EVENT, LOCKSTEP_SIGNAL, RECORDED_SIGNAL, VERDICT, Topic

LOOK = 0.005
"""Seconds between looks at what has come: no message wakes the recorder."""


class Recorder(ManagedNode):
    """Records ``signals``, their spikes and the verdict; a message is stamped when it was sent.

    What is changed during a run is recorded too: parameters set, nodes switched off and on. In
    lockstep it records signals and changes alone, in the order of their steps: two runs give the
    same bytes and the same stamps.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('recorder', **kwargs)

    def open(self) -> None:
        """Create the bag and the subscriptions. Raises BagError."""
        values = self.values
        path = values['path'] or time.strftime('eventreg_%Y_%m_%d-%H_%M_%S')
        self.writer = BagWriter(
            path,
            values['storage'],
            scenario_text('recorder', values['scenario']),
            values['scenario_name'],
        )
        self.stack.callback(self._close)
        self.writer.name_signals({s: self.resolve_topic_name(s) for s in values['signals']})
        self.get_logger().info(f'recording to {path}')
        self.recorded: dict[str, int] = {}
        self.changes: list[tuple[int, Change]] = []
        self.tap = ChangeTap(self, self._on_change, starts=not values['lockstep'])
        self.stack.callback(self.tap.close)
        self.steady_timer(1.0, self.tap.look)
        if values['lockstep']:
            self._open_lockstep()
            return
        for signal in values['signals']:
            for topic in (RECORDED_SIGNAL, COUNT, EVENT):
                self._record(topic, signal)
        self._record(VERDICT)
        self.steady_timer(1.0, self._flush)

    def _open_lockstep(self) -> None:
        """Record the signals row by row: sample n of all of them, stamped with its model step."""
        signals = self.values['signals']
        if not signals:
            raise BagError('recorder.signals must name a signal in lockstep, got []; name one')
        self.topics = [self.resolve_topic_name(signal) for signal in signals]
        self.waiting: list[list[bytes]] = [[] for _ in signals]
        self.row = 0
        self.wrong: str | None = None
        for i, (signal, topic) in enumerate(zip(signals, self.topics, strict=True)):
            self.writer.add(topic, LOCKSTEP_SIGNAL.type_name)
            self.recorded[signal] = 0
            self.subscribe(LOCKSTEP_SIGNAL, signal, self._queue(i, signal), polled=True)
        self.steady_timer(1.0, self._flush)

    def _queue(self, i: int, signal: str) -> InfoCallback:
        """Return what puts the samples of one signal in order until their row is complete."""
        queue = self.waiting[i]

        def receive(data: bytes, info: dict[str, Any]) -> None:
            expected = self.row + len(queue)
            number = number_of(info)
            if number == expected:
                queue.append(data)
            elif self.wrong is None:
                self.wrong = flaw(number, expected, f' of {signal}')

        return receive

    def _take(self) -> None:
        """Take what has come, and write the rows that are complete."""
        if self.stage != ACTIVE or self.fault is not None:
            return
        self.poll()
        self._write_rows(min(map(len, self.waiting)))
        if self.wrong is not None and self.fault is None:
            self.fail(f'{self.wrong}; the bag ends before it')

    def _write_rows(self, rows: int) -> None:
        stamps = [self.participant.stamp(self.row + i) for i in range(rows)]
        try:
            self.writer.write_rows(self.topics, stamps, [queue[:rows] for queue in self.waiting])
        except Exception as error:  # the disk, the database: whatever it is, keep what is there
            self._give_up(error)
            return
        for signal, queue in zip(self.recorded, self.waiting, strict=True):
            del queue[:rows]
            self.recorded[signal] += rows
        if rows:
            self.row += rows
            self.participant.reach(self.row - 1)

    def _missing(self) -> list[str]:
        queues = zip(self.recorded, self.waiting, strict=True)
        return [f'sample {self.row} of {signal}' for signal, queue in queues if not queue]

    def begin(self) -> None:
        """Record from now on."""
        if self.values['lockstep']:
            self.participant = Participant(self, lambda: None, self._missing)
        take = self._take if self.values['lockstep'] else self.poll
        self.stack.callback(take)
        self.take_timer = self.steady_timer(LOOK, take)

    def _record(self, kind: Topic, signal: str = '') -> None:
        name = kind.of(signal)
        topic = self.resolve_topic_name(name)
        self.writer.add(topic, kind.type_name)
        self.recorded[name] = 0

        def receive(data: bytes, info: dict[str, Any]) -> None:
            if self.stage != ACTIVE:
                return
            self._write(topic, self.stamp_of(info), data)
            self.recorded[name] += 1

        # In simulation time a message counts from its arrival: it must not wait.
        self.subscribe(kind, signal, receive, polled=not self.in_simulation_time)

    def _on_change(self, change: Change) -> None:
        """Record a change: in lockstep in the end, since there the order is that of the steps."""
        if self.stage != ACTIVE:
            return
        if self.values['lockstep']:
            # The clock waits while a run makes a change: the last row is the step at which it acts.
            self.changes.append((self.participant.stamp(max(self.row - 1, 0)), change))
        else:
            self._write_change(change.stamp or int(self.get_clock().now().nanoseconds), change)

    def _write_change(self, stamp: int, change: Change) -> None:
        if change.topic not in self.recorded:
            self.recorded[change.topic] = 0
            self.writer.add(change.topic, change.kind.type_name)
        self._write(change.topic, stamp, change.data)
        self.recorded[change.topic] += 1

    def _write(self, topic: str, stamp: int, data: bytes) -> None:
        try:
            self.writer.write(topic, stamp, data)
        except Exception as error:  # the disk, the database: whatever it is, keep what is there
            self._give_up(error)

    def _flush(self) -> None:
        try:
            self.writer.flush()
        except Exception as error:
            self._give_up(error)

    def _give_up(self, error: Exception) -> None:
        if self.fault is None:
            words = f'the bag {self.writer.path} cannot be written: {error}'
            self.fail(str(error) if isinstance(error, BagError) else words)

    def _close(self) -> None:
        """Close the bag: this writes its index and metadata."""
        try:
            for stamp, change in sorted(self.changes, key=lambda pair: (pair[0], pair[1].topic)):
                self._write_change(stamp, change)
            self.writer.close()
        except Exception as error:
            if self.fault is None:
                self.get_logger().error(f'the bag {self.writer.path} was not closed: {error}')

    def report(self) -> Status:
        """Return the number of messages recorded per topic."""
        recorded = {recorded_of(name): n for name, n in self.recorded.items()}
        return Status(OK, 'recording', recorded)


def main() -> int:
    """Run the node until SIGINT or SIGTERM, then close the bag."""
    return run_node(Recorder)


if __name__ == '__main__':
    sys.exit(main())
