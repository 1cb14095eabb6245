# SPDX-License-Identifier: Apache-2.0
"""Stretches of a sweep on a Dask cluster: this cuts, Dask schedules, and does again what was lost.

The same rows as here, bit for bit: a piece depends on the plan and its place alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from ..errors import EventregError
from .outcome import Outcomes
from .plan import Plan
from .sets import Sets
from .store import Stretch
from .sweep import AIM, MOST, Run, cores, first_piece

AHEAD = 3
"""Pieces per thread that are handed to the scheduler at a time."""


PATIENCE = 10.0
"""Seconds within which a scheduler must answer."""


class Done(NamedTuple):
    """A piece that is done, and how many seconds its worker took."""

    stretch: Stretch
    outcomes: Outcomes
    seconds: float


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
        return Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise EventregError(
            f'no Dask scheduler answers at {scheduler}: {error}; check --scheduler'
        ) from None


def _all(client: Any, plan: Plan, stretches: Sequence[Stretch]) -> Iterator[Done]:
    """Yield all pieces as they are done; only a few are on their way at a time."""
    from distributed import as_completed

    size, pieces = first_piece(Sets(plan)), _Pieces(stretches)
    pending = as_completed()
    for _ in range(AHEAD * max(sum(client.nthreads().values()), 1)):
        _submit(client, pending, plan, pieces.next(size))
    for future in pending:
        done = Done(*future.result())
        pace = (done.stretch.last - done.stretch.first) / max(done.seconds, 1e-3)
        size = int(min(max(1, AIM * pace), 4 * size, MOST))
        _submit(client, pending, plan, pieces.next(size))
        yield done


def _submit(client: Any, pending: Any, plan: Plan, piece: Stretch | None) -> None:
    if piece is not None:
        pending.add(client.submit(run_piece, plan, tuple(piece), pure=False))


class _Pieces:
    """Cuts stretches into pieces."""

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        self._left = list(stretches)

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
    began = time.perf_counter()
    outcomes = _sets(plan).run(plan.design.columns(*stretch))
    return Done(Stretch(*stretch), outcomes, time.perf_counter() - began)


@lru_cache(maxsize=4)
def _sets(plan: Plan) -> Sets:
    return Sets(plan)
