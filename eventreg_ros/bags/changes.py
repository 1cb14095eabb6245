# SPDX-License-Identifier: Apache-2.0
"""What was changed while a bag was recorded: parameters set, nodes switched off and on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .channel import Channel, Messages, each

PARAMETERS, TRANSITION = 'rcl_interfaces/msg/ParameterEvent', 'lifecycle_msgs/msg/TransitionEvent'

TRANSITIONS = {
    ('configuring', 'inactive'): 'configure',
    ('activating', 'active'): 'activate',
    ('deactivating', 'inactive'): 'deactivate',
    ('cleaningup', 'unconfigured'): 'cleanup',
    ('shuttingdown', 'finalized'): 'shutdown',
    ('errorprocessing', 'unconfigured'): 'stopped by an error',
}
"""What each transition that came to its end is called, by the state left and the one reached."""

_FIELDS = (
    '', 'bool_value', 'integer_value', 'double_value', 'string_value', 'byte_array_value',
    'bool_array_value', 'integer_array_value', 'double_array_value', 'string_array_value',
)  # fmt: skip
"""Where a ParameterValue has its value, by its type."""

_NUMBERED = tuple((i, field) for i, field in enumerate(_FIELDS) if field)
_EMPTY: dict[str, Any] = {
    'bool_value': False, 'integer_value': 0, 'double_value': 0.0, 'string_value': '',
    'byte_array_value': np.empty(0, np.uint8), 'bool_array_value': np.empty(0, np.bool_),
    'integer_array_value': np.empty(0, np.int64), 'double_array_value': np.empty(0),
    'string_array_value': [],
}  # fmt: skip
"""What the other fields of a ParameterValue hold."""

_TYPES = ((bool, 1), (int, 2), (float, 3), (str, 4), (list, 3))
"""Types of a ParameterValue by those of Python, the narrower first; an empty list is of doubles."""

_ARRAYS = 5
"""By so much is the type of a list above that of its entries."""

_STATES = {
    'unconfigured': 1, 'inactive': 2, 'active': 3, 'finalized': 4, 'configuring': 10,
    'cleaningup': 11, 'shuttingdown': 12, 'activating': 13, 'deactivating': 14,
    'errorprocessing': 15,
}  # fmt: skip
"""The numbers of lifecycle_msgs/msg/State."""

MOST = 10_000
"""No more changes than this are kept: nobody would read them."""


class Changed(NamedTuple):
    """A change: when (nanoseconds of ROS time), of which node, and what."""

    stamp: int
    node: str
    what: str


class Written(NamedTuple):
    """A message to be written: its topic, its type, its bytes (CDR)."""

    topic: str
    type: str
    data: bytes


def parameter_set(stamp: int, node: str, name: str, value: Any) -> Written:
    """Return what a node publishes when its parameter ``name`` is set; ``stamp`` in nanoseconds."""
    store, types = _store()
    kind, filled = _typed(value)
    fields = {field: filled if i == kind else _EMPTY[field] for i, field in _NUMBERED}
    parameter = types['rcl_interfaces/msg/Parameter'](
        name=name, value=types['rcl_interfaces/msg/ParameterValue'](type=kind, **fields)
    )
    message = types[PARAMETERS](
        stamp=types['builtin_interfaces/msg/Time'](*divmod(stamp, 10**9)),
        node=f'/{node}',
        new_parameters=[],
        changed_parameters=[parameter],
        deleted_parameters=[],
    )
    return Written('/parameter_events', PARAMETERS, bytes(store.serialize_cdr(message, PARAMETERS)))


def node_switched(node: str, transition: str) -> Written:
    """Return what a node publishes at the end of a transition of :data:`TRANSITIONS`."""
    store, types = _store()
    (start, goal) = next(states for states, name in TRANSITIONS.items() if name == transition)
    state = types['lifecycle_msgs/msg/State']
    message = types[TRANSITION](
        timestamp=0,
        transition=types['lifecycle_msgs/msg/Transition'](id=0, label=transition),
        start_state=state(id=_STATES[start], label=start),
        goal_state=state(id=_STATES[goal], label=goal),
    )
    data = bytes(store.serialize_cdr(message, TRANSITION))
    return Written(f'/{node}/transition_event', TRANSITION, data)


def _store() -> tuple[Any, Any]:
    """Return the message types of ROS, as rosbags has them."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    return store, store.types


def _typed(value: Any) -> tuple[int, Any]:
    """Return the number of the type that a ParameterValue has for ``value``, and its content."""
    listed = isinstance(value, list | tuple)
    each = value[0] if listed and value else value
    scalar = next(i for kind, i in _TYPES if isinstance(each, kind))
    if not listed:
        return scalar, value
    number = scalar + _ARRAYS
    return number, list(value) if number == len(_FIELDS) - 1 else np.asarray(value)


class ChangeTaker:
    """Keeps the messages of one topic that say of changes, and decodes them in the end."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._messages: list[tuple[int, bytes]] = []

    @staticmethod
    def wants(channel: Channel) -> bool:
        """Say whether a channel holds changes."""
        return channel.type in (PARAMETERS, TRANSITION) and channel.encoding in ('cdr', '')

    def expect(self, count: int) -> None:
        """Make no room: a list grows by itself."""

    def take(self, messages: Messages) -> None:
        """Keep messages."""
        stamps = messages.log if messages.publish is None else messages.publish
        for i, data in sorted((i, data) for group in messages.groups for i, data in each(group)):
            if len(self._messages) < MOST:
                self._messages.append((int(stamps[i]), data))

    def changes(self) -> list[Changed]:
        """Return the changes; a message that cannot be decoded is none."""
        if not self._messages:
            return []
        store, _ = _store()
        found: list[Changed] = []
        for stamp, data in self._messages:
            try:
                message = store.deserialize_cdr(data, self._channel.type)
            except Exception:  # whatever a broken message does to the decoder
                continue
            found += self._read(stamp, message)
        return found

    def _read(self, stamp: int, message: Any) -> list[Changed]:
        if self._channel.type == TRANSITION:
            node = self._channel.topic.rpartition('/')[0].strip('/')
            states = (message.start_state.label, message.goal_state.label)
            return [Changed(stamp, node, TRANSITIONS[states])] if states in TRANSITIONS else []
        node = message.node.strip('/')
        return [
            Changed(stamp, node, f'{parameter.name}:={_value(parameter.value)}')
            for parameter in message.changed_parameters
        ]


def _value(value: Any) -> str:
    """Return a ParameterValue as one would set it."""
    field = _FIELDS[value.type] if value.type < len(_FIELDS) else ''
    found: Any = getattr(value, field) if field else None
    return as_set(found.tolist() if hasattr(found, 'tolist') else found)


def as_set(value: Any) -> str:
    """Return a value as one would set it, numbers to six digits."""
    if isinstance(value, list | tuple):
        return f'[{", ".join(map(as_set, value))}]'
    if isinstance(value, bool):
        return str(value).lower()
    return f'{value:g}' if isinstance(value, int | float) else str(value)
