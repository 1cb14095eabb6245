"""The recorder: writes signals and spikes to a rosbag2, as they come, without unpacking them."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.qos import QoSProfile
from std_msgs.msg import Float64, Header, UInt64

from ..analysis.bags import BagWriter
from ..errors import BagError
from ..parameter import ACTIVE
from .lockstep import Participant, number_of
from .managed import OK, InfoCallback, ManagedNode
from .ros import run_node
from .signal import LOCKSTEP_QOS
from .spike_monitor import COUNT_QOS, EVENT_QOS

RECORD_QOS = QoSProfile(depth=2000)


class Recorder(ManagedNode):
    """Records ``signals`` and their spikes; a message's time stamp is when it was sent.

    In lockstep it records the signals alone, in the order of their steps: two runs give the same
    bytes and the same stamps.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('recorder', **kwargs)

    def open(self) -> None:
        """Create the bag and the subscriptions. Raises BagError."""
        values = self.values
        path = values['path'] or time.strftime('eventreg_%Y_%m_%d-%H_%M_%S')
        self.writer = BagWriter(
            path, values['storage'], _scenario_text(values['scenario']), values['scenario_name']
        )
        self.get_logger().info(f'recording to {path}')
        self.recorded: dict[str, int] = {}
        self.sources: dict[str, Any] = {}
        if values['lockstep']:
            self._open_lockstep()
            return
        for signal in values['signals']:
            self._record(Float64, 'std_msgs/msg/Float64', signal, RECORD_QOS)
            self._record(UInt64, 'std_msgs/msg/UInt64', f'spikes/{signal}/count', COUNT_QOS)
            self._record(Header, 'std_msgs/msg/Header', f'spikes/{signal}/event', EVENT_QOS)
        self.flush_timer = self._steady(1.0, self._flush)

    def _open_lockstep(self) -> None:
        """Record the signals row by row: sample n of all of them, stamped with its model step."""
        self.waiting: dict[str, deque[bytes]] = {s: deque() for s in self.values['signals']}
        self.row = 0
        for signal in self.waiting:
            self.writer.add(self.resolve_topic_name(signal), 'std_msgs/msg/Float64')
            self.recorded[signal] = 0
            self.sources[signal] = self.subscribe(
                Float64, signal, self._numbered_receiver(signal), LOCKSTEP_QOS, raw=True
            )
        self.flush_timer = self._steady(1.0, self._flush)

    def _numbered_receiver(self, signal: str) -> InfoCallback:
        def receive(data: bytes, info: dict[str, Any]) -> None:
            expected = self.recorded[signal] + len(self.waiting[signal])
            if number_of(info) > expected:
                self.break_off(f'sample {expected} of {signal} was lost; the bag ends before it')
            elif number_of(info) == expected:
                self.waiting[signal].append(data)
                self._write_rows()

        return receive

    def _write_rows(self) -> None:
        if self.stage != ACTIVE or self.fault is not None:
            return
        while all(self.waiting.values()):
            stamp = self.participant.stamp(self.row)
            for signal, queue in self.waiting.items():
                self._write(self.resolve_topic_name(signal), stamp, queue.popleft())
                self.recorded[signal] += 1
            self.participant.reach(self.row)
            self.row += 1

    def _missing(self, n: int) -> list[str]:
        return [signal for signal, queue in self.waiting.items() if not queue]

    def begin(self) -> None:
        """Record from now on."""
        if self.values['lockstep']:
            self.participant = Participant(self, self._write_rows, self._missing)
            self.stage = ACTIVE
            self._write_rows()

    def end(self) -> None:
        """Leave the lockstep."""
        if hasattr(self, 'participant'):
            self.participant.end()
            del self.participant

    def _steady(self, period: float, work: Callable[[], None]) -> Any:
        return self.create_timer(period, work, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _record(self, message: type, msgtype: str, name: str, qos: QoSProfile) -> None:
        topic = self.resolve_topic_name(name)
        self.writer.add(topic, msgtype)
        self.recorded[name] = 0

        def receive(data: bytes, info: dict[str, Any]) -> None:
            if self.stage != ACTIVE:
                return
            self._write(topic, self.stamp_of(info), data)
            self.recorded[name] += 1

        self.sources[name] = self.subscribe(message, name, receive, qos, raw=True)

    def _write(self, topic: str, stamp: int, data: bytes) -> None:
        try:
            self.writer.write(topic, stamp, data)
        except Exception as error:  # the disk, the database: whatever it is, keep what is there
            self.break_off(f'the bag {self.writer.path} cannot be written: {error}')

    def _flush(self) -> None:
        try:
            self.writer.flush()
        except Exception as error:
            self.break_off(f'the bag {self.writer.path} cannot be written: {error}')

    def shut(self) -> None:
        """Close the bag: this writes its index and metadata."""
        for subscription in getattr(self, 'sources', {}).values():
            self.destroy_subscription(subscription)
        self.sources = {}
        if hasattr(self, 'flush_timer'):
            self.destroy_timer(self.flush_timer)
            del self.flush_timer
        if hasattr(self, 'writer'):
            writer = self.writer
            del self.writer
            try:
                writer.close()
            except Exception as error:
                self.get_logger().error(f'the bag {writer.path} was not closed: {error}')

    def report(self) -> tuple[bytes, str, dict[str, object]]:
        """Return the number of messages recorded per topic."""
        return OK, 'recording', {f'{name}.recorded': n for name, n in self.recorded.items()}

    def matches(self) -> dict[str, int]:
        """Return the number of publishers of each topic."""
        return {
            f'{name}.publishers': subscription.get_publisher_count()
            for name, subscription in getattr(self, 'sources', {}).items()
        }


def _scenario_text(path: str) -> str | None:
    if not path:
        return None
    try:
        return Path(path).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise BagError(
            f'recorder.scenario must be a readable file, got {path!r}: {error}'
        ) from None


def main() -> int:
    """Run the node until SIGINT or SIGTERM, then close the bag."""
    return run_node(Recorder)


if __name__ == '__main__':
    sys.exit(main())
