"""The recorder: writes signals and spikes to a rosbag2, as they come, without unpacking them."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from rclpy.qos import QoSProfile
from std_msgs.msg import Float64, Header, UInt64

from ..analysis.bags import BagWriter
from ..errors import BagError
from .managed import OK, ManagedNode
from .ros import run_node
from .spike_monitor import COUNT_QOS, EVENT_QOS

RECORD_QOS = QoSProfile(depth=2000)


class Recorder(ManagedNode):
    """Records ``signals`` and their spikes; a message's time stamp is when it was sent."""

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
        for signal in values['signals']:
            self._record(Float64, 'std_msgs/msg/Float64', signal, RECORD_QOS)
            self._record(UInt64, 'std_msgs/msg/UInt64', f'spikes/{signal}/count', COUNT_QOS)
            self._record(Header, 'std_msgs/msg/Header', f'spikes/{signal}/event', EVENT_QOS)
        self.flush_timer = self.create_timer(1.0, self._flush)

    def _record(self, message: type, msgtype: str, name: str, qos: QoSProfile) -> None:
        topic = self.resolve_topic_name(name)
        self.writer.add(topic, msgtype)
        self.recorded[name] = 0

        def receive(data: bytes, info: dict[str, Any]) -> None:
            if self.stage != 'active':
                return
            try:
                self.writer.write(topic, self.stamp_of(info), data)
            except Exception as error:  # the disk, the database: whatever it is, keep what is there
                self.break_off(f'the bag {self.writer.path} cannot be written: {error}')
                return
            self.recorded[name] += 1

        self.sources[name] = self.subscribe(message, name, receive, qos, raw=True)

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
