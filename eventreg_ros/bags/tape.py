# SPDX-License-Identifier: Apache-2.0
"""A file as a window that moves forward, with the checksum of all that went by."""

from __future__ import annotations

from functools import lru_cache
from typing import IO
from zlib import crc32

ROOM = 8 * 2**20
"""Bytes that the window holds at most."""


class Tape:
    """``view`` shows what comes next, ``drop`` moves on. Memory: ROOM, whatever the file.

    What ``view`` returned may not be used after the next call of either: the buffer is the same.
    """

    def __init__(self, file: IO[bytes], size: int) -> None:
        self.size = size
        self.at = 0
        self.crc: int | None = None
        """The checksum of what was dropped; None unless somebody set it to 0 to have it."""
        self._file = file
        self._buffer = memoryview(bytearray(min(ROOM, max(size, 1))))
        self._begin = self._end = 0

    @property
    def left(self) -> int:
        """Bytes from here to the end of the file."""
        return self.size - self.at

    def view(self, least: int) -> memoryview:
        """Return what comes next: ``least`` bytes or more, fewer at the end or beyond ROOM."""
        have = self._end - self._begin
        if have < least and have < min(self.left, len(self._buffer)):
            self._fill()
        return self._buffer[self._begin : self._end]

    def _fill(self) -> None:
        kept = self._end - self._begin
        self._buffer[:kept] = bytes(self._buffer[self._begin : self._end])
        self._begin, self._end = 0, kept
        most = min(len(self._buffer), self.left)
        while self._end < most:
            n = self._file.readinto(self._buffer[self._end : most])  # type: ignore[attr-defined]
            if not n:  # the file has become shorter
                self.size = self.at + self._end
                return
            self._end += n

    def drop(self, count: int, crc: int | None = None) -> None:
        """Move on by ``count`` bytes; ``crc`` is their checksum where the caller knows it."""
        whole = count <= self._end - self._begin
        if self.crc is None and not whole:
            self._seek(count)
        elif self.crc is not None and whole and crc is not None:
            self.crc = joined(self.crc, crc, count)
            self._advance(count)
        else:
            self._pass(count)

    def _pass(self, count: int) -> None:
        while count and (seen := self.view(1)[:count]):
            if self.crc is not None:
                self.crc = crc32(seen, self.crc)
            self._advance(len(seen))
            count -= len(seen)

    def _advance(self, count: int) -> None:
        self._begin += count
        self.at += count

    def _seek(self, count: int) -> None:
        self.at = min(self.at + count, self.size)
        self._begin = self._end = 0
        self._file.seek(self.at)


# The checksum of two pieces from their checksums, as zlib's crc32_combine does it -----------------

_POLYNOMIAL = 0xEDB88320


def joined(first: int, second: int, length: int) -> int:
    """Return the CRC-32 of two pieces one after the other; ``length`` is that of the second."""
    return _times(_power(length), first) ^ second


def _times(a: int, b: int) -> int:
    """Return the product of two polynomials over the field of two elements, modulo CRC-32's."""
    product, bit = 0, 1 << 31
    while bit:
        if a & bit:
            product ^= b
        bit >>= 1
        b = (b >> 1) ^ (_POLYNOMIAL if b & 1 else 0)
    return product


@lru_cache(maxsize=256)
def _power(length: int) -> int:
    """Return x to the power of 8 * ``length``."""
    result, factor = 1 << 31, 1 << 23
    while length:
        if length & 1:
            result = _times(factor, result)
        factor = _times(factor, factor)
        length >>= 1
    return result
