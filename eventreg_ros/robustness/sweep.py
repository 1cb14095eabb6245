# SPDX-License-Identifier: Apache-2.0
"""A sweep: every set of a plan run, kept as it goes, and the table of them all."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.export import need
from ..files import scratch_prefix
from ..printed import Printed
from .axes import Array
from .outcome import VERDICTS, Outcomes
from .plan import Plan
from .sets import Sets
from .store import Store, Stretch
from .table import batches, check_table, joined, known, read_table, write_table

if TYPE_CHECKING:
    import pandas

Progress = Callable[[int, int], None]
"""Takes how many sets are done, and how many there are."""

AIM = 2.0
"""Seconds of work after which what is done is kept."""

FIRST, MOST = 64, 1 << 16
"""Sets that are run together at the start in lanes, and at most."""

Run = Callable[[Plan, Sequence[Stretch]], Iterator[tuple[Stretch, Outcomes]]]
"""Runs stretches of a plan's sets, in any order and any pieces."""


@dataclass(frozen=True, repr=False)
class Sweep(Printed):
    """What came of a sweep. Counts are of sets; ``bad`` ones were refused or diverged.

    ``seconds`` is how long it took, all runs together if it was stopped; ``out`` the directory,
    None if nothing was kept.
    """

    plan: Plan
    sets: int
    rejected: int
    not_rejected: int
    undecided: int
    bad: int
    seconds: float
    out: Path | None
    _read: Callable[[Sequence[str] | None], dict[str, Array]]

    def __repr__(self) -> str:
        return (
            f'<Sweep of {self.plan.name}: {self.sets} sets, {self.rejected} rejected, '
            f'{self.not_rejected} not, {self.undecided} undecided>'
        )

    def __str__(self) -> str:
        from .sweep_words import sweep_words

        return sweep_words(self)

    @cached_property
    def columns(self) -> dict[str, Array]:
        """The table, shape (sets,) each: a column per parameter, then verdict and numbers."""
        return self._read(None)

    def only(self, names: Sequence[str]) -> dict[str, Array]:
        """Return some columns of the table: a table of millions of sets is large."""
        if 'columns' in self.__dict__:
            return {name: self.columns[name] for name in names}
        return self._read(names)

    def __getitem__(self, column: str) -> Array:
        """Return one column of the table. Raises KeyError."""
        return self.only([column])[column]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table as a pandas DataFrame, a row a set. Raises EventregError without it."""
        need('pandas', 'to_dataframe()')
        import pandas

        return pandas.DataFrame(self.columns)

    def as_json(self) -> dict[str, Any]:
        """Return what --json writes."""
        named = [text.partition(':=')[::2] for text in self.plan.parameters]
        specs = {name.strip(): spec.strip() for name, spec in named}
        varied = {axis.name: specs[axis.name] for axis in self.plan.axes}
        counts = ('sets', 'rejected', 'not_rejected', 'undecided', 'bad')
        return {
            'parameters': varied,
            **{name: getattr(self, name) for name in counts},
            'seconds': round(self.seconds, 3),
            'out': None if self.out is None else str(self.out),
        }


def run_sweep(
    plan: Plan,
    out: Path | None = None,
    run: Run | None = None,
    progress: Progress = lambda done, count: None,
) -> Sweep:
    """Run what is missing of a plan, write its table, and return the result.

    ``out`` is the directory in which it is kept; without one nothing stays. ``run`` is where it
    runs (None: here). Raises EventregError for a bad plan, or a directory that holds another one.
    """
    scratch = None if out else tempfile.TemporaryDirectory(prefix=scratch_prefix())
    store = Store(out or Path(scratch.name) / 'sweep', plan)  # type: ignore[union-attr]
    if out is not None:
        check_table(store.table)
    with store.alone():
        found = store.result if out is not None else None
        if found is None:
            _run_missing(store, run or run_here, progress)
            found = {**_counts(store), 'seconds': store.seconds}
            if out is not None:
                write_table(store.table, batches(plan.design, store))
                store.finish(found)

    def read(names: Sequence[str] | None) -> dict[str, Array]:
        if scratch is None:
            return read_table(store.table, names)
        return joined(map(known, batches(plan.design, store)), names)

    return Sweep(plan, **found, out=out, _read=read)


def _run_missing(store: Store, run: Run, progress: Progress) -> None:
    """Run what is missing and keep it."""
    count = store.plan.design.count
    missing = store.missing(count)
    done = count - sum(last - first for first, last in missing)
    progress(done, count)
    began = time.perf_counter()
    for stretch, outcomes in run(store.plan, missing):
        now = time.perf_counter()
        store.save(stretch, outcomes, now - began)
        began = now
        done += stretch.last - stretch.first
        progress(done, count)


def _counts(store: Store) -> dict[str, int]:
    total = np.zeros(len(VERDICTS), dtype=np.int64)
    for _, outcomes in store.outcomes():
        total += np.bincount(outcomes.rows['verdict'], minlength=len(VERDICTS))
    names = ('bad', *(word.replace(' ', '_') for word in VERDICTS[1:]))
    return {'sets': int(total.sum()), **dict(zip(names, total.tolist(), strict=True))}


def cores() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, 'sched_getaffinity'):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Pool(ThreadPoolExecutor):
    """Threads that nobody waits for once something was raised, Ctrl-C say, not for compiling."""

    def __exit__(self, kind: type[BaseException] | None, *more: object) -> None:
        self.shutdown(wait=kind is None, cancel_futures=kind is not None)


def pool_here() -> ThreadPoolExecutor:
    """Return threads for all processors of this machine; compiled runs go on side by side."""
    return _Pool(cores())


def first_piece(sets: Sets) -> int:
    """Return how many sets are run together at the start."""
    return FIRST if sets.in_lanes else cores()


def next_piece(size: int, pace: float) -> int:
    """Return how many sets are run together after ``size`` of them, at ``pace`` sets a second."""
    return int(min(max(1, AIM * pace), 4 * size, MOST))


def run_here(plan: Plan, stretches: Sequence[Stretch]) -> Iterator[tuple[Stretch, Outcomes]]:
    """Run stretches on all processors of this machine, in pieces of about :data:`AIM` seconds."""
    if not stretches:
        return
    sets, design = Sets(plan), plan.design
    size = first_piece(sets)
    with pool_here() as pool:
        for first, last in stretches:
            at = first
            while at < last:
                piece = Stretch(at, min(at + size, last))
                began = time.perf_counter()
                yield piece, sets.run(design.columns(*piece), pool)
                pace = (piece.last - piece.first) / max(time.perf_counter() - began, 1e-3)
                size = next_piece(size, pace)
                at = piece.last
