# SPDX-License-Identifier: Apache-2.0
"""CDR messages to numbers, a table of equally long ones at a time."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import BagError
from .channel import Bytes, Index
from .definitions import SIZES, Base, Kind, Many, Named, Path, Types

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_HEAD = 4
_LITTLE = 0x0100
_CODES = {'bool': 'u1', 'byte': 'u1', 'char': 'u1'}
_DEEPEST = 32


class Decoded(NamedTuple):
    """Values of messages, shape (n,); ``good`` says which of them could be read, None: all."""

    values: Values
    good: Flags | None


class Decoder(Protocol):
    """Reads one number from each message of a table, shape (n, length)."""

    def __call__(self, data: Bytes) -> Decoded:
        """Return the numbers."""


def float64(data: Bytes) -> Decoded:
    """Read std_msgs/Float64: 4 bytes that name the encoding, and a double in either byte order."""
    count, length = data.shape
    if not 12 <= length < 16:
        return Decoded(np.full(count, np.nan), np.zeros(count, bool))
    values: Values = data[:, 4:12].view('<f8')[:, 0].astype(np.float64)
    if (data[:, :2].view('<u2')[:, 0] == _LITTLE).all():
        return Decoded(values, None)
    kind = data[:, 1]
    good: Flags = (data[:, 0] == 0) & ((kind <= 1) | (kind == 6) | (kind == 7))
    big = data[:, 4:12].view('>f8')[:, 0].astype(np.float64)
    return Decoded(np.where(kind & 1, values, big), None if good.all() else good)


class FieldDecoder:
    """Reads the number at ``path`` of messages of type ``name``."""

    def __init__(self, types: Types, name: str, path: Path) -> None:
        self.types, self.name, self.path = types, name, path

    def __call__(self, data: Bytes) -> Decoded:
        """Return the numbers; not good are messages too short, or in no encoding that we know."""
        count, length = data.shape
        values, good = np.full(count, np.nan), np.zeros(count, bool)
        if length < _HEAD:
            return Decoded(values, good)
        for order in (1, 0):
            rows = np.flatnonzero((data[:, 0] == 0) & (data[:, 1] == order))
            if len(rows):
                self._read(data[:, _HEAD:], rows, '<' if order else '>', values, good)
        return Decoded(values, None if good.all() else good)

    def _read(self, data: Bytes, rows: Index, order: str, values: Values, good: Flags) -> None:
        """Read ``rows``; where a length in them differs, those of each length on their own."""
        pending = [rows]
        while pending:
            rows = pending.pop()
            cursor = _Cursor(self.types, data[rows], order)
            try:
                values[rows] = cursor.find(Named(self.name), self.path)
                good[rows] = True
            except _Differ as differ:
                lengths = differ.lengths
                pending += [rows[lengths == length] for length in np.unique(lengths)]
            except _Short:
                pass


class _Short(Exception):  # noqa: N818
    """The messages end before the number."""


class _Differ(Exception):  # noqa: N818
    """The messages differ in a length, and so in what follows it."""

    def __init__(self, lengths: npt.NDArray[np.int64]) -> None:
        self.lengths = lengths


class _Cursor:
    """A place in messages that agree in every length before it; they begin after the encoding."""

    def __init__(self, types: Types, data: Bytes, order: str) -> None:
        self.types, self.data, self.order = types, data, order
        self.at = 0

    def find(self, kind: Kind, path: Path, depth: int = 0) -> Values:
        """Go to the end of ``path`` within ``kind``, which begins here, and read it."""
        if isinstance(kind, Base):
            return self._number(kind.name)
        step, rest = path[0], path[1:]
        if isinstance(kind, Named):
            for name, field in self._fields(kind, depth):
                if name == step:
                    return self.find(field, rest, depth + 1)
                self._skip(field, depth + 1)
            raise _Short
        count = self._length() if kind.size is None else kind.size
        if not isinstance(step, int) or step >= count:
            raise _Short
        self._skip_many(kind.of, step, depth)
        return self.find(kind.of, rest, depth + 1)

    def _fields(self, kind: Named, depth: int) -> tuple[tuple[str, Kind], ...]:
        fields = self.types.get(kind.name)
        if not fields or depth > _DEEPEST:
            raise BagError(
                f'the type {kind.name} is unknown, empty or within itself, so that no field after '
                'it can be found; choose a field before it'
            )
        return fields

    def _number(self, name: str) -> Values:
        size = SIZES[name]
        self._align(size)
        self._move(size)
        code = _CODES.get(name) or f'{"f" if name[0] == "f" else name[0]}{size}'
        column = np.ascontiguousarray(self.data[:, self.at - size : self.at])
        found: Values = column.view(self.order + code)[:, 0].astype(np.float64)
        return found

    def _length(self) -> int:
        self._align(4)
        self._move(4)
        column = np.ascontiguousarray(self.data[:, self.at - 4 : self.at])
        lengths = column.view(self.order + 'u4')[:, 0].astype(np.int64)
        if (lengths != lengths[0]).any():
            raise _Differ(lengths)
        return int(lengths[0])

    def _skip(self, kind: Kind, depth: int) -> None:
        if isinstance(kind, Many):
            count = self._length() if kind.size is None else kind.size
            self._skip_many(kind.of, count, depth)
        elif isinstance(kind, Named):
            for _, field in self._fields(kind, depth):
                self._skip(field, depth + 1)
        elif kind.name in SIZES:
            self._align(SIZES[kind.name])
            self._move(SIZES[kind.name])
        elif kind.name == 'string':
            self._move(self._length())
        else:
            raise BagError(
                f'a field of type {kind.name} cannot be passed over; choose a field before it'
            )

    def _skip_many(self, kind: Base | Named, count: int, depth: int) -> None:
        if isinstance(kind, Base) and kind.name in SIZES:
            if count:
                self._align(SIZES[kind.name])
                self._move(count * SIZES[kind.name])
            return
        for _ in range(count):  # each moves on, so that a false count ends at the message's end
            self._skip(kind, depth + 1)

    def _align(self, size: int) -> None:
        self.at = -(-self.at // size) * size

    def _move(self, size: int) -> None:
        self.at += size
        if self.at > self.data.shape[1]:
            raise _Short
