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
from .table import batches, check_table, read_table, write_table

if TYPE_CHECKING:
    import pandas

Progress = Callable[[int, int], None]
"""Takes how many sets are done, and how many there are."""

AIM = 2.0
"""Seconds of work after which what is done is kept."""

FIRST, MOST = 64, 1 << 16
"""Sets that are run together at the start, and at most."""

Run = Callable[[Plan, Sequence[Stretch]], Iterator[tuple[Stretch, Outcomes]]]
"""Runs stretches of a plan's sets, in any order and any pieces."""


@dataclass(frozen=True, repr=False)
class Sweep(Printed):
    """What came of a sweep. Counts are of sets; ``bad`` ones were refused or diverged.

    ``seconds`` is how long it took the last time; ``out`` the directory, None if nothing was kept.
    """

    plan: Plan
    sets: int
    rejected: int
    not_rejected: int
    undecided: int
    bad: int
    seconds: float
    out: Path | None
    _read: Callable[[], dict[str, Array]]

    def __repr__(self) -> str:
        return (
            f'<Sweep of {self.plan.name}: {self.sets} sets, {self.rejected} rejected, '
            f'{self.not_rejected} not, {self.undecided} undecided>'
        )

    def __str__(self) -> str:
        from .sweep_words import sweep_words

        return sweep_words(self, None, ())

    @cached_property
    def columns(self) -> dict[str, Array]:
        """The table, shape (sets,) each: a column per parameter, then verdict and numbers."""
        return self._read()

    def __getitem__(self, column: str) -> Array:
        """Return one column of the table. Raises KeyError."""
        return self.columns[column]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table as a pandas DataFrame, a row a set. Raises EventregError without it."""
        need('pandas', 'to_dataframe()')
        import pandas

        return pandas.DataFrame(self.columns)

    def as_json(self) -> dict[str, Any]:
        """Return what --json writes."""
        named = dict(text.partition(':=')[::2] for text in self.plan.parameters)
        varied = {axis.name: named[axis.name] for axis in self.plan.axes}
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
        if (before := store.result) is not None:
            return Sweep(plan, **before, out=out, _read=lambda: read_table(store.table))
    seconds = _run_missing(store, run or run_here, progress)
    counts = _counts(store)
    if out is not None:
        write_table(store.table, batches(plan.design, store))
        store.finish({**counts, 'seconds': seconds})
        return Sweep(
            plan, **counts, seconds=seconds, out=out, _read=lambda: read_table(store.table)
        )

    def read() -> dict[str, Array]:
        assert scratch  # kept as long as this function is
        rows = list(batches(plan.design, store))
        return {name: np.concatenate([part[name] for part in rows]) for name in rows[0]}

    return Sweep(plan, **counts, seconds=seconds, out=None, _read=read)


def _run_missing(store: Store, run: Run, progress: Progress) -> float:
    """Run what is missing and keep it; return how many seconds that took."""
    began = time.perf_counter()
    count = store.plan.design.count
    missing = store.missing(count)
    done = count - sum(last - first for first, last in missing)
    progress(done, count)
    for stretch, outcomes in run(store.plan, missing):
        store.save(stretch, outcomes)
        done += stretch.last - stretch.first
        progress(done, count)
    return time.perf_counter() - began


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


def pool_here() -> ThreadPoolExecutor:
    """Return threads for all processors of this machine; compiled runs go on side by side."""
    return ThreadPoolExecutor(cores())


def run_here(plan: Plan, stretches: Sequence[Stretch]) -> Iterator[tuple[Stretch, Outcomes]]:
    """Run stretches on all processors of this machine, in pieces of about :data:`AIM` seconds."""
    if not stretches:
        return
    sets, design, size = Sets(plan), plan.design, FIRST
    with pool_here() as pool:
        for first, last in stretches:
            at = first
            while at < last:
                piece = Stretch(at, min(at + size, last))
                began = time.perf_counter()
                yield piece, sets.run(design.columns(*piece), pool)
                pace = (piece.last - piece.first) / max(time.perf_counter() - began, 1e-3)
                size = int(min(max(1, AIM * pace), 4 * size, MOST))
                at = piece.last
