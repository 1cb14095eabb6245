"""The spike monitor: counts the events of signals and publishes them as they happen."""

from __future__ import annotations

import sys
from collections import deque
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from std_msgs.msg import Float64, Header, UInt64

from ..analysis.events import EventDetector
from ..parameter import ACTIVE
from ..simulation.grid import SECOND
from .float64 import number_of, unpacked
from .lockstep import Participant
from .managed import OK, ManagedNode
from .ros import run_node
from .signal import LOCKSTEP_QOS, SIGNAL_QOS

COUNT_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
EVENT_QOS = QoSProfile(depth=100)


class SpikeMonitor(ManagedNode):
    """Runs one event detector per signal, the same that analyses bags."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('spike_monitor', **kwargs)
        self.participant: Participant | None = None
        self.early: deque[Any] = deque(maxlen=10000)

    def open(self) -> None:
        """Create, per signal, a subscription and the publishers of count and events."""
        self.counts, self.events, self.sources = {}, {}, {}
        qos = LOCKSTEP_QOS if self.values['lockstep'] else SIGNAL_QOS
        for signal in self.values['signals']:
            self.counts[signal] = self.advertise(UInt64, f'spikes/{signal}/count', COUNT_QOS)
            self.events[signal] = self.advertise(Header, f'spikes/{signal}/event', EVENT_QOS)
            self.sources[signal] = self.subscribe(Float64, signal, self._receiver(signal), qos)

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
        if self.values['lockstep']:
            self.participant = Participant(self, lambda: None, self._missing)
        for count in self.counts.values():
            self.send(count, UInt64(data=0))
        if self.participant is not None:
            self.stage = ACTIVE
            for receive, data, info in self.early:
                receive(data, info)
        self.early.clear()

    def end(self) -> None:
        """Count no more."""
        if self.participant is not None:
            self.participant.end()
            self.participant = None

    def _step(self, signal: str, info: dict[str, Any]) -> int:
        """Return the simulation time of a sample in lockstep, and tell the clock of it."""
        assert self.participant is not None
        self.seen[signal] = number_of(info)
        reached = min(self.seen.values())
        if reached > self.participant.reached:
            self.participant.reach(reached)
        return self.participant.stamp(self.seen[signal])

    def _missing(self, n: int) -> list[str]:
        return [signal for signal, seen in self.seen.items() if seen <= n]

    def _restart(self) -> None:
        threshold, reset = self.values['threshold'], self.values['reset']
        self.detectors = {s: EventDetector(threshold, reset) for s in self.values['signals']}
        self.seen = dict.fromkeys(self.values['signals'], -1)
        lockstep = self.values['lockstep']
        self.zero = 0 if lockstep else self.get_clock().now().nanoseconds

    def _receiver(self, signal: str) -> Any:
        def receive(data: bytes, info: dict[str, Any]) -> None:
            if self.stage != ACTIVE:
                if self.values['lockstep']:
                    self.early.append((receive, data, info))
                return
            detector = self.detectors[signal]
            stamp = self.stamp_of(info) if self.participant is None else self._step(signal, info)
            t = detector.push((stamp - self.zero) / SECOND, unpacked(data))
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
