# SPDX-License-Identifier: Apache-2.0
"""The samples of one source as they come out of the files, in the order of the files."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from .channel import Bytes, Group, Messages, Stamps
from .compression import ZSTD_MAGIC, unpack
from .messages import Decoded, Decoder, Values

Number = TypeVar('Number', np.int64, np.float64)

_LARGEST = 2**20
"""Bytes that a message packed on its own may unpack to."""


class Samples(NamedTuple):
    """Samples in the order of the files, all of shape (n,); stamps in nanoseconds.

    ``publish`` is None where it is the log time, or where there is none (``published`` says
    which); ``header`` is there where it was asked for.
    """

    log: Stamps
    publish: Stamps | None
    published: bool
    header: Stamps | None
    values: Values


class _Column(Generic[Number]):
    """Numbers that are added block by block, in one array from the beginning."""

    def __init__(self, kind: type[Number]) -> None:
        self._data: npt.NDArray[Number] = np.empty(0, kind)
        self._count = 0

    def expect(self, count: int) -> None:
        """Make room for ``count`` more; what is never filled costs no memory."""
        more = np.empty(self._count + count, self._data.dtype)
        more[: self._count] = self._data[: self._count]
        self._data = more

    def add(self, block: npt.NDArray[Number]) -> None:
        """Add a block of numbers."""
        after = self._count + len(block)
        if after > len(self._data):
            self.expect(len(block) + self._count)
        self._data[self._count : after] = block
        self._count = after

    def all(self) -> npt.NDArray[Number]:
        """Return all numbers."""
        return self._data[: self._count]


class Series:
    """Takes messages and keeps one number of each."""

    def __init__(self, decode: Decoder, stamp: tuple[Decoder, Decoder] | None = None) -> None:
        """``stamp`` reads seconds and nanoseconds of a header, where header times are wanted."""
        self.wrong = 0
        """Messages that are not what their type says."""
        self.wrong_at: int | None = None
        self.count = 0
        self._decode = decode
        self._stamp = stamp
        self._published = True
        self._log, self._values = _Column(np.int64), _Column(np.float64)
        self._publish: _Column[np.int64] | None = None
        self._header = _Column(np.int64)

    def expect(self, count: int) -> None:
        """Make room for ``count`` more messages."""
        self._log.expect(count)
        self._values.expect(count)

    def take(self, messages: Messages) -> None:
        """Decode messages and keep their stamps and values."""
        groups = [part for group in messages.groups for part in _plain(group)]
        values, good = _all(self._decode, groups, len(messages.log))
        log, publish = messages.log, messages.publish
        self._published &= publish is not None
        publish = log if publish is None else publish
        header = self._stamps(groups, len(log))
        if good is not None and not good.all():
            self.wrong += int(np.count_nonzero(~good))
            if self.wrong_at is None:
                self.wrong_at = int(log[int(good.argmin())])
            log, publish, values = log[good], publish[good], values[good]
            header = header if header is None else header[good]
        self._keep(log, publish, values, header)

    def _keep(self, log: Stamps, publish: Stamps, values: Values, header: Stamps | None) -> None:
        if self._publish is None and publish is not log:
            self._publish = _Column(np.int64)
            self._publish.add(self._log.all())
        self.count += len(log)
        self._log.add(log)
        self._values.add(values)
        if self._publish is not None:
            self._publish.add(publish)
        if header is not None:
            self._header.add(header)

    def _stamps(self, groups: list[Group], count: int) -> Stamps | None:
        if self._stamp is None:
            return None
        seconds, nanoseconds = (_all(decode, groups, count).values for decode in self._stamp)
        whole = np.nan_to_num(seconds).astype(np.int64) * 1_000_000_000
        return whole + np.nan_to_num(nanoseconds).astype(np.int64)

    def samples(self) -> Samples:
        """Return everything."""
        publish = self._publish.all() if self._publish is not None and self._published else None
        header = self._header.all() if self._stamp is not None else None
        published = self._published and self.count > 0
        return Samples(self._log.all(), publish, published, header, self._values.all())


def _all(decode: Decoder, groups: list[Group], count: int) -> Decoded:
    """Return the values of all messages, in the order of the file."""
    if len(groups) == 1 and groups[0].which is None:
        return decode(groups[0].data)
    values, good = np.full(count, np.nan), np.zeros(count, bool)
    for which, data in groups:
        where = np.arange(count) if which is None else which
        found = decode(data)
        values[where] = found.values
        good[where] = True if found.good is None else found.good
    return Decoded(values, good)


def _plain(group: Group) -> list[Group]:
    """Return a group as it is, or, where its messages are packed one by one, unpacked."""
    data = group.data
    if data.shape[1] < 8 or not len(data) or data[0, :4].tobytes() != ZSTD_MAGIC:
        return [group]
    index = np.arange(len(data)) if group.which is None else group.which
    found: dict[int, tuple[list[int], list[bytes]]] = {}
    for i, row in enumerate(data):
        message = unpack(row.tobytes(), 'zstd', _LARGEST)
        which, messages = found.setdefault(len(message), ([], []))
        which.append(int(index[i]))
        messages.append(message)
    return [
        Group(np.array(which), _table(messages, length))
        for length, (which, messages) in found.items()
    ]


def _table(messages: list[bytes], length: int) -> Bytes:
    return np.frombuffer(b''.join(messages), np.uint8).reshape(len(messages), length)
