# SPDX-License-Identifier: Apache-2.0
"""The end of an MCAP file: a hint at what the data hold, never more than that."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import IO
from zlib import crc32

from . import mcap_records as mcap
from .mcap_records import HEAD, MAGIC, DamagedError, McapChannel, Schema

_FOOTER_SIZE = HEAD.size + mcap.FOOTER_BODY.size
_DATA_END_SIZE = HEAD.size + 4
_MOST = 64 * 2**20
"""A summary of more bytes than this is not read."""


@dataclass
class Summary:
    """What the end of a file says.

    ``whole``: the file ends as it should; ``sound``: the summary is what its checksum says, where
    it has one; ``data_crc`` is the checksum of everything before it, 0: none.
    """

    whole: bool = False
    sound: bool = True
    data_crc: int = 0
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, McapChannel] = field(default_factory=dict)
    counts: dict[int, int] | None = None


def read_summary(file: IO[bytes], size: int) -> Summary:
    """Return what the end of a file of ``size`` bytes says, as far as it can be believed."""
    found = Summary()
    tail = _read(file, max(size - _FOOTER_SIZE - len(MAGIC), 0), size)
    if len(tail) < _FOOTER_SIZE + len(MAGIC) or not tail.endswith(MAGIC):
        return found
    opcode, length = HEAD.unpack_from(tail)
    found.whole = True
    if opcode != mcap.FOOTER or length != mcap.FOOTER_BODY.size:
        found.sound = False
        return found
    start, _, crc = mcap.FOOTER_BODY.unpack_from(tail, HEAD.size)
    footer = size - len(tail)
    begin = start or footer
    if not len(MAGIC) <= begin <= footer or footer - begin > _MOST:
        found.sound = False
        return found
    found.data_crc = _data_crc(_read(file, max(begin - _DATA_END_SIZE, 0), begin))
    body = _read(file, begin, footer)
    if crc and crc32(tail[: _FOOTER_SIZE - 4], crc32(body)) != crc:
        found.sound = False
        return found
    _read_records(memoryview(body), found)
    return found


def _read(file: IO[bytes], start: int, end: int) -> bytes:
    file.seek(start)
    return file.read(end - start)


def _data_crc(data_end: bytes) -> int:
    if len(data_end) < _DATA_END_SIZE or HEAD.unpack_from(data_end) != (mcap.DATA_END, 4):
        return 0
    return int.from_bytes(data_end[HEAD.size :], 'little')


def _read_records(body: memoryview, found: Summary) -> None:
    for record in mcap.records(body, 0, len(body)):
        try:
            if record.opcode == mcap.SCHEMA:
                schema = mcap.schema(record.body)
                found.schemas[schema.id] = schema
            elif record.opcode == mcap.CHANNEL:
                channel = mcap.channel(record.body)
                found.channels[channel.id] = channel
            elif record.opcode == mcap.STATISTICS:
                found.counts = mcap.statistics(record.body)
        except DamagedError:
            found.sound = False
