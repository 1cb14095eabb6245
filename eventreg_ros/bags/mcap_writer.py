# SPDX-License-Identifier: Apache-2.0
"""An MCAP file with checksums, as rosbags' writer wants its storages to be."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from . import mcap_records as mcap
from .channel import Index, Stamps
from .mcap_records import CHUNK_HEAD, FOOTER_BODY, HEAD, MAGIC, counts, record, sized
from .messages import Values
from .place import Place

if TYPE_CHECKING:
    from rosbags.interfaces import Connection

CHUNK = 2**20
"""Bytes after which a chunk is closed."""

METADATA = 'rosbag2'
_MESSAGE = struct.Struct('<BQHIQQ')
"""Opcode, length of the rest, channel, sequence, and twice the time stamp."""
_FLOAT64 = np.dtype(
    [('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'), ('sequence', '<u4'),
     ('log', '<i8'), ('publish', '<i8'), ('encoding', '<u4'), ('value', '<f8')]
)  # fmt: skip
_LITTLE = 0x0100
_U16, _U32, _U64, _PAIR = (struct.Struct(code) for code in ('<H', '<I', '<Q', '<QQ'))
_TOTALS = struct.Struct('<QHIIIIQQ')


class McapStorage:
    """Writes one file; two runs that write the same give the same bytes.

    A chunk is in the file once it is closed, with its checksum; a killed writer loses the rest. The
    indices of the chunks, which belong at the end, wait in a file without a name: a recorder may
    run for months.
    """

    def __init__(self, path: Path, _compression: object = None) -> None:
        """Create the file in the directory ``path``. Raises OSError."""
        self.path = path / f'{path.name}.mcap'
        self.file = self.path.open('xb')
        self._place = Place(self.path)
        self._crc = self._at = 0
        self._schemas: dict[str, bytes] = {}
        self._channels: list[bytes] = []
        self._written: dict[int, int] = {}
        self._indices = tempfile.TemporaryFile(dir=path)  # noqa: SIM115
        self._chunks = 0
        self._start, self._end = 2**63 - 1, 0
        self._pieces: list[bytes] = []
        self._size = 0
        self._index: dict[int, list[bytes]] = {}
        self._first, self._last = 2**63 - 1, 0
        self._put(MAGIC + record(mcap.HEADER, sized('ros2'), sized('eventreg_ros')))

    def add_msgtype(self, connection: Connection) -> None:
        """Declare a message type."""
        language = 'ros2msg' if connection.msgdef.format.name == 'MSG' else 'ros2idl'
        number = _U16.pack(len(self._schemas) + 1)
        text = (connection.msgtype, language, connection.msgdef.data)
        self._schemas[connection.msgtype] = record(mcap.SCHEMA, number, *map(sized, text))
        self._add(self._schemas[connection.msgtype])

    def add_connection(self, connection: Connection, offered_qos_profiles: str) -> None:
        """Declare a topic, whose type was declared before."""
        schema = list(self._schemas).index(connection.msgtype) + 1
        qos = sized('offered_qos_profiles') + sized(offered_qos_profiles)
        self._channels.append(
            record(
                mcap.CHANNEL, _U16.pack(connection.id), _U16.pack(schema),
                sized(connection.topic), sized('cdr'), sized(qos),
            )
        )  # fmt: skip
        self._written[connection.id] = 0
        self._add(self._channels[-1])

    def write(self, connection: Connection, timestamp: int, data: bytes | memoryview) -> None:
        """Write one message."""
        self.write_rows([connection.id], [(timestamp, (bytes(data),))])

    def write_rows(
        self, channels: Sequence[int], rows: Sequence[tuple[int, Sequence[bytes]]]
    ) -> None:
        """Write rows: a stamp, and a message of each channel."""
        at, indices = self._size, [self._index.setdefault(number, []) for number in channels]
        pieces = self._pieces
        for stamp, row in rows:
            for number, index, data in zip(channels, indices, row, strict=True):
                index.append(_PAIR.pack(stamp, at))
                pieces += (_MESSAGE.pack(5, 22 + len(data), number, 0, stamp, stamp), data)
                at += _MESSAGE.size + len(data)
        self._size = at
        for number in channels:
            self._written[number] += len(rows)
        self._reach(rows[0][0], rows[-1][0])

    def write_float64(self, channels: Index, stamps: Stamps, values: Values) -> None:
        """Write Float64 messages, all of shape (n,), in the order of ``stamps``."""
        step = CHUNK // _FLOAT64.itemsize + 1
        for first in range(0, len(stamps), step):
            part = slice(first, first + step)
            self._add_table(channels[part], stamps[part], values[part])

    def _add_table(self, channels: Index, stamps: Stamps, values: Values) -> None:
        table = np.zeros(len(stamps), _FLOAT64)
        table['opcode'], table['length'] = mcap.MESSAGE, _FLOAT64.itemsize - HEAD.size
        table['channel'], table['encoding'] = channels, _LITTLE
        table['log'], table['publish'], table['value'] = stamps, stamps, values
        places = self._size + np.arange(len(stamps)) * _FLOAT64.itemsize
        for number in np.unique(channels).tolist():
            which = channels == number
            entries = np.stack([stamps[which], places[which]], 1).astype('<i8')
            self._index.setdefault(number, []).append(entries.tobytes())
            self._written[number] += int(np.count_nonzero(which))
        self._add(table.tobytes())
        self._reach(int(stamps[0]), int(stamps[-1]))

    def _reach(self, first: int, last: int) -> None:
        self._first, self._last = min(first, self._first), max(last, self._last)
        self._start, self._end = min(first, self._start), max(last, self._end)
        if self._size > CHUNK:
            self.close_chunk()

    # Chunks -----------------------------------------------------------------------------------

    def _add(self, data: bytes) -> None:
        self._pieces.append(data)
        self._size += len(data)

    def _put(self, data: bytes) -> None:
        self.file.write(data)
        self._crc = crc32(data, self._crc)
        self._at += len(data)

    def close_chunk(self) -> None:
        """Write the chunk that was begun, with its checksum and its index.

        Raises BagError when the file was deleted, moved or cut since the last one.
        """
        self._place.check()
        data, begin = b''.join(self._pieces), self._at
        first = min(self._first, self._last)
        head = CHUNK_HEAD.pack(first, self._last, len(data), crc32(data))
        self._put(record(mcap.CHUNK, head, sized(''), _U64.pack(len(data)), data))
        end, offsets = self._at, {}
        for number, entries in self._index.items():
            offsets[number] = self._at
            packed = sized(b''.join(entries))
            self._put(record(mcap.MESSAGE_INDEX, _U16.pack(number), packed))
        numbers = struct.pack('<QQQQ', first, self._last, begin, end - begin)
        sizes = _PAIR.pack(len(data), len(data))
        self._indices.write(
            record(
                mcap.CHUNK_INDEX, numbers, counts(offsets), _U64.pack(self._at - end), sized(''),
                sizes,
            )
        )  # fmt: skip
        self._chunks += 1
        self._pieces, self._size, self._index = [], 0, {}
        self._first, self._last = 2**63 - 1, 0
        self._hand_over()

    def flush(self) -> None:
        """Hand everything written so far to the operating system. Raises BagError as above."""
        if self._index:
            self.close_chunk()
        else:
            self._hand_over()

    def _hand_over(self) -> None:
        self.file.flush()
        self._place.check()

    # The end ----------------------------------------------------------------------------------

    def close(self, _version: int, metadata: str) -> None:
        """Write what is left, the metadata, the summary and the checksums."""
        if self._pieces:
            self.close_chunk()
        begin = self._at
        content = sized('serialized_metadata') + sized(metadata)
        self._put(record(mcap.METADATA, sized(METADATA), sized(content)))
        where = _PAIR.pack(begin, self._at - begin)
        self._put(record(mcap.DATA_END, _U32.pack(self._crc)))
        self._indices.seek(0)
        groups: dict[int, Iterable[bytes]] = {
            mcap.SCHEMA: self._schemas.values(),
            mcap.CHANNEL: self._channels,
            mcap.CHUNK_INDEX: iter(lambda: self._indices.read(CHUNK), b''),
            mcap.METADATA_INDEX: [record(mcap.METADATA_INDEX, where, sized(METADATA))],
            mcap.STATISTICS: [self._statistics()],
        }
        self._crc, summary, offsets = 0, self._at, b''
        for opcode, pieces in groups.items():
            start = self._at
            for piece in pieces:
                self._put(piece)
            if self._at > start:
                place = bytes([opcode]) + _PAIR.pack(start, self._at - start)
                offsets += record(mcap.SUMMARY_OFFSET, place)
        start = self._at
        self._put(offsets)
        self._put(HEAD.pack(mcap.FOOTER, FOOTER_BODY.size) + _PAIR.pack(summary, start))
        self._put(_U32.pack(self._crc) + MAGIC)
        self.abort()

    def _statistics(self) -> bytes:
        total, start = sum(self._written.values()), min(self._start, self._end)
        numbers = _TOTALS.pack(
            total, len(self._schemas), len(self._channels), 0, 1, self._chunks, start,
            self._end,
        )  # fmt: skip
        return record(mcap.STATISTICS, numbers, counts(self._written))

    def abort(self) -> None:
        """Close the file as it is."""
        try:
            self._indices.close()
        finally:
            self.file.close()
