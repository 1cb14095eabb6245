"""The spike monitor: counts the events of signals and publishes them as they happen."""

from __future__ import annotations

import sys
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from std_msgs.msg import Float64, Header, UInt64

from ..analysis.events import EventDetector
from ..simulation.grid import SECOND
from .managed import OK, ManagedNode
from .ros import run_node
from .signal import SIGNAL_QOS

COUNT_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
EVENT_QOS = QoSProfile(depth=100)


class SpikeMonitor(ManagedNode):
    """Runs one event detector per signal, the same that analyses bags."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('spike_monitor', **kwargs)

    def open(self) -> None:
        """Create, per signal, a subscription and the publishers of count and events."""
        self.counts, self.events, self.sources = {}, {}, {}
        for signal in self.values['signals']:
            self.counts[signal] = self.advertise(UInt64, f'spikes/{signal}/count', COUNT_QOS)
            self.events[signal] = self.advertise(Header, f'spikes/{signal}/event', EVENT_QOS)
            self.sources[signal] = self.subscribe(
                Float64, signal, self._receiver(signal), SIGNAL_QOS
            )

    def shut(self) -> None:
        """Destroy them."""
        for publishers in (getattr(self, 'counts', {}), getattr(self, 'events', {})):
            for publisher in publishers.values():
                self.destroy_lifecycle_publisher(publisher)
            publishers.clear()
        for subscription in getattr(self, 'sources', {}).values():
            self.destroy_subscription(subscription)
        self.sources = {}

    def begin(self) -> None:
        """Count from 0."""
        self._restart()
        for count in self.counts.values():
            self.send(count, UInt64(data=0))

    def changed(self) -> None:
        """Look for the next event with the new threshold and reset; counts go on."""

    def _restart(self) -> None:
        threshold, reset = self.values['threshold'], self.values['reset']
        self.detectors = {s: EventDetector(threshold, reset) for s in self.values['signals']}
        self.zero = self.get_clock().now().nanoseconds

    def _receiver(self, signal: str) -> Any:
        def receive(message: Float64, info: dict[str, Any]) -> None:
            if self.stage != 'active':
                return
            detector = self.detectors[signal]
            t = detector.push((self.stamp_of(info) - self.zero) / SECOND, message.data)
            if t is not None:
                stamp = Time(nanoseconds=self.zero + round(t * SECOND)).to_msg()
                self.send(self.events[signal], Header(stamp=stamp, frame_id=signal))
                self.send(self.counts[signal], UInt64(data=detector.count))

        return receive

    def report(self) -> tuple[bytes, str, dict[str, object]]:
        """Return the counts."""
        counts = {f'{signal}.count': d.count for signal, d in self.detectors.items()}
        return OK, 'counting', dict(counts)

    def matches(self) -> dict[str, int]:
        """Return the number of publishers of each signal."""
        return {
            f'{signal}.publishers': subscription.get_publisher_count()
            for signal, subscription in getattr(self, 'sources', {}).items()
        }


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(SpikeMonitor)


if __name__ == '__main__':
    sys.exit(main())
