# SPDX-License-Identifier: Apache-2.0
"""What files hold, whatever their format: channels, and messages of one channel at a time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import BagError
from .finding import Note

Stamps = npt.NDArray[np.int64]
Index = npt.NDArray[np.intp]
Bytes = npt.NDArray[np.uint8]

FLOAT64 = 'std_msgs/msg/Float64'


class UnreadableError(BagError):
    """One file of a bag cannot be read; others may be."""


class Channel(NamedTuple):
    """A topic as one file describes it.

    ``type`` is like std_msgs/msg/Float64, '' where the file does not say; ``encoding`` is cdr for
    ROS 2; ``definition`` the text of the type, ``format`` its language (ros2msg, ros2idl or '').
    """

    topic: str
    type: str
    encoding: str
    definition: str
    format: str


class Group(NamedTuple):
    """Messages of equal length: ``data`` (m, length), and ``which`` they are of all, None: all."""

    which: Index | None
    data: Bytes


class Messages(NamedTuple):
    """Messages of one channel in the order of the file.

    ``log`` and ``publish`` are their time stamps in nanoseconds, both of shape (n,); ``publish`` is
    None where the file has no such stamp. Nothing here may be kept: it is a view of a buffer.
    """

    log: Stamps
    publish: Stamps | None
    groups: tuple[Group, ...]


class Taker(Protocol):
    """Takes the messages of a channel as they are read."""

    def expect(self, count: int) -> None:
        """Make room for so many messages: a hint, never more than the file could hold."""

    def take(self, messages: Messages) -> None:
        """Take what comes next in the file."""


Select = Callable[[Channel], 'Taker | None']
"""Called once for each channel of a file: who takes its messages, None: nobody wants them."""


@dataclass
class Account:
    """What the reader of a file reports beside the messages.

    ``read`` counts the messages read by topic, ``promised`` what statistics or an index promise, by
    who promises; ``custom`` is the recorder's own data (the scenario).
    """

    channels: list[Channel] = field(default_factory=list)
    read: Counter[str] = field(default_factory=Counter)
    promised: dict[str, Counter[str]] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)
    custom: dict[str, str] = field(default_factory=dict)

    def note(
        self, code: str, text: str, *, topic: str | None = None, stamp: int | None = None
    ) -> None:
        """Add a note."""
        self.notes.append(Note(code, topic, stamp, text))


def by_taker(takers: Iterable[tuple[int, Taker | None]]) -> list[tuple[Taker, list[int]]]:
    """Return who takes the messages of which channels: of one topic there may be several."""
    found: dict[int, tuple[Taker, list[int]]] = {}
    for number, taker in takers:
        if taker is not None:
            found.setdefault(id(taker), (taker, []))[1].append(number)
    return list(found.values())


class Spans:
    """From when to when each channel was written: two of one topic at a time are two writers."""

    def __init__(self) -> None:
        self._spans: dict[int, tuple[int, int]] = {}

    def add(self, number: int, log: Stamps) -> None:
        """Add messages of a channel."""
        low, high = int(log[0]), int(log[-1])
        before = self._spans.get(number, (low, high))
        self._spans[number] = min(low, before[0]), max(high, before[1])

    def judge(self, channels: Mapping[int, Channel], account: Account) -> None:
        """Note the topics that had two channels at a time."""
        by_topic: dict[str, list[tuple[int, int]]] = {}
        for number, span in self._spans.items():
            by_topic.setdefault(channels[number].topic, []).append(span)
        for topic, spans in by_topic.items():
            for before, after in pairwise(sorted(spans)):
                if after[0] < before[1]:
                    text = f'two sources wrote {topic}, each on a channel of its own'
                    account.note('second-writer', text, topic=topic, stamp=after[0])
                    break


def absolute(topic: str) -> str:
    """Return a topic with one slash before it, which not all writers put there, and printable."""
    return '/' + _printable(topic.strip('/'))


def full_type(name: str) -> str:
    """Return a type's name with its /msg/, which some writers leave out."""
    name = _printable(name)
    package, _, rest = name.partition('/')
    return name if '/' in rest or not rest else f'{package}/msg/{rest}'


def _printable(text: str) -> str:
    return text if text.isprintable() else text.encode('unicode_escape').decode()


def each(group: Group) -> Iterator[tuple[int, bytes]]:
    """Yield the messages of a group one by one: which, and its bytes."""
    for i, row in enumerate(group.data):
        yield i if group.which is None else int(group.which[i]), row.tobytes()


def grouped(data: Bytes, starts: Index, lengths: Index) -> tuple[Group, ...]:
    """Return the messages that lie in ``data``, by their length."""
    if not len(starts):
        return ()
    if (lengths == lengths[0]).all():
        return (Group(None, _rows(data, starts, int(lengths[0]))),)
    groups = []
    for length in np.unique(lengths).tolist():
        index = np.flatnonzero(lengths == length)
        groups.append(Group(index, _rows(data, starts[index], length)))
    return tuple(groups)


def _rows(data: Bytes, starts: Index, length: int) -> Bytes:
    if length <= 0:
        return np.empty((len(starts), 0), np.uint8)
    return np.lib.stride_tricks.sliding_window_view(data, length)[starts]
