# SPDX-License-Identifier: Apache-2.0
"""Small tables of an SQLite file, row by row, and rows that go on in other pages.

Not by SQL: a damaged or a cut file that SQLite refuses as a whole still has its topics, and nothing
that a hostile one defines (views, triggers, expressions) is ever run.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from . import sqlite_pages as sqlite
from .sqlite_pages import TABLE_INTERIOR, TABLE_LEAF, Cells, Layout, Pages

Value = None | int | float | str | bytes

_MOST_ROWS = 100_000
_LONGEST = 8 * 2**20
"""A row of more bytes is not read."""
_CONSTRAINTS = ('PRIMARY', 'UNIQUE', 'CHECK', 'FOREIGN', 'CONSTRAINT')


class Row(NamedTuple):
    """A row: its id, which stands for the first column where that is the key, and its values."""

    id: int
    values: list[Value]


def rows(pages: Pages, layout: Layout, root: int) -> Iterator[Row]:
    """Yield the rows of the table whose first page is ``root``, as far as they can be read."""
    leaves = sqlite.tree(pages, layout, root, TABLE_INTERIOR).leaves
    for number in leaves.tolist():
        numbers = np.array([number])
        cells = sqlite.cells(pages(numbers), numbers, layout, TABLE_LEAF)
        for i in range(min(len(cells.starts), _MOST_ROWS)):
            payload = payload_of(pages, layout, cells, i)
            if payload is not None:
                yield Row(int(cells.rows[i]), _values(payload))


def payload_of(pages: Pages, layout: Layout, cells: Cells, i: int) -> bytes | None:
    """Return the record of a row, wherever it lies, None where it is not whole or too long."""
    start, length = int(cells.starts[i]), int(cells.lengths[i])
    local = layout.local(length)
    found = cells.data[start : start + local].tobytes()
    if local == length or length > _LONGEST:
        return found if local == length else None
    pieces = [found]
    following = int.from_bytes(cells.data[start + local : start + local + 4].tobytes(), 'big')
    left = length - local
    while left > 0:
        if not 1 <= following <= layout.pages:
            return None
        page = pages(np.array([following]))[0].tobytes()
        piece = page[4 : min(layout.usable, 4 + left)]
        pieces.append(piece)
        following = int.from_bytes(page[:4], 'big')
        left -= len(piece)
    return b''.join(pieces)


def _values(record: bytes) -> list[Value]:
    """Return the values of a record, those that are cut off as None."""
    head, at = _varint(record, 0)
    kinds = []
    while at < min(head, len(record)):
        kind, at = _varint(record, at)
        kinds.append(kind)
    values = []
    at = head
    for kind in kinds:
        size = sqlite.size_of(kind)
        values.append(_value(record[at : at + size], kind, size))
        at += size
    return values


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for at in range(at, min(at + 8, len(data))):  # noqa: B020
        value = value << 7 | data[at] & 0x7F
        if not data[at] & 0x80:
            break
    return value, at + 1


def _value(data: bytes, kind: int, size: int) -> Value:
    if kind == 0 or len(data) < size:
        return None
    if kind in (8, 9):
        return kind - 8
    if kind == 7:
        return float(struct.unpack('>d', data)[0])
    if kind < 7:
        return int.from_bytes(data, 'big', signed=True)
    return data.decode('utf-8', 'replace') if kind % 2 else data


def columns(statement: str) -> list[str]:
    """Return the names of the columns that a CREATE TABLE statement declares."""
    inner = statement[statement.find('(') + 1 : statement.rfind(')')]
    inner = re.sub(r'\([^()]*\)', '', inner)  # DECIMAL(10, 2)
    words = [part.split() for part in inner.split(',')]
    return [w[0].strip('"`[]\'') for w in words if w and w[0].upper() not in _CONSTRAINTS]
