# SPDX-License-Identifier: Apache-2.0
"""What is changed while a recorder records: parameters that are set, nodes that are switched."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from lifecycle_msgs.msg import TransitionEvent
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message

from .endpoints import Endpoints
from .topics import PARAMETER_EVENTS, TRANSITION_EVENT, Topic

STARTING = ('configuring', 'activating')


class Change(NamedTuple):
    """A message that says of a change: its topic, its bytes (CDR), and when the node sent it.

    ``stamp`` is in nanoseconds; 0 where the message has none.
    """

    kind: Topic
    topic: str
    data: bytes
    stamp: int


class ChangeTap:
    """Hears of the changes of the nodes in a node's namespace, and hands them on.

    Other nodes are found by the topics that are there, each time that :meth:`look` is called.
    Without ``starts`` the first configuring and activating of a node is left out.
    """

    def __init__(self, node: Endpoints, hand_on: Callable[[Change], None], *, starts: bool) -> None:
        self._node, self._hand_on, self._starts = node, hand_on, starts
        self._home = node.get_namespace().rstrip('/') + '/'
        self._own = node.get_fully_qualified_name()
        self._taps: dict[str, Any] = {}
        self._started: set[str] = set()
        self._listen(PARAMETER_EVENTS, PARAMETER_EVENTS.name, self._on_parameters)
        self.look()

    @property
    def heard(self) -> list[str]:
        """The topics that are listened to."""
        return list(self._taps)

    def close(self) -> None:
        """Hear no more."""
        for tap in self._taps.values():
            self._node.destroy_subscription(tap)
        self._taps.clear()

    def look(self) -> None:
        """Listen to the nodes that have come since."""
        for topic, types in self._node.get_topic_names_and_types():
            node = topic.rpartition('/')[0]
            known = topic in self._taps or node == self._own
            if TRANSITION_EVENT.type_name in types and topic.startswith(self._home) and not known:
                self._listen(TRANSITION_EVENT, topic, self._on_transition(node))

    def _listen(self, kind: Topic, topic: str, change: Callable[[Any], int | None]) -> None:
        """Hear of a topic; ``change`` returns the stamp of a message, None where it is none."""

        def receive(data: bytes) -> None:
            stamp = change(deserialize_message(data, kind.message))
            if stamp is not None:
                self._hand_on(Change(kind, topic, data, stamp))

        self._taps[topic] = self._node.create_subscription(
            kind.message, topic, receive, kind.qos, raw=True
        )

    def _on_parameters(self, event: ParameterEvent) -> int | None:
        if not (event.changed_parameters and event.node.startswith(self._home)):
            return None
        return int(event.stamp.sec * 10**9 + event.stamp.nanosec)

    def _on_transition(self, node: str) -> Callable[[TransitionEvent], int | None]:
        def stamp_of(event: TransitionEvent) -> int | None:
            starting = event.start_state.label in STARTING and node not in self._started
            if not starting or event.goal_state.label == 'active':
                self._started.add(node)
            return 0 if self._starts or not starting else None

        return stamp_of
