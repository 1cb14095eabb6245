# SPDX-License-Identifier: Apache-2.0
"""Message records of MCAP, many at a time: whole buffers as arrays instead of one by one.

A message record is: opcode (1 byte), length of the rest (8), channel (2), sequence (4), log time
(8), publish time (8), data. Those of one length that follow each other are a table; those of
different lengths are found by the bytes that all of them share, and checked as a chain.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import cast

import numpy as np
import numpy.typing as npt

from .channel import Bytes, Group, Index, Messages, Stamps, grouped
from .mcap_records import HEAD, MESSAGE, Record, every_byte

CHANNEL_AT, LOG_AT, PUBLISH_AT, DATA_AT = 9, 15, 23, 31
SHORTEST = DATA_AT - HEAD.size

_HEADS = np.dtype([('opcode', 'u1'), ('length', '<u8')])
_SHORT = 32
_PATIENCE = 64
"""So many runs shorter than _SHORT are taken before the slower way that does not mind."""

Channels = npt.NDArray[np.uint16]


class Table:
    """Message records of one length, one after another: ``rows`` has shape (n, length)."""

    def __init__(self, rows: Bytes, start: int) -> None:
        self.rows = rows
        self.start = start
        self.end = start + rows.size
        self._channels: Channels = _column(rows, CHANNEL_AT, '<u2').astype(np.uint16)
        self._turn = _turn(self._channels)

    def begins(self, at: int) -> bool:
        """Whether a record begins at ``at``, which lies within."""
        return (at - self.start) % int(self.rows.shape[1]) == 0

    def shortened(self) -> Table | None:
        """Return the messages except the last one."""
        return Table(self.rows[:-1], self.start) if len(self.rows) > 1 else None

    def counts(self) -> dict[int, int]:
        """Return the number of messages by channel."""
        rounds = len(self._channels) // self._turn if self._turn else 0
        found = _counts(self._channels[rounds * self._turn :])
        for channel, count in _counts(self._channels[: self._turn]).items():
            found[channel] = found.get(channel, 0) + rounds * count
        return found

    def of(self, channels: list[int]) -> Messages:
        """Return the messages of some channels."""
        rows = self._rows(channels)
        log, publish = _column(rows, LOG_AT, '<i8'), _column(rows, PUBLISH_AT, '<i8')
        same = np.array_equal(log, publish)
        log = log.copy()
        publish = log if same else publish.copy()
        return Messages(log, publish, (Group(None, rows[:, DATA_AT:]),))

    def _rows(self, channels: list[int]) -> Bytes:
        (places,) = np.nonzero(_among(self._channels[: self._turn], channels))
        if len(places) == 1:
            return self.rows[int(places[0]) :: self._turn]
        stride = self.rows.shape[1]
        whole = self.rows.reshape(-1).view(f'V{stride}')
        found = whole.take(np.flatnonzero(_among(self._channels, channels)))
        return found.view(np.uint8).reshape(-1, stride)


class Chain:
    """Message records of different lengths that follow each other in ``data``."""

    def __init__(self, data: Bytes, starts: Index, ends: Index) -> None:
        self.data = data
        self.starts = starts
        self.lengths = ends - starts
        self.start, self.end = int(starts[0]), int(ends[-1])
        self._channels: Channels = self._at(starts + CHANNEL_AT, '<u2').astype(np.uint16)

    def begins(self, at: int) -> bool:
        """Whether a record begins at ``at``, which lies within."""
        i = int(np.searchsorted(self.starts, at))
        return i < len(self.starts) and int(self.starts[i]) == at

    def shortened(self) -> Chain | None:
        """Return the messages except the last one."""
        if len(self.starts) < 2:
            return None
        return Chain(self.data, self.starts[:-1], self.starts[:-1] + self.lengths[:-1])

    def counts(self) -> dict[int, int]:
        """Return the number of messages by channel."""
        return _counts(self._channels)

    def of(self, channels: list[int]) -> Messages:
        """Return the messages of some channels."""
        which = np.flatnonzero(_among(self._channels, channels))
        starts, lengths = self.starts[which], self.lengths[which]
        log: Stamps = self._at(starts + LOG_AT, '<i8')
        publish: Stamps = self._at(starts + PUBLISH_AT, '<i8')
        same = np.array_equal(log, publish)
        groups = grouped(self.data, starts + DATA_AT, lengths - DATA_AT)
        return Messages(log, log if same else publish, groups)

    def _at(self, where: Index, kind: str) -> npt.NDArray[np.int64]:
        return cast('npt.NDArray[np.int64]', every_byte(self.data, 0, kind)[where])


Run = Table | Chain


def items(buffer: memoryview, at: int) -> Iterator[Run | Record]:
    """Yield what is in a buffer from ``at`` on, up to the first record that is not whole."""
    while at + HEAD.size <= len(buffer):
        opcode, length = HEAD.unpack_from(buffer, at)
        after = at + HEAD.size + length
        if opcode == 0 or after > len(buffer):
            return
        if opcode != MESSAGE:
            yield Record(opcode, at, buffer[at + HEAD.size : after], after)
            at = after
        elif length < SHORTEST:
            return
        else:
            for run in runs(buffer, at):
                yield run
                at = run.end


def damaged_after(buffer: memoryview, at: int, room: int) -> bool:
    """Whether what follows at ``at`` is no record, so that what precedes may be damaged too.

    ``room`` bytes are left of the file or the chunk from there on.
    """
    if at + HEAD.size > len(buffer):
        return False
    opcode, length = HEAD.unpack_from(buffer, at)
    return bool(opcode == 0 or HEAD.size + length > room)


def parted(found: list[Run | Record], size: int, places: list[int]) -> bool:
    """Whether items fill a buffer of ``size``, and one begins at each of ``places``, ascending."""
    if not found or found[-1].end != size:
        return False
    starts = [item.start for item in found]
    for place in places:
        item = found[bisect_right(starts, place) - 1]
        if item.start != place and (isinstance(item, Record) or not item.begins(place)):
            return False
    return True


def runs(buffer: memoryview, at: int) -> Iterator[Run]:
    """Yield the messages from ``at`` on, up to the first record that is no whole message."""
    short = 0
    while (table := _table(buffer, at)) is not None:
        if len(table.rows) < _SHORT:
            short += 1
        if short > _PATIENCE:
            chain = _chain(buffer, at)
            yield chain
            at = chain.end
        else:
            yield table
            at = table.end


def _table(buffer: memoryview, at: int) -> Table | None:
    if at + HEAD.size > len(buffer):
        return None
    opcode, length = HEAD.unpack_from(buffer, at)
    stride = HEAD.size + length
    if opcode != MESSAGE or length < SHORTEST or at + stride > len(buffer):
        return None
    most = (len(buffer) - at) // stride
    for count in (min(most, _SHORT), most):
        heads = np.ndarray((count,), _HEADS, buffer, at, (stride,))
        alike = (heads['opcode'] == MESSAGE) & (heads['length'] == length)
        if not alike.all():
            count = int(alike.argmin())
            break
    return Table(np.ndarray((count, stride), np.uint8, buffer, at), at)


def _chain(buffer: memoryview, at: int) -> Chain:
    """Return the messages from ``at`` on; there is at least one."""
    data = np.frombuffer(buffer, np.uint8)
    size = len(data)
    starts = np.flatnonzero(data[at : size - DATA_AT + 1] == MESSAGE) + at
    lengths = every_byte(data, 1, '<u8')[starts]
    whole = (lengths >= SHORTEST) & (lengths <= (size - HEAD.size - starts).astype(np.uint64))
    starts = starts[whole]
    ends = starts + HEAD.size + lengths[whole].astype(np.intp)
    kept = _linked(starts, ends)
    return Chain(data, starts[kept], ends[kept])


def _linked(starts: Index, ends: Index) -> Index:
    """Return which of the candidates form the chain that begins with the first one."""
    breaks = np.flatnonzero(ends[:-1] != starts[1:])
    if not len(breaks):
        return np.arange(len(starts))
    pieces, i = [], 0
    while True:
        k = int(np.searchsorted(breaks, i))
        last = int(breaks[k]) if k < len(breaks) else len(starts) - 1
        pieces.append(np.arange(i, last + 1))
        i = int(np.searchsorted(starts, ends[last]))
        if i == len(starts) or starts[i] != ends[last]:
            return np.concatenate(pieces)


def _column(rows: Bytes, at: int, kind: str) -> npt.NDArray[np.int64]:
    size = np.dtype(kind).itemsize
    return cast('npt.NDArray[np.int64]', rows[:, at : at + size].view(kind)[:, 0])


def _among(channels: Channels, some: list[int]) -> npt.NDArray[np.bool_]:
    """Return which messages are of some channels, of which there is mostly one."""
    return channels == some[0] if len(some) == 1 else np.isin(channels, some)


def _counts(channels: Channels) -> dict[int, int]:
    counts = np.bincount(channels)
    return {number: int(counts[number]) for number in np.flatnonzero(counts).tolist()}


def _turn(channels: Channels) -> int:
    """Return after how many messages the channels repeat in the same order, 0: they do not."""
    if len(channels) == 1:
        return 1
    turn = int((channels[1:257] == channels[0]).argmax()) + 1
    return turn if np.array_equal(channels[turn:], channels[:-turn]) else 0
