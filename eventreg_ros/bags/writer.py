# SPDX-License-Identifier: Apache-2.0
"""Signals to rosbag2 directories. The only writer of bags."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from sqlite3 import Error as SqliteError
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import BagError
from ..files import reason_of
from ..runtime.cdr import packed
from .changes import Written
from .channel import FLOAT64, Index, Stamps
from .files import SIDECAR, STORAGES
from .mcap_writer import McapStorage
from .messages import Values
from .metadata import NAME_KEY, SCENARIO_KEY, TOPICS_KEY
from .place import Place

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer


class BagWriter:
    """A rosbag2 that survives its writer: what was flushed can be read after a kill."""

    def __init__(
        self, path: str | Path, storage: str, scenario: str | None, name: str | None
    ) -> None:
        """Create the bag. Raises BagError when ``path`` exists or cannot be made."""
        from rosbags.rosbag2.errors import WriterError
        from rosbags.typesys import Stores, get_typestore

        path = Path(path)
        if path.exists():
            raise BagError(f'bag {path} exists already; remove it or name another directory')
        name = _checked(name or 'scenario')
        self.path = path
        self._store = get_typestore(Stores.ROS2_JAZZY)
        try:
            self._writer = _opened(path, storage)
            if scenario is not None:
                (path / (name + SIDECAR)).write_text(scenario, encoding='utf-8')
                self._writer.set_custom_data(SCENARIO_KEY, scenario)
                self._writer.set_custom_data(NAME_KEY, name)
        except (OSError, WriterError) as error:
            why = reason_of(error) if isinstance(error, OSError) else str(error)
            raise BagError(f'bag {path} cannot be made: {why}; name another directory') from None
        self._storage: Any = self._writer.storage
        self._place = Place(path / (path.name + STORAGES[storage]))
        self._connections: dict[str, Any] = {}

    def add(self, topic: str, msgtype: str) -> None:
        """Announce a topic; its message type must be one of ROS 2 Jazzy's."""
        self._connections[topic] = self._writer.add_connection(
            topic, msgtype, typestore=self._store
        )

    def name_signals(self, topics: Mapping[str, str]) -> None:
        """Say which topic each signal is on, so that those with another name are found."""
        other = {s: t for s, t in topics.items() if '/' in s or t.rpartition('/')[2] != s}
        if other:
            text = ' '.join(f'{signal}:={topic}' for signal, topic in other.items())
            self._writer.set_custom_data(TOPICS_KEY, text)

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
        if not rows:
            return
        if isinstance(self._storage, McapStorage):
            self._storage.write_rows([c.id for c in connections], rows)
            self._counted(
                rows[0][0], rows[-1][0], dict.fromkeys((c.id for c in connections), len(rows))
            )
            return
        for stamp, row in rows:
            for connection, data in zip(connections, row, strict=True):
                self._writer.write(connection, stamp, data)

    def write_float64(
        self, topics: Sequence[str], which: Index, stamps: Stamps, values: Values
    ) -> None:
        """Write Float64 messages in the order of ``stamps``, each on its topic of ``topics``.

        ``which`` says on which; all arrays have shape (n,).
        """
        if not len(stamps):
            return
        if not isinstance(self._storage, McapStorage):
            for i, stamp, value in zip(
                which.tolist(), stamps.tolist(), values.tolist(), strict=True
            ):
                self.write(topics[i], stamp, packed(value))
            return
        numbers = np.array([self._connections[topic].id for topic in topics])
        self._storage.write_float64(numbers[which], stamps, values)
        each = np.bincount(which, minlength=len(topics)).tolist()
        self._counted(
            int(stamps[0]), int(stamps[-1]), dict(zip(numbers.tolist(), each, strict=True))
        )

    def _counted(self, first: int, last: int, counts: Mapping[int, int]) -> None:
        """Report to rosbags' writer, which writes metadata.yaml, what went past it."""
        writer = self._writer
        writer.min_timestamp = min(first, writer.min_timestamp)
        writer.max_timestamp = max(last, writer.max_timestamp)
        for number, count in counts.items():
            writer.counts[number] += count

    def flush(self) -> None:
        """Hand everything written so far to the operating system.

        Raises BagError when the bag was deleted, moved or cut since the last time.
        """
        if isinstance(self._storage, McapStorage):
            self._storage.flush()
            return
        self._place.check()
        self._storage.conn.commit()
        self._place.check()

    def close(self) -> None:
        """Write the index and the metadata, or nothing and raise BagError, as :meth:`flush`."""
        try:
            self._place.check()
        except BagError:
            self.abort()
            raise
        self._writer.close()

    def abort(self) -> None:
        """Close the files as they are."""
        self._storage.abort()


def _opened(path: Path, storage: str) -> Writer:
    """Return rosbags' writer, with an MCAP storage of ours, which writes checksums."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    class CheckedWriter(Writer):
        """Writes MCAP files with checksums."""

        STORAGE_PLUGINS = {**Writer.STORAGE_PLUGINS, StoragePlugin.MCAP: McapStorage}  # noqa: RUF012

    plugin = {'mcap': StoragePlugin.MCAP, 'sqlite3': StoragePlugin.SQLITE3}[storage]
    writer = CheckedWriter(path, version=9, storage_plugin=plugin)
    writer.open()
    return writer


def _checked(name: str) -> str:
    """Return a scenario's name, which becomes the name of a file in the bag. Raises BagError."""
    if Path(name).name != name or name.startswith('.') or '\0' in name:
        raise BagError(
            f'the name of a scenario must be a plain word, since it names a file in the bag, got '
            f'{name!r}; choose another'
        )
    return name


def write_bag(
    path: str | Path,
    signals: Mapping[str, tuple[Sequence[int], Values]],
    scenario_name: str,
    scenario_yaml: str,
    storage: str = 'mcap',
    changes: Sequence[tuple[int, Written]] = (),
) -> None:
    """Write signals as a rosbag2.

    ``signals`` maps each name to (stamps, values), both of shape (n,), stamps in nanoseconds.
    ``changes`` are messages with their stamps, in order. Raises BagError; nothing is left then.
    """
    writer = BagWriter(path, storage, scenario_yaml, scenario_name)
    try:
        _fill(writer, signals, changes)
    except BaseException as error:  # an interruption, too
        with suppress(OSError, SqliteError):
            writer.abort()
        shutil.rmtree(path, ignore_errors=True)
        if not isinstance(error, OSError | SqliteError):
            raise
        why = reason_of(error) if isinstance(error, OSError) else str(error)
        raise BagError(f'bag {path} cannot be written: {why}; name another directory') from None


def _fill(
    writer: BagWriter,
    signals: Mapping[str, tuple[Sequence[int], Values]],
    changes: Sequence[tuple[int, Written]],
) -> None:
    """Write everything, and close the bag."""
    writer.name_signals({name: f'/{name}' for name in signals})
    topics = [f'/{name}' for name in signals]
    for topic in topics:
        writer.add(topic, FLOAT64)
    found = [(np.asarray(s, np.int64), np.asarray(v, np.float64)) for s, v in signals.values()]
    stamps = np.concatenate([s for s, _ in found]) if found else np.empty(0, np.int64)
    values = np.concatenate([v for _, v in found]) if found else np.empty(0)
    which = np.repeat(np.arange(len(found)), [len(s) for s, _ in found])
    order = np.argsort(stamps, kind='stable')
    writer.write_float64(topics, which[order], stamps[order], values[order])
    for topic, kind in {message.topic: message.type for _, message in changes}.items():
        writer.add(topic, kind)
    for stamp, message in changes:
        writer.write(message.topic, stamp, message.data)
    writer.close()
