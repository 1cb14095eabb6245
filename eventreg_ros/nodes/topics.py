# SPDX-License-Identifier: Apache-2.0
"""The table of topics: name, message type and quality of service of each, written once.

Every call of :meth:`Topic.qos` makes a new profile: rclpy writes the overrides of one publisher or
subscription into the profile object that it is given.
"""

from __future__ import annotations

from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import TransitionEvent
from rcl_interfaces.msg import ParameterEvent
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64, Header, UInt64


@dataclass(frozen=True)
class Topic:
    """A kind of topic: reliable, ``depth`` samples deep; ``latched`` keeps them for late readers.

    ``name`` is relative; where it holds ``{signal}``, there is one topic per signal. ``meaning`` is
    for readers: who publishes it, and what is in it.
    """

    name: str
    message: type
    depth: int
    latched: bool = False
    meaning: str = ''

    @property
    def type_name(self) -> str:
        """The message type as bags and ``ros2 topic`` write it: std_msgs/msg/Float64."""
        package, _, _ = self.message.__module__.partition('.')
        return f'{package}/msg/{self.message.__name__}'

    def of(self, signal: str) -> str:
        """Return the topic's name for ``signal``."""
        return self.name.format(signal=signal)

    @property
    def qos(self) -> QoSProfile:
        """A new profile of this topic."""
        latched, volatile = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
        return QoSProfile(depth=self.depth, durability=latched if self.latched else volatile)


SIGNAL = Topic(
    '{signal}', Float64, 100, meaning='a block or stimulus: its output, a sample per step'
)
"""Deep enough for half a second at the default rate."""

LOCKSTEP_SIGNAL = Topic('{signal}', Float64, 2000, latched=True, meaning='the same in lockstep')
"""In lockstep nobody may miss a sample: a reader that comes late still gets it."""

RECORDED_SIGNAL = Topic('{signal}', Float64, 2000)
COUNT = Topic(
    'spikes/{signal}/count', UInt64, 1, latched=True, meaning='spike_monitor: the events so far'
)
EVENT = Topic(
    'spikes/{signal}/event',
    Header,
    100,
    meaning='spike_monitor: one per event; stamp is the time of the crossing, frame_id the signal',
)
VERDICT = Topic(
    'verdict',
    DiagnosticStatus,
    1,
    latched=True,
    meaning='spike_monitor, once a second: the verdict so far, its evidence, the margin used',
)
DIAGNOSTICS = Topic(
    '/diagnostics', DiagnosticArray, 100, meaning='every node, once a second: its state and figures'
)
PARAMETER_EVENTS = Topic(
    '/parameter_events', ParameterEvent, 1000, meaning='every node: which parameters were set'
)
TRANSITION_EVENT = Topic(
    'transition_event', TransitionEvent, 100, meaning='every lifecycle node: its transitions'
)
"""ROS's own: what every node says of its parameters, and a lifecycle node of its transitions."""
CLOCK = Topic('/clock', Clock, 10, meaning='clock: simulation time')

GRANT = Topic(
    'lockstep/grant', UInt64, 1, latched=True, meaning='clock: the last step that may be made'
)
REACHED = Topic(
    'lockstep/reached', Header, 1, latched=True, meaning='every participant: how far it got'
)
ALL_REACHED = Topic('lockstep/reached', Header, 1000, latched=True)
"""What the clock granted, and what the participants reached: one writes, the other reads all."""


SHARED = tuple(f'{topic.name}:=/{topic.name}' for topic in (GRANT, REACHED))
"""Remap rules by which nodes of any namespace share one clock of lockstep."""


def signal_topic(lockstep: bool) -> Topic:
    """Return how signals travel in lockstep, or in real time."""
    return LOCKSTEP_SIGNAL if lockstep else SIGNAL
