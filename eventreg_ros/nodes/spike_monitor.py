"""The spike monitor: counts the events of signals and publishes them as they happen.

Listens to the signals that the parameter signals names, publishes spikes/SIGNAL/count and
spikes/SIGNAL/event.
"""

from __future__ import annotations

import sys
from collections import deque
from typing import Any

from rclpy.time import Time
from std_msgs.msg import Header, UInt64

from ..analysis.events import EventDetector
from ..runtime.cdr import unpacked
from ..runtime.sequenced_input import flaw
from ..runtime.tick_grid import SECOND
from ..scenario.parameter import ACTIVE
from .info import number_of
from .lockstep import Participant
from .managed import OK, FaultError, ManagedNode, Status
from .ros import run_node
from .topics import COUNT, EVENT, signal_topic


class SpikeMonitor(ManagedNode):
    """Runs one event detector per signal, the same that analyses bags."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('spike_monitor', **kwargs)
        self.participant: Participant | None = None
        self.early: deque[Any] = deque(maxlen=10000)

    def open(self) -> None:
        """Create, per signal, a subscription and the publishers of count and events."""
        self.counts, self.events = {}, {}
        topic = signal_topic(self.values['lockstep'])
        for signal in self.values['signals']:
            self.counts[signal] = self.advertise(COUNT, signal)
            self.events[signal] = self.advertise(EVENT, signal)
            self.subscribe(topic, signal, self._receiver(signal))

    def begin(self) -> None:
        """Count from 0."""
        self._restart()
        if self.values['lockstep']:
            self.participant = Participant(self, lambda: None, self._missing)
            self.stack.callback(self._leave_lockstep)
        for count in self.counts.values():
            self.send(count, UInt64(data=0))
        early = list(self.early)
        self.early.clear()
        if self.participant is not None:
            if early and number_of(early[0][2]) not in (0, None):
                raise FaultError('the first samples in lockstep were missed; configure all anew')
            self.stage = ACTIVE
            for receive, data, info in early:
                receive(data, info)

    def _leave_lockstep(self) -> None:
        self.participant = None

    def _fits(self, signal: str, number: int | None) -> bool:
        """Say whether this is the next sample in lockstep; stop when one was left out."""
        expected = self.seen[signal] + 1
        if number == expected:
            return True
        if wrong := flaw(number, expected, f' of {signal}'):
            self.fail(f'lockstep stopped: {wrong}')
        return False

    def _step(self, signal: str) -> int:
        """Return the simulation time of the next sample in lockstep, and report it to the clock."""
        assert self.participant is not None
        self.seen[signal] += 1
        reached = min(self.seen.values())
        if reached > self.participant.reached:
            self.participant.reach(reached)
        return self.participant.stamp(self.seen[signal])

    def _missing(self) -> list[str]:
        last = min(self.seen.values(), default=0)
        return [f'sample {n + 1} of {signal}' for signal, n in self.seen.items() if n == last]

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
            detector, number = self.detectors[signal], number_of(info)
            if self.participant is None:
                stamp = self.stamp_of(info)
            elif self._fits(signal, number):
                stamp = self._step(signal)
            else:
                return
            t = detector.push((stamp - self.zero) / SECOND, unpacked(data))
            if t is not None:
                stamp = Time(nanoseconds=self.zero + round(t * SECOND)).to_msg()
                self.send(self.events[signal], Header(stamp=stamp, frame_id=signal))
                self.send(self.counts[signal], UInt64(data=detector.count))

        return receive

    def report(self) -> Status:
        """Return the counts."""
        counts = {f'{signal}.count': d.count for signal, d in self.detectors.items()}
        return Status(OK, 'counting', counts)


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(SpikeMonitor)


if __name__ == '__main__':
    sys.exit(main())
