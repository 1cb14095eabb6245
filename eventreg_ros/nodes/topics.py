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

    ``name`` is relative; where it holds ``{signal}``, there is one topic per signal.
    """

    name: str
    message: type
    depth: int
    latched: bool = False

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


SIGNAL = Topic('{signal}', Float64, 100)
"""Deep enough for half a second at the default rate."""

LOCKSTEP_SIGNAL = Topic('{signal}', Float64, 2000, latched=True)
"""In lockstep nobody may miss a sample: a reader that comes late still gets it."""

RECORDED_SIGNAL = Topic('{signal}', Float64, 2000)
COUNT = Topic('spikes/{signal}/count', UInt64, 1, latched=True)
EVENT = Topic('spikes/{signal}/event', Header, 100)
VERDICT = Topic('verdict', DiagnosticStatus, 1, latched=True)
DIAGNOSTICS = Topic('/diagnostics', DiagnosticArray, 100)
PARAMETER_EVENTS = Topic('/parameter_events', ParameterEvent, 1000)
TRANSITION_EVENT = Topic('transition_event', TransitionEvent, 100)
"""ROS's own: what every node says of its parameters, and a lifecycle node of its transitions."""
CLOCK = Topic('/clock', Clock, 10)

GRANT = Topic('lockstep/grant', UInt64, 1, latched=True)
REACHED = Topic('lockstep/reached', Header, 1, latched=True)
ALL_REACHED = Topic('lockstep/reached', Header, 1000, latched=True)
"""What the clock granted, and what the participants reached: one writes, the other reads all."""


SHARED = tuple(f'{topic.name}:=/{topic.name}' for topic in (GRANT, REACHED))
"""Remap rules by which nodes of any namespace share one clock of lockstep."""


def signal_topic(lockstep: bool) -> Topic:
    """Return how signals travel in lockstep, or in real time."""
    return LOCKSTEP_SIGNAL if lockstep else SIGNAL
