# SPDX-License-Identifier: Apache-2.0
"""The spike monitor: counts the events of signals and publishes them as they happen.

Listens to the signals that the parameter signals names, publishes spikes/SIGNAL/count and
spikes/SIGNAL/event, and once a second the verdict so far.
"""

from __future__ import annotations

import sys
from collections import deque
from contextlib import suppress
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.time import Time
from std_msgs.msg import Header, UInt64

from ..analysis.events import EventDetector
from ..analysis.live import LiveJudge
from ..runtime.cdr import unpacked
from ..runtime.figures import MARGIN_USED, events_of
from ..runtime.sequenced_input import flaw
from ..runtime.tick_grid import SECOND
from ..scenario import Criteria
from ..scenario.names import KINDS
from ..scenario.parameter import ACTIVE
from .info import number_of
from .lockstep import Participant
from .managed import ERROR, IDENTITY, OK, WARN, FaultError, ManagedNode, Status
from .ros import run_node
from .stored import scenario_text
from .topics import COUNT, DIAGNOSTICS, EVENT, VERDICT, signal_topic

LEVELS = {'rejected': OK, 'undecided': WARN, 'not rejected': ERROR}
"""The level of the diagnostic status that gives a verdict."""


class SpikeMonitor(ManagedNode):
    """Runs one event detector per signal, and judges the run: the code that analyses bags."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('spike_monitor', **kwargs)
        self.participant: Participant | None = None
        self.early: deque[Any] = deque(maxlen=10000)

    def open(self) -> None:
        """Create, per signal, a subscription and the publishers of count and events."""
        self.counts, self.events = {}, {}
        self.text = scenario_text('spike_monitor', self.values['scenario'])
        self.judge = self._new_judge()  # refuses a scenario that cannot be read
        self.verdict = self.publisher_of(VERDICT)
        self.others: dict[str, str] = {}
        self.subscription_of(DIAGNOSTICS, self._on_diagnostics)
        topic = signal_topic(self.values['lockstep'])
        for signal in self.values['signals']:
            self.counts[signal] = self.advertise(COUNT, signal)
            self.events[signal] = self.advertise(EVENT, signal)
            self.subscribe(topic, signal, self._receiver(signal))
        self.steady_timer(1.0, self._publish_verdict)

    def _new_judge(self) -> LiveJudge:
        values = self.values
        return LiveJudge.of(
            values['signals'],
            Criteria.of(values),
            values['time_scale'],
            self.text,
            self.get_namespace(),
        )

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
        limits = Criteria.of(self.values)
        self.judge = self._new_judge()
        self.detectors = {
            s: EventDetector(limits.threshold, limits.reset) for s in self.values['signals']
        }
        self._tune()
        self.seen = dict.fromkeys(self.values['signals'], -1)
        self.heard = dict.fromkeys(self.values['signals'], 0)
        lockstep = self.values['lockstep']
        self.zero = self.newest = 0 if lockstep else self.get_clock().now().nanoseconds

    def _tune(self) -> None:
        """Give the detectors, which know seconds, their limits in model time."""
        scale = self.values['time_scale']
        for detector in self.detectors.values():
            detector.refractory = self.values['refractory'] / scale
            detector.min_width = self.values['min_width'] / scale

    def changed(self) -> None:
        """Take over another time_scale; model time goes on without a jump."""
        if self.stage == ACTIVE:
            self.judge.rescale(self._seconds(self._now()), self.values['time_scale'])
            self._tune()

    def _now(self) -> int:
        """Return the time in nanoseconds: in lockstep that of the newest sample."""
        if self.participant is not None:
            return self.newest
        return int(self.get_clock().now().nanoseconds)

    def _seconds(self, stamp: int) -> float:
        return (stamp - self.zero) / SECOND

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
            self.newest = max(self.newest, stamp)
            seconds, value = self._seconds(stamp), unpacked(data)
            self.judge.saw(signal, seconds, value)
            self.heard[signal] += 1
            for at, x in self.judge.points(signal, seconds, value):
                t = detector.push(at, x)
                if t is not None:
                    self._count(signal, t)

        return receive

    def _count(self, signal: str, t: float) -> None:
        """Publish an event at ``t`` seconds, and how many there were."""
        self.judge.event(signal, t)
        stamp = Time(nanoseconds=self.zero + round(t * SECOND)).to_msg()
        self.send(self.events[signal], Header(stamp=stamp, frame_id=signal))
        self.send(self.counts[signal], UInt64(data=self.detectors[signal].count))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        """Note what the nodes of our namespace say: the delay margin used, and their version."""
        home = self.get_namespace().rstrip('/') + '/'
        for status in message.status:
            if not status.name.startswith(home):
                continue
            self._note_version(status)
            for pair in status.values if not self.values['lockstep'] else ():
                if pair.key == MARGIN_USED:
                    with suppress(ValueError):  # anybody may say anything there
                        self.judge.note_margin(float(pair.value))

    def _note_version(self, status: DiagnosticStatus) -> None:
        """Note a node of ours that another version of the package runs; the oldest said none."""
        name, _, kind = status.name.partition(': ')
        ours = kind in KINDS and any(pair.key == 'state' for pair in status.values)
        if not ours or status.hardware_id == IDENTITY:
            self.others.pop(name, None)
        else:
            self.others[name] = status.hardware_id or 'an older eventreg_ros'

    def _publish_verdict(self) -> None:
        """Publish the verdict so far."""
        if self.stage != ACTIVE:
            return
        risen = {signal: detector.risen for signal, detector in self.detectors.items()}
        found = self.judge.verdict(self._seconds(self._now()), risen)
        decision = found.decision
        status = DiagnosticStatus(
            level=LEVELS[decision.verdict],
            name=f'{self.get_fully_qualified_name()}: verdict',
            message=f'{decision.verdict}: {decision.reason}',
            values=[KeyValue(key=key, value=value) for key, value in found.values().items()],
        )
        self.send(self.verdict, status)

    def report(self) -> Status:
        """Return the counts of events, and of messages: a second, and per event of w."""
        seconds, events = self._seconds(self._now()), self.judge.disturbances
        values: dict[str, object] = {events_of(s): d.count for s, d in self.detectors.items()}
        for signal, count in self.heard.items():
            values[f'{signal}.messages'] = count
            values[f'{signal}.messages_per_second'] = f'{count / max(seconds, 1e-9):.3g}'
            if events:
                values[f'{signal}.messages_per_event'] = f'{count / events:.3g}'
        if not self.others:
            return Status(OK, 'counting', values)
        found = ', '.join(f'{name} ({version})' for name, version in self.others.items())
        words = f'nodes of another version: {found}; this is {IDENTITY}; use one version'
        return Status(WARN, words, values)


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(SpikeMonitor)


if __name__ == '__main__':
    sys.exit(main())
