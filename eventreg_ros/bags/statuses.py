# SPDX-License-Identifier: Apache-2.0
"""Diagnostic statuses in a bag: keys and values by time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from .reader import read_messages

STATUS = 'diagnostic_msgs/msg/DiagnosticStatus'


class Status(NamedTuple):
    """A status: when (nanoseconds of ROS time), and its keys and values."""

    stamp: int
    values: dict[str, str]


def read_statuses(path: str | Path, topic: str) -> list[Status]:
    """Return the statuses on ``topic``, in order; what cannot be decoded is none.

    Raises BagError where there is nothing to read.
    """
    messages = [m for m in read_messages(path, [topic])[topic] if m.type == STATUS]
    if not messages:
        return []
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    found = []
    for message in messages:
        stamp = message.log if message.publish is None else message.publish
        try:
            status: Any = store.deserialize_cdr(message.data, STATUS)
            found.append(Status(stamp, {pair.key: pair.value for pair in status.values}))
        except Exception:  # whatever a broken message does to the decoder
            continue
    return found
