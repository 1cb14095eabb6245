# SPDX-License-Identifier: Apache-2.0
"""MCAP records: bytes to records and back. Knows no files. The format is mcap.dev/spec."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .channel import Bytes

MAGIC = b'\x89MCAP0\r\n'
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET = range(9, 15)
DATA_END = 15
COMPRESSIONS = ('', 'lz4', 'zstd')

HEAD = struct.Struct('<BQ')
"""Of every record: opcode, and the length of the body that follows."""
CHUNK_HEAD = struct.Struct('<QQQI')
FOOTER_BODY = struct.Struct('<QQI')
_STATISTICS = struct.Struct('<QHIIIIQQ')
_U16, _U32, _U64 = struct.Struct('<H'), struct.Struct('<I'), struct.Struct('<Q')
_COUNT, _INDEX = struct.Struct('<HQ'), struct.Struct('<HI')

Buffer = bytes | memoryview


class DamagedError(ValueError):
    """Bytes that are not the record that they should be."""


class Schema(NamedTuple):
    """A type: its name, the language of its definition, and the definition."""

    id: int
    name: str
    encoding: str
    text: str


class McapChannel(NamedTuple):
    """A topic; ``schema`` is the id of its type, 0: none."""

    id: int
    schema: int
    topic: str
    encoding: str


class Chunk(NamedTuple):
    """The head of a chunk: stamps in nanoseconds, sizes in bytes; ``at`` is where its data begin.

    ``length`` is the length of the data as compressed; ``crc`` is 0 where there is no checksum.
    """

    start: int
    end: int
    size: int
    crc: int
    compression: str
    at: int
    length: int


class _Reader:
    """Reads fields one after another. Raises DamagedError where the body ends too early."""

    def __init__(self, body: Buffer) -> None:
        self.body = body
        self.at = 0

    def number(self, layout: struct.Struct) -> int:
        return int(self.numbers(layout)[0])

    def numbers(self, layout: struct.Struct) -> tuple[int, ...]:
        try:
            found = layout.unpack_from(self.body, self.at)
        except struct.error:
            raise DamagedError('a record ends too early') from None
        self.at += layout.size
        return found

    def data(self) -> Buffer:
        length = self.number(_U32)
        if self.at + length > len(self.body):
            raise DamagedError('a record ends too early')
        self.at += length
        return self.body[self.at - length : self.at]

    def text(self) -> str:
        return bytes(self.data()).decode('utf-8', 'replace')


def schema(body: Buffer) -> Schema:
    """Return what a Schema record says. Raises DamagedError."""
    fields = _Reader(body)
    return Schema(fields.number(_U16), fields.text(), fields.text(), fields.text())


def channel(body: Buffer) -> McapChannel:
    """Return what a Channel record says. Raises DamagedError."""
    fields = _Reader(body)
    number, schema_id = fields.number(_U16), fields.number(_U16)
    return McapChannel(number, schema_id, fields.text(), fields.text())


def chunk(body: Buffer) -> Chunk:
    """Return the head of a Chunk record, of which ``body`` may be the beginning.

    Raises DamagedError.
    """
    fields = _Reader(body)
    start, end, size, crc = fields.numbers(CHUNK_HEAD)
    compression = fields.text()
    length = fields.number(_U64)
    return Chunk(start, end, size, crc, compression, fields.at, length)


def index_entries(body: Buffer) -> tuple[int, int]:
    """Return channel and number of messages of a MessageIndex record. Raises DamagedError."""
    if len(body) < _INDEX.size:
        raise DamagedError('a record ends too early')
    number, length = _INDEX.unpack_from(body)
    if _INDEX.size + length > len(body):
        raise DamagedError('a record ends too early')
    return number, length // 16


def statistics(body: Buffer) -> dict[int, int]:
    """Return the number of messages by channel of a Statistics record. Raises DamagedError."""
    fields = _Reader(body)
    fields.numbers(_STATISTICS)
    counts = fields.data()
    return dict(_COUNT.iter_unpack(counts[: len(counts) // 10 * 10]))


def metadata(body: Buffer) -> tuple[str, dict[str, str]]:
    """Return name and content of a Metadata record. Raises DamagedError."""
    fields = _Reader(body)
    name, pairs = fields.text(), _Reader(fields.data())
    content = {}
    while pairs.at < len(pairs.body):
        key = pairs.text()
        content[key] = pairs.text()
    return name, content


# The other way --------------------------------------------------------------------------------


def record(opcode: int, *fields: bytes) -> bytes:
    """Return a record of fields that are bytes already."""
    body = b''.join(fields)
    return HEAD.pack(opcode, len(body)) + body


def sized(data: bytes | str) -> bytes:
    """Return bytes, or a text, after their length."""
    data = data.encode() if isinstance(data, str) else data
    return _U32.pack(len(data)) + data


def counts(by_channel: dict[int, int]) -> bytes:
    """Return a table of a number by channel, as Statistics and ChunkIndex hold it."""
    return sized(b''.join(_COUNT.pack(number, n) for number, n in by_channel.items()))


# Where the next record begins -------------------------------------------------------------------


class Record(NamedTuple):
    """A record that is not a message, from ``start`` to ``end`` in its buffer."""

    opcode: int
    start: int
    body: memoryview
    end: int


def whole_chunk(buffer: memoryview, at: int, room: int) -> bool:
    """Whether a Chunk record begins here that is consistent with itself, ``room`` bytes at most."""
    if len(buffer) < at + HEAD.size:
        return False
    opcode, length = HEAD.unpack_from(buffer, at)
    if opcode != CHUNK or not 40 <= length <= room - HEAD.size:
        return False
    try:
        head = chunk(buffer[at + HEAD.size : at + HEAD.size + 64])
    except DamagedError:
        return False
    return head.compression in COMPRESSIONS and head.at + head.length <= length


def find_record(buffer: memoryview, at: int, room: int) -> int | None:
    """Return where, from ``at`` on, a record begins that two others follow, or a whole chunk.

    None where there is none in the buffer. ``room`` bytes are left in the file from 0 of the
    buffer on.
    """
    data: Bytes = np.frombuffer(buffer, np.uint8)
    size = len(data)
    if size - at < HEAD.size or not data[at:].any():
        return None
    opcodes = data[at : size - 8]
    starts = np.flatnonzero((opcodes >= SCHEMA) & (opcodes <= DATA_END)) + at
    lengths = every_byte(data, 1, '<u8')[starts]
    chunks = starts[(data[starts] == CHUNK) & (lengths < room)]
    fits = lengths <= (size - HEAD.size - starts).astype(np.uint64)
    fits &= (data[starts] != MESSAGE) | (lengths >= 22)
    starts = starts[fits]
    following = np.arange(size + 1)
    following[starts] = starts + HEAD.size + lengths[fits].astype(np.intp)
    begins = np.zeros(size + 1, bool)
    begins[starts] = begins[size] = True
    second = following[starts]
    chained = starts[begins[second] & begins[following[second]]]
    found = [int(c) for c in chunks if whole_chunk(buffer, int(c), room)][:1]
    return min([*chained[:1].tolist(), *found], default=None)


def every_byte(data: Bytes, offset: int, kind: str) -> npt.NDArray[np.uint64]:
    """Return the numbers of ``kind`` that begin at every byte from ``offset`` on."""
    count = max(len(data) - offset - np.dtype(kind).itemsize + 1, 0)
    found: npt.NDArray[np.uint64] = np.ndarray((count,), kind, data, offset, (1,))
    return found


def records(buffer: memoryview, at: int, end: int) -> Iterator[Record]:
    """Yield the records between ``at`` and ``end``, as far as they are whole."""
    while at + HEAD.size <= end:
        opcode, length = HEAD.unpack_from(buffer, at)
        after = at + HEAD.size + length
        if opcode == 0 or after > end:
            return
        yield Record(opcode, at, buffer[at + HEAD.size : after], after)
        at = after
