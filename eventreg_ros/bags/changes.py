# SPDX-License-Identifier: Apache-2.0
"""What was changed while a bag was recorded: parameters set, nodes switched off and on."""

from __future__ import annotations

from typing import Any, NamedTuple

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

MOST = 10_000
"""No more changes than this are kept: nobody would read them."""


class Changed(NamedTuple):
    """A change: when (nanoseconds of ROS time), of which node, and what."""

    stamp: int
    node: str
    what: str


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
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
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
