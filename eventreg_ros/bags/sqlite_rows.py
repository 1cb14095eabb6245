# SPDX-License-Identifier: Apache-2.0
"""The messages of a .db3 file, from its pages to those who want them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from . import sqlite_pages as sqlite
from .channel import (
    Account,
    Bytes,
    Channel,
    Group,
    Index,
    Messages,
    Select,
    Spans,
    Stamps,
    Taker,
    by_taker,
    grouped,
)
from .sqlite_pages import (
    INDEX_INTERIOR,
    INDEX_LEAF,
    TABLE_INTERIOR,
    TABLE_LEAF,
    Cells,
    Layout,
    Pages,
)
from .sqlite_table import payload_of

_BATCH = 2 * 2**20
"""Bytes of pages that are read together."""


class _Sums(NamedTuple):
    """What rows and index must agree in: how many stamps, and two checks on them."""

    rows: int = 0
    total: int = 0
    mixed: int = 0

    def plus(self, stamps: Stamps) -> _Sums:
        """Return the sums with more stamps."""
        total = int(stamps.view(np.uint64).sum(dtype=np.uint64))
        mixed = int(np.bitwise_xor.reduce(stamps)) if len(stamps) else 0
        return _Sums(self.rows + len(stamps), (self.total + total) % 2**64, self.mixed ^ mixed)


class _Rows(NamedTuple):
    """Rows in a buffer, a column each: topic id, stamp, which row, and where its data lie."""

    topics: Index
    stamps: Stamps
    which: Index
    starts: Index
    lengths: Index


class Rows:
    """One pass through the messages of a file."""

    def __init__(
        self, name: str, pages: Pages, layout: Layout, columns: list[str], account: Account
    ) -> None:
        """``columns`` are those of the messages' table, in order."""
        self.name, self.pages, self.layout, self.account = name, pages, layout, account
        self.columns = columns
        self.channels: dict[int, Channel] = {}
        self.bad = 0
        self.sums = _Sums()
        self.spans = Spans()
        self.last_row: int | None = None
        self.last_stamp: int | None = None
        self.lost_at: int | None = None

    def run(self, root: int, index: int, channels: dict[int, Channel], select: Select) -> None:
        """Hand the messages of the table at ``root`` on; what is wrong is in the account.

        ``index`` is the first page of the index of their stamps, 0 where there is none.
        """
        self.channels = channels
        takers = {number: select(channel) for number, channel in channels.items()}
        tree = sqlite.tree(self.pages, self.layout, root, TABLE_INTERIOR)
        self._read(tree.leaves, takers)
        if tree.broken:
            known = np.concatenate([tree.leaves, tree.interior])
            self._read(self._orphans(known), takers)
        self._judge(len(tree.broken), self._index_sums(index) if index else None)

    # Pages ------------------------------------------------------------------------------------

    def _batches(self, numbers: Index) -> Iterator[tuple[Index, Bytes]]:
        step = max(_BATCH // self.layout.size, 1)
        for at in range(0, len(numbers), step):
            part = numbers[at : at + step]
            yield part, self.pages(part)

    def _orphans(self, known: Index) -> Index:
        """Return the pages of rows that no page leads to any more."""
        found = []
        others = np.setdiff1d(np.arange(2, self.layout.pages + 1), known, assume_unique=False)
        for numbers, pages in self._batches(others):
            found.append(numbers[pages[:, 0] == TABLE_LEAF])
        return np.concatenate(found) if found else np.empty(0, np.intp)

    # Rows -------------------------------------------------------------------------------------

    def _read(self, leaves: Index, takers: dict[int, Taker | None]) -> None:
        for numbers, pages in self._batches(leaves):
            cells = sqlite.cells(pages, numbers, self.layout, TABLE_LEAF)
            rows = self._rows(cells)
            self._count(cells, rows)
            there = np.unique(rows.topics).tolist()
            for taker, topics in by_taker((number, takers[number]) for number in there):
                which = np.isin(rows.topics, topics)
                chosen = _Rows(*(column[which] for column in rows))
                self.account.read[self.channels[topics[0]].topic] += len(chosen.topics)
                self._hand_on(cells, chosen, taker)
                for number in topics:
                    self.spans.add(number, chosen.stamps[chosen.topics == number])

    def _rows(self, cells: Cells) -> _Rows:
        """Return the rows of known topics, in order; others make no sense."""
        columns = self.columns
        topic_at, stamp_at, data_at = (columns.index(c) for c in ('topic_id', 'timestamp', 'data'))
        none = np.empty(0, np.intp)
        parts = [_Rows(none, none.astype(np.int64), none, none, none)]
        for form in sqlite.forms(cells, len(columns)):
            starts = cells.starts[form.which]
            topics = form.integers(cells.data, starts, topic_at)
            place, size = form.place(data_at)
            good = np.isin(topics, list(self.channels)) & (form.types[data_at] >= 12)
            good &= cells.lengths[form.which] == place + size
            stamps = form.integers(cells.data, starts, stamp_at)
            sizes = np.full(len(starts), size)
            part = _Rows(topics, stamps, form.which, starts + place, sizes)
            parts.append(part if good.all() else _Rows(*(column[good] for column in part)))
        if len(parts) == 2:
            return parts[1]
        merged = _Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        order = np.argsort(merged.which, kind='stable')
        return _Rows(*(column[order] for column in merged))

    def _count(self, cells: Cells, rows: _Rows) -> None:
        """Add to the sums, and look for row ids that are left out."""
        self.bad += cells.bad + len(cells.starts) - len(rows.which)
        self.sums = self.sums.plus(rows.stamps)
        if not len(rows.which):
            return
        ids = cells.rows[rows.which]
        before = ids[0] - 1 if self.last_row is None else self.last_row
        steps = np.diff(ids, prepend=before)
        if self.lost_at is None and (steps != 1).any():
            first = int((steps != 1).argmax())
            self.lost_at = int(rows.stamps[first - 1]) if first else self.last_stamp
        self.last_row, self.last_stamp = int(ids[-1]), int(rows.stamps[-1])

    def _hand_on(self, cells: Cells, rows: _Rows, taker: Taker) -> None:
        local = self.layout.usable - 35
        if (cells.lengths[rows.which] <= local).all():
            groups = grouped(cells.data, rows.starts, rows.lengths)
            taker.take(Messages(rows.stamps, None, groups))
            return
        for i, number in enumerate(rows.which.tolist()):  # some go on in other pages
            payload = payload_of(self.pages, self.layout, cells, number)
            if payload is None:
                self.bad += 1
                continue
            place = int(rows.starts[i] - cells.starts[number])
            data = np.frombuffer(payload, np.uint8)[None, place : place + int(rows.lengths[i])]
            taker.take(Messages(rows.stamps[i : i + 1], None, (Group(None, data),)))

    # What is wrong ------------------------------------------------------------------------------

    def _judge(self, broken: int, index: _Sums | None) -> None:
        name, account = self.name, self.account
        self.spans.judge(self.channels, account)
        if broken or self.bad:
            what = [f'{broken} pages'] * bool(broken) + [f'{self.bad} rows'] * bool(self.bad)
            text = f'{" and ".join(what)} of {name} cannot be read'
            account.note('damaged', text, stamp=self.lost_at or self.last_stamp)
        if index is None or index == self.sums:
            return
        if index.rows > self.sums.rows:
            lost = (
                f'{self.sums.rows} of {index.rows} rows of {name} were read: its index lists more'
            )
            account.note('lost-samples', lost, stamp=self.lost_at or self.last_stamp)
        else:
            text = f'index and rows of {name} disagree in stamps; the rows were read'
            account.note('index-disagrees', text)

    def _index_sums(self, root: int) -> _Sums:
        """Return the sums over the index."""
        tree = sqlite.tree(self.pages, self.layout, root, INDEX_INTERIOR)
        sums = _Sums()
        for numbers, kind in ((tree.leaves, INDEX_LEAF), (tree.interior, INDEX_INTERIOR)):
            for part, pages in self._batches(numbers):
                cells = sqlite.cells(pages, part, self.layout, kind)
                for form in sqlite.forms(cells, 2):
                    starts = cells.starts[form.which]
                    sums = sums.plus(form.integers(cells.data, starts, 0))
        return sums
