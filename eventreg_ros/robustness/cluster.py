# SPDX-License-Identifier: Apache-2.0
"""Stretches of a sweep on a Dask cluster: this cuts, Dask schedules, and does again what was lost.

The same rows as here, bit for bit: a piece depends on the plan and its place alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple

from ..errors import EventregError, described
from .outcome import Outcomes
from .plan import Plan
from .sets import Sets
from .store import Stretch
from .sweep import Run, cores, first_piece, next_piece

AHEAD = 3
"""Pieces per thread that are handed to the scheduler at a time."""


PATIENCE = 10.0
"""Seconds within which a scheduler must answer."""


class Done(NamedTuple):
    """A piece that is done; ``pace``, in sets per second, is None where it was a worker's first.

    Most of the time of that one goes into imports and compiled code.
    """

    stretch: Stretch
    outcomes: Outcomes
    pace: float | None


def runner(engine: str, scheduler: str | None) -> Run | None:
    """Return where ``engine``, ``local`` or ``dask``, runs stretches. Raises EventregError."""
    if engine not in ('local', 'dask'):
        raise EventregError(f"engine must be 'local' or 'dask', got {engine!r}")
    return on_cluster(scheduler) if engine == 'dask' else None


def on_cluster(scheduler: str | None) -> Run:
    """Return what runs stretches on the workers of the Dask scheduler at that address.

    Without an address it starts a worker process for each processor of this machine.
    """

    def run(plan: Plan, stretches: Sequence[Stretch]) -> Iterator[tuple[Stretch, Outcomes]]:
        if not stretches:
            return
        with _client(scheduler) as client:
            for done in _all(client, plan, stretches):
                yield done.stretch, done.outcomes

    return run


def _client(scheduler: str | None) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise EventregError(
            "--engine dask needs distributed; pip install '.[cluster]' in the sources"
        ) from None
    if scheduler is None:
        return Client(n_workers=cores(), threads_per_worker=1, dashboard_address=None)
    try:
        client = Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise EventregError(
            f'no Dask scheduler answers at {scheduler}: {error}; check --scheduler'
        ) from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close()
        raise EventregError(
            f'the Dask scheduler at {scheduler} has no workers; start some: dask worker {scheduler}'
        ) from None
    return client


def _all(client: Any, plan: Plan, stretches: Sequence[Stretch]) -> Iterator[Done]:
    """Yield all pieces as they are done; only a few are on their way at a time."""
    from distributed import as_completed

    size = least = first_piece(Sets(plan))
    pieces = _Pieces(stretches)
    threads = max(sum(client.nthreads().values()), 1)
    pending = as_completed()
    for _ in range(AHEAD * threads):
        _submit(client, pending, plan, pieces.next(size))
    for future in pending:
        done = Done(*_result(future))
        if done.pace is not None:
            size = next_piece(size, done.pace)
        share = -(-pieces.left // (AHEAD * threads))  # so that all end at the same time
        _submit(client, pending, plan, pieces.next(min(size, max(share, least))))
        yield done


def _result(future: Any) -> Any:
    """Return what came of a piece. Raises EventregError where none of its workers could do it."""
    try:
        return future.result()
    except Exception as error:  # a lost scheduler, a worker that dies of it or lacks a package
        words = str(error) if isinstance(error, EventregError) else described(error)
        raise EventregError(
            f'the Dask cluster failed: {words}; every worker needs this very eventreg_ros and the '
            'packages that it uses here; the same command goes on'
        ) from None


def _submit(client: Any, pending: Any, plan: Plan, piece: Stretch | None) -> None:
    if piece is not None:
        pending.add(client.submit(run_piece, plan, tuple(piece), pure=False))


class _Pieces:
    """Cuts stretches into pieces."""

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        self._left = list(stretches)

    @property
    def left(self) -> int:
        """How many sets are not yet in a piece."""
        return sum(last - first for first, last in self._left)

    def next(self, size: int) -> Stretch | None:
        """Return the next piece of at most that size, None after the last."""
        if not self._left:
            return None
        first, last = self._left[0]
        piece = Stretch(first, min(first + size, last))
        if piece.last < last:
            self._left[0] = Stretch(piece.last, last)
        else:
            self._left.pop(0)
        return piece


def run_piece(plan: Plan, stretch: tuple[int, int]) -> Done:
    """Run one piece, on a worker."""
    sets, runs = _sets(plan)
    began = time.perf_counter()
    outcomes = sets.run(plan.design.columns(*stretch))
    pace = (stretch[1] - stretch[0]) / max(time.perf_counter() - began, 1e-3)
    return Done(Stretch(*stretch), outcomes, pace if next(runs) else None)


@lru_cache(maxsize=4)
def _sets(plan: Plan) -> tuple[Sets, Iterator[int]]:
    """Return the sets of a plan, and what counts how often this worker ran some of them."""
    return Sets(plan), count()
