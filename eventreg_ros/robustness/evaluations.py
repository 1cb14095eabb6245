# SPDX-License-Identifier: Apache-2.0
"""Sets that a search asks for, one lot after the other: run in pieces, and kept as they come.

A search asks for the same sets in the same order each time that it is made, so what is kept is
numbered by that order, and a search that was stopped goes on from it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .axes import Array
from .outcome import Rows, nothing
from .plan import Plan
from .sets import Sets
from .store import Store, Stretch
from .sweep import first_piece, next_piece


class Evaluations:
    """Runs what a search of a plan asks for; ``store`` keeps it, None: nothing is kept.

    ``progress`` takes how many sets were run so far.
    """

    def __init__(self, plan: Plan, store: Store | None, progress: Callable[[int], None]) -> None:
        self._sets, self._store, self._progress = Sets(plan), store, progress
        self._size, self._at = first_piece(self._sets), 0
        self._known = nothing(0) if store is None else _begun(store)

    def run(self, columns: Sequence[Array], pool: ThreadPoolExecutor) -> Rows:
        """Return the rows of the next sets, with these values, one array of shape (n,) per axis."""
        count = len(columns[0])
        rows = nothing(count)
        before = self._known[self._at : self._at + count]
        rows[: len(before)] = before
        at = len(before)
        while at < count:
            piece = slice(at, min(at + self._size, count))
            rows[piece] = self._piece([column[piece] for column in columns], at, pool)
            at = piece.stop
            self._progress(self._at + at)
        self._at += count
        return rows

    def _piece(self, columns: Sequence[Array], at: int, pool: ThreadPoolExecutor) -> Rows:
        began, count = time.perf_counter(), len(columns[0])
        outcomes = self._sets.run(columns, pool)
        seconds = max(time.perf_counter() - began, 1e-3)
        self._size = next_piece(self._size, count / seconds)
        if self._store is not None:
            first = self._at + at
            self._store.save(Stretch(first, first + count), outcomes, seconds)
        return outcomes.rows


def _begun(store: Store) -> Rows:
    """Return the rows that are kept, from the first on as far as none is missing."""
    missing = store.missing(10**12)
    end, found = missing[0].first, [nothing(0)]
    found += [outcomes.rows for stretch, outcomes in store.outcomes() if stretch.last <= end]
    return np.concatenate(found)


@contextmanager
def kept(plan: Plan, out: Path | None) -> Iterator[Store | None]:
    """Yield what keeps a search in the directory ``out``, None without one, until it is done.

    Raises EventregError for a directory that holds something else.
    """
    if out is None:
        yield None
        return
    store = Store(out, plan)
    with store.alone():
        yield store
        store.forget_parts()
