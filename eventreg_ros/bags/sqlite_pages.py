# SPDX-License-Identifier: Apache-2.0
"""B-trees of an SQLite file: pages to rows, many at a time. Knows no files, only pages by number.

The format is sqlite.org/fileformat2.html. SQL gives one row after another at a microsecond each,
and nothing at all behind a damaged page; the pages themselves are tables of bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .channel import Bytes, Index, Stamps

TABLE_LEAF, TABLE_INTERIOR, INDEX_LEAF, INDEX_INTERIOR = 0x0D, 0x05, 0x0A, 0x02
_LEAVES = {TABLE_INTERIOR: TABLE_LEAF, INDEX_INTERIOR: INDEX_LEAF}
_DEEPEST = 32
_SIZES = (0, 1, 2, 3, 4, 6, 8, 8, 0, 0)
"""Bytes of a value by its serial type, up to 9; NULL, integers, a float, and the constants 0, 1."""
_PADDING = 32

Pages = Callable[[Index], Bytes]
"""Return pages by number, counted from 1: shape (n, page size), zeros where there is no page."""


class Layout(NamedTuple):
    """Page size, bytes at the end of each that are not used, and number of pages."""

    size: int
    reserved: int
    pages: int

    @property
    def usable(self) -> int:
        """Bytes of a page that may be used."""
        return self.size - self.reserved

    def local(self, length: int) -> int:
        """Return how much of a row of ``length`` bytes is in its own page."""
        most = self.usable - 35
        if length <= most:
            return length
        least = (self.usable - 12) * 32 // 255 - 23
        part = least + (length - least) % (self.usable - 4)
        return part if part <= most else least


class Tree(NamedTuple):
    """The pages of a b-tree in order; ``broken`` are those that are not what they should be."""

    leaves: Index
    interior: Index
    broken: list[int]


class Cells(NamedTuple):
    """Rows in a buffer: where their records begin, their lengths in all, and their row ids.

    ``data`` ends with a few bytes of padding. ``bad`` rows make no sense, and are not among them.
    """

    data: Bytes
    starts: Index
    lengths: Index
    rows: Index
    bad: int


def tree(pages: Pages, layout: Layout, root: int, kind: int) -> Tree:
    """Return the pages below ``root``; ``kind`` is TABLE_INTERIOR or INDEX_INTERIOR."""
    level, broken = np.array([root]), list[int]()
    interior: list[Index] = []
    seen: set[int] = set()
    for _ in range(_DEEPEST):
        inner: list[Index] = []
        flags = _flags(pages, level)
        if (flags == _LEAVES[kind]).any() or not (flags == kind).any():
            good = flags == _LEAVES[kind]
            broken += level[~good].tolist()
            found = np.concatenate(interior) if interior else np.empty(0, np.intp)
            return Tree(level[good], found, broken)
        broken += level[flags != kind].tolist()
        level = level[flags == kind]
        interior.append(level)
        for number in level.tolist():
            inner.append(_children(pages(np.array([number]))[0], number, layout))
        level = np.concatenate(inner) if inner else np.empty(0, np.intp)
        outside = (level < 1) | (level > layout.pages)
        broken += level[outside].tolist()
        level = _first_time(level[~outside], seen)
    return Tree(np.empty(0, np.intp), np.empty(0, np.intp), [root])


def _first_time(level: Index, seen: set[int]) -> Index:
    """Return the pages that were not met before: a page that is named twice ends no search."""
    _, first = np.unique(level, return_index=True)
    level = level[np.sort(first)]
    level = level[[number not in seen for number in level.tolist()]] if seen else level
    seen.update(level.tolist())
    return level


def _flags(pages: Pages, numbers: Index) -> Bytes:
    """Return the first byte of each page's head."""
    found = [
        pages(part)[np.arange(len(part)), np.where(part == 1, 100, 0)]
        for part in np.array_split(numbers, max(len(numbers) // 512, 1))
    ]
    return np.concatenate(found) if found else np.empty(0, np.uint8)


def _children(page: Bytes, number: int, layout: Layout) -> Index:
    """Return the pages that an interior page points to, in order."""
    head = 100 if number == 1 else 0
    count = int.from_bytes(page[head + 3 : head + 5].tobytes(), 'big')
    count = min(count, (layout.size - head - 12) // 2)
    places = page[head + 12 : head + 12 + 2 * count].view('>u2').astype(np.intp)
    places = places[places <= layout.size - 4]
    left = np.stack([page[places + i].astype(np.intp) << (24 - 8 * i) for i in range(4)]).sum(0)
    right = int.from_bytes(page[head + 8 : head + 12].tobytes(), 'big')
    return np.append(left, right)


def cells(found: Bytes, numbers: Index, layout: Layout, kind: int) -> Cells:
    """Return the rows of pages, shape (n, page size), of one ``kind``, in order."""
    heads = np.where(numbers == 1, 100, 0)
    which = np.arange(len(found))
    counts = found[which, heads + 3].astype(np.intp) * 256 + found[which, heads + 4]
    first = heads + (8 if kind in (TABLE_LEAF, INDEX_LEAF) else 12)
    fits = first + 2 * counts <= layout.usable
    bad = int(np.count_nonzero(~fits))
    counts = np.where(fits, counts, 0)
    page = np.repeat(which, counts)
    nth = np.arange(len(page)) - np.repeat(np.cumsum(counts) - counts, counts)
    data = np.concatenate([found.reshape(-1), np.zeros(_PADDING, np.uint8)])
    pointer = page * layout.size + np.repeat(first, counts) + 2 * nth
    offset = data[pointer].astype(np.intp) * 256 + data[pointer + 1]
    good = (offset >= np.repeat(first + 2 * counts, counts)) & (offset < layout.usable)
    bad += int(np.count_nonzero(~good))
    starts = (page * layout.size + offset)[good]
    if kind == INDEX_INTERIOR:
        starts = starts + 4
    lengths, starts = varints(data, starts)
    rows = np.zeros(len(starts), np.intp)
    if kind == TABLE_LEAF:
        rows, starts = varints(data, starts)
    return Cells(data, starts, lengths, rows, bad)


def varints(data: Bytes, at: Index) -> tuple[Index, Index]:
    """Return SQLite's numbers of varying length (up to 8 bytes of 9), and where they end."""
    last = len(data) - 1
    byte = data[np.minimum(at, last)]
    value, after = (byte & 0x7F).astype(np.intp), at + 1
    more = np.flatnonzero(byte & 0x80)
    for _ in range(7):
        if not len(more):
            break
        byte = data[np.minimum(after[more], last)]
        value[more] = value[more] << 7 | (byte & 0x7F)
        after[more] += 1
        more = more[(byte & 0x80) != 0]
    return value, after


class Form(NamedTuple):
    """Rows whose records have the same head: which they are, and serial type by column."""

    which: Index
    head: int
    types: list[int]

    def place(self, column: int) -> tuple[int, int]:
        """Return where a column begins in the record, and its size."""
        sizes = [size_of(kind) for kind in self.types]
        return self.head + sum(sizes[:column]), sizes[column]

    def integers(self, data: Bytes, starts: Index, column: int) -> Stamps:
        """Return the values of a column that holds integers; ``starts`` are where records begin."""
        place, _ = self.place(column)
        return integers(data, starts + place, self.types[column])


def size_of(kind: int) -> int:
    """Return the bytes that a value of a serial type takes."""
    return _SIZES[kind] if kind < 10 else max(kind - 12, 0) // 2


def forms(rows: Cells, columns: int) -> Iterator[Form]:
    """Yield groups of rows of equal form; those of other than so many ``columns`` are left out."""
    data = rows.data
    heads = np.ndarray((len(data) - 7,), '<u8', data, 0, (1,))[rows.starts]
    length = (heads & np.uint64(0xFF)).astype(np.uint64)
    usable = (length >= 2) & (length <= 8)
    heads = np.where(usable, heads & _mask(length), np.uint64(0))
    left = np.flatnonzero(usable)
    while len(left):
        head = heads[left[0]]
        alike = heads[left] == head
        types = _types(int(head).to_bytes(8, 'little'))
        if len(types) == columns:
            yield Form(left[alike], int(head) & 0xFF, types)
        left = left[~alike]


def _mask(length: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Return masks that keep so many bytes of 8."""
    drop = np.uint64(64) - np.uint64(8) * np.minimum(length, np.uint64(8))
    masks: npt.NDArray[np.uint64] = np.uint64(0xFFFFFFFFFFFFFFFF) >> np.minimum(drop, np.uint64(63))
    return masks


def _types(head: bytes) -> list[int]:
    """Return the serial types of a record's head."""
    types, at, value = [], 1, 0
    while at < head[0]:
        value = value << 7 | head[at] & 0x7F
        if not head[at] & 0x80:
            types.append(value)
            value = 0
        at += 1
    return types


def integers(data: Bytes, at: Index, kind: int) -> Stamps:
    """Return the integers of a serial type that begin at ``at``; NULL counts as 0."""
    if kind in (8, 9):
        return np.full(len(at), kind - 8, np.int64)
    size = size_of(kind) if kind < 7 else 0
    if not size:
        return np.zeros(len(at), np.int64)
    last = len(data) - 8  # a row that claims to go on behind its page is no row
    at = np.minimum(at, last)
    wide: Stamps = np.ndarray((last + 1,), '>i8', data, 0, (1,))[at].astype(np.int64)
    wide >>= 64 - 8 * size
    return wide
