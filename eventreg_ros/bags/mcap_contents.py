# SPDX-License-Identifier: Apache-2.0
"""What chunks of an MCAP file hold: unpacked, checked, and handed on."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate
from zlib import crc32

from .compression import TornError, unpack, unpacked
from .mcap_delivery import Delivery
from .mcap_messages import Run, damaged_after, items, parted
from .mcap_records import HEAD, Chunk, Record, find_record
from .mcap_trouble import Trouble
from .tape import ROOM

_JOIN = 2**20
"""Chunks are read together up to so many bytes: many small ones cost no more than a few large."""
_SMALL = _JOIN // 4
_PART = ROOM // 2
_HOPELESS = 2 * ROOM
"""A chunk in which nothing can be read for so many bytes is given up."""


class Contents:
    """Reads chunks, and hands their messages on in order."""

    def __init__(self, to: Delivery, trouble: Trouble) -> None:
        self.to = to
        self.trouble = trouble
        self._joined: list[tuple[bytes, Chunk]] = []
        self._size = 0

    def whole(self, packed: memoryview, head: Chunk, cut: bool) -> int | None:
        """Read a chunk that is in memory; ``cut``: the file ends within.

        Return the checksum of ``packed`` where that came for nothing.
        """
        data: bytes | memoryview = packed
        if head.compression:
            data = unpack(packed, head.compression, head.size)
        if len(data) != head.size and not cut:
            self._hole(abs(head.size - len(data)), head)
        crc = crc32(data) if head.crc and not cut else None
        sound = crc is None or crc == head.crc
        if not sound:
            self.trouble.failed(head.start)
        self.trouble.unchecked |= not head.crc
        if sound and not cut and len(data) < _SMALL:
            self._join(bytes(data), head)
        else:
            self.flush()
            self._walk(memoryview(data), head, sound, head.size - len(data) if cut else 0)
        return None if head.compression else crc

    def _join(self, data: bytes, head: Chunk) -> None:
        self._joined.append((data, head))
        self._size += len(data)
        if self._size > _JOIN:
            self.flush()

    def flush(self) -> None:
        """Read the small chunks that have gathered, as one if nothing is wrong with any."""
        parts, self._joined, self._size = self._joined, [], 0
        if len(parts) > 1:
            places = list(accumulate((len(data) for data, _ in parts), initial=0))
            whole = memoryview(b''.join(data for data, _ in parts))
            found = list(items(whole, 0))
            if parted(found, len(whole), places[:-1]):
                for item in found:
                    self._take(item, True)
                return
        for data, head in parts:
            self._walk(memoryview(data), head, True, 0)

    def stream(self, packed: Iterator[bytes], head: Chunk, cut: bool) -> None:
        """Read a chunk that is too large for the window, piece by piece."""
        self.flush()
        crc, done, lost, skip, rest = 0, 0, 0, 0, b''
        try:
            for piece in unpacked(packed, head.compression) if head.compression else packed:
                crc, done = crc32(piece, crc), done + len(piece)
                rest += piece[skip:]
                skip = max(skip - len(piece), 0)
                if len(rest) < _PART:
                    continue
                holes = len(self.trouble.holes)
                read = self._walk(memoryview(rest), head, True, max(head.size - done, 0))
                lost = lost + read if len(self.trouble.holes) > holes else 0
                rest = rest[read:]
                if len(rest) >= _PART:  # one record, and nobody's
                    skip = HEAD.size + HEAD.unpack_from(rest)[1] - len(rest)
                    rest = b''
                if lost > _HOPELESS or done > head.size:
                    break
        except TornError:
            pass
        self._walk(memoryview(rest), head, True, 0)
        self.trouble.unchecked |= not head.crc
        if done != head.size and not cut:
            self._hole(abs(head.size - done), head)
        elif head.crc and crc != head.crc and not cut:
            self.trouble.failed(head.start)

    def _walk(self, buffer: memoryview, head: Chunk, sound: bool, more: int) -> int:
        """Read what a chunk holds; ``more`` bytes of it follow. Return how far that went."""
        at = 0
        while True:
            for item in items(buffer, at):
                at = item.end
                self._take(item, sound, damaged_after(buffer, at, len(buffer) - at + more))
            left = len(buffer) - at
            if not left or (more and _incomplete(buffer, at, left + more)):
                return at
            found = find_record(buffer, at + 1, len(buffer))
            end = len(buffer) if found is None else found
            self._hole(end - at, head)
            at = end

    def _take(self, item: Run | Record, sound: bool, doubtful: bool = False) -> None:
        """Hand an item on; the last message before damage is ``doubtful``, and left out."""
        if isinstance(item, Record):
            self.to.declare(item, sound)
        elif (run := item.shortened() if doubtful else item) is not None:
            self.to.deliver(run)

    def _hole(self, size: int, head: Chunk) -> None:
        self.trouble.hole(size, head.start if self.to.latest is None else self.to.latest)


def _incomplete(buffer: memoryview, at: int, room: int) -> bool:
    """Whether a record begins here whose rest may follow."""
    if at + HEAD.size > len(buffer):
        return True
    opcode, length = HEAD.unpack_from(buffer, at)
    return bool(opcode) and HEAD.size + length <= room
