"""Signals to rosbag2 directories. The only writer of bags."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from ..errors import BagError
from ..runtime.cdr import packed
from .reader import FLOAT64, NAME_KEY, SCENARIO_KEY, SIDECAR

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

Array = npt.NDArray[np.float64]

_MESSAGE = struct.Struct('<BQHIQQ')
"""Of an MCAP file: opcode, length of the rest, channel, sequence, and twice the time stamp."""

_CHUNK = 2**20


class BagWriter:
    """A rosbag2 that survives its writer: what was flushed can be read after a kill."""

    def __init__(
        self, path: str | Path, storage: str, scenario: str | None, name: str | None
    ) -> None:
        """Create the bag. Raises BagError when ``path`` exists or cannot be made."""
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.rosbag2.errors import WriterError
        from rosbags.typesys import Stores, get_typestore

        path = Path(path)
        if path.exists():
            raise BagError(f'bag {path} exists already; remove it or name another directory')
        plugin = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}[storage]
        self.path = path
        self._store = get_typestore(Stores.ROS2_JAZZY)
        try:
            self._writer: Writer = Writer(path, version=9, storage_plugin=plugin)
            self._writer.open()
            if scenario is not None:
                name = name or 'scenario'
                (path / (name + SIDECAR)).write_text(scenario, encoding='utf-8')
                self._writer.set_custom_data(SCENARIO_KEY, scenario)
                self._writer.set_custom_data(NAME_KEY, name)
        except (OSError, WriterError) as error:
            raise BagError(f'bag {path} cannot be made: {error}; name another directory') from None
        self._connections: dict[str, Any] = {}

    def add(self, topic: str, msgtype: str) -> None:
        """Announce a topic; its message type must be one of ROS 2 Jazzy's."""
        self._connections[topic] = self._writer.add_connection(
            topic, msgtype, typestore=self._store
        )

    def write(self, topic: str, stamp: int, data: bytes) -> None:
        """Write one serialized message (CDR) with its time stamp in nanoseconds."""
        self._writer.write(self._connections[topic], stamp, data)

    def write_rows(
        self, topics: Sequence[str], stamps: Sequence[int], columns: Sequence[Sequence[bytes]]
    ) -> None:
        """Write rows: at each of ``stamps``, in order, one message of each topic.

        ``columns`` holds, per topic, its messages (CDR), one per stamp.
        """
        connections = [self._connections[topic] for topic in topics]
        rows = list(zip(stamps, zip(*columns, strict=True), strict=True))
        if rows and hasattr(self._writer.storage, 'close_chunk'):
            self._append(connections, rows)
            return
        for stamp, row in rows:
            for connection, data in zip(connections, row, strict=True):
                self._writer.write(connection, stamp, data)

    def _append(self, connections: list[Any], rows: list[tuple[int, tuple[bytes, ...]]]) -> None:
        """Do what rosbags' write does for each message of an MCAP file, three times as fast."""
        writer, storage = self._writer, cast('Any', self._writer.storage)
        chunk = storage.chunk
        pieces: list[bytes] = []
        at = chunk.bio.tell()
        indices = [(c.id, chunk.msgs[c.id]) for c in connections]
        for stamp, row in rows:
            for (channel, index), data in zip(indices, row, strict=True):
                index.append((stamp, at))
                pieces += (_MESSAGE.pack(5, 22 + len(data), channel, 0, stamp, stamp), data)
                at += _MESSAGE.size + len(data)
        chunk.bio.write(b''.join(pieces))
        first, last = rows[0][0], rows[-1][0]
        for each in (storage, chunk):
            each.message_start_time = min(first, each.message_start_time)
            each.message_end_time = max(last, each.message_end_time)
        writer.min_timestamp = min(first, writer.min_timestamp)
        writer.max_timestamp = max(last, writer.max_timestamp)
        for connection in connections:
            storage.channel_stats[connection.id] += len(rows)
            writer.counts[connection.id] += len(rows)
        if at > _CHUNK:
            storage.close_chunk()

    def flush(self) -> None:
        """Hand everything written so far to the operating system."""
        storage: Any = self._writer.storage
        if hasattr(storage, 'close_chunk'):
            if storage.chunk.msgs:
                storage.close_chunk()
            storage.bio.flush()
        else:
            storage.conn.commit()

    def close(self) -> None:
        """Write the index and the metadata."""
        self._writer.close()


def write_bag(
    path: str | Path,
    signals: Mapping[str, tuple[Sequence[int], Array]],
    scenario_name: str,
    scenario_yaml: str,
    storage: str = 'mcap',
) -> None:
    """Write signals as a rosbag2.

    ``signals`` maps each name to (stamps, values), both of shape (n,), stamps in nanoseconds.
    Raises BagError.
    """
    writer = BagWriter(path, storage, scenario_yaml, scenario_name)
    samples = []
    for name, (stamps, values) in signals.items():
        topic = f'/{name}'
        writer.add(topic, FLOAT64)
        samples += [(stamp, topic, value) for stamp, value in zip(stamps, values, strict=True)]
    for stamp, topic, value in sorted(samples, key=lambda s: s[0]):
        writer.write(topic, stamp, packed(value))
    writer.close()
