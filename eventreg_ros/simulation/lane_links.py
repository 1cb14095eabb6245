# SPDX-License-Identifier: Apache-2.0
"""What the links of lanes have received at each step, in the tables that a kernel in lanes reads.

Loss and jitter make a table for each law (how much of them, which seed); a delay only shifts it. So
lanes that differ in their delays alone share a table, and where nothing is random one entry will
do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .impairment import PERFECT, Impairment, Index, Received, draws
from .jit import compile_entry
from .lanes_source import LANES
from .trajectory import Array

Table = npt.NDArray[np.int32]


class Links(NamedTuple):
    """What all links have received at each step, as the kernel reads it; all tables are flat.

    Common to all lanes, ``newest`` and ``previous`` have shape (links, steps): sample numbers, -1
    for none. Scattered, they have shape (laws, links, span) and hold, if nothing is delayed, how
    many steps ago the newest sample was sent, and how many steps before that one the one used
    before; ``span`` is all steps, or 1 where nothing is random. ``tables`` (blocks, LANES) says
    where that of a lane begins, ``lags`` (blocks, links * LANES) how many steps later all comes.
    ``reach`` is how many steps back the oldest sample lies that is still needed.
    """

    newest: Index | Table
    previous: Index | Table
    reach: int
    tables: Index | None = None
    lags: Index | None = None
    span: int = 1

    @classmethod
    def perfect(cls) -> Links:
        """Return the links of lanes in which every sample arrives at once."""
        nothing = np.empty(0, dtype=np.int64)
        return cls(nothing, nothing, 0)

    @classmethod
    def common(cls, have: Received) -> Links:
        """Return the links of lanes that have all received the same samples."""
        return cls(have.newest.ravel(), have.previous.ravel(), _reach(have))

    @classmethod
    def scattered(
        cls, signals: Sequence[str], steps: int, h: float, each: Sequence[Impairment]
    ) -> Links:
        """Return links with an impairment for each lane; further lanes do as the last."""
        each = [*each, *[each[-1]] * (-len(each) % LANES)]
        laws = {law: i for i, law in enumerate(dict.fromkeys(map(law_of, each)))}
        of = np.array([laws[law_of(impairment)] for impairment in each])
        lags = np.array([_lags(impairment, signals, steps, h) for impairment in each], np.int64)
        ages, gaps, back = _tables(list(laws), signals, steps, h)
        reach = np.where(lags < steps, lags + back[of], 0).max(initial=0)
        blocks, links = len(each) // LANES, len(signals)
        by_block = lags.reshape(blocks, LANES, links).swapaxes(1, 2)
        by_block = np.ascontiguousarray(by_block).reshape(blocks, links * LANES)
        tables = (of * ages[0].size).reshape(-1, LANES)
        return cls(ages.ravel(), gaps.ravel(), int(reach), tables, by_block, ages.shape[2])


def _reach(have: Received) -> int:
    back = 0
    for newest, previous in zip(have.newest, have.previous, strict=True):
        none, one = np.count_nonzero(newest < 0), np.count_nonzero(previous < 0)
        n = np.arange(len(newest))
        for oldest in (n[none:one] - newest[none:one], n[one:] - previous[one:]):
            back = max(back, int(oldest.max(initial=0)))
    return back


@lru_cache(maxsize=4096)
def law_of(impairment: Impairment) -> Impairment:
    """Return what remains of an impairment without its delay; a seed only where it is of use."""
    return replace(impairment, delay=0.0) if impairment.random else PERFECT


@lru_cache(maxsize=4096)
def _lags(impairment: Impairment, signals: Sequence[str], steps: int, h: float) -> list[int]:
    return [impairment.law(signal, steps, h).delay for signal in signals]


def _tables(
    laws: Sequence[Impairment], signals: Sequence[str], steps: int, h: float
) -> tuple[Table, Table, Index]:
    """Return ages and gaps as in :class:`Links`, and how far back each law and link reaches."""
    span = steps if any(law.random for law in laws) else 1
    ages = np.zeros((len(laws), len(signals), span), dtype=np.int32)
    gaps, back = np.ones_like(ages), np.ones(ages.shape[:2], dtype=np.int64)
    last, second = np.empty((2, span + 1), dtype=np.int32)
    for i, impairment in enumerate(laws):
        for link, signal in enumerate(signals):
            law = impairment.law(signal, steps, h)
            if law.random:
                lost, late = (
                    draws(impairment.seed, link, of, span if used else 0)
                    for of, used in ((0, law.loss > 0.0), (1, law.jitter > 0.0))
                )
                back[i, link] = _compiled()(
                    lost, late, law.loss, law.jitter, ages[i, link], gaps[i, link], last, second
                )
    return ages, gaps, back


@lru_cache(maxsize=1)
def _compiled() -> Any:
    return compile_entry(arrive)


def arrive(
    lost: Array, late: Array, loss: float, jitter: float,
    ages: Table, gaps: Table, last: Table, second: Table,
) -> int:  # fmt: skip
    """Fill ``ages`` and ``gaps`` of one link, as in :class:`Links`; return how far back it reaches.

    By the rules of :func:`.impairment.received`, without delay. ``lost`` and ``late`` are its
    random numbers, empty where there is no loss or no jitter (in steps). ``last`` and ``second``
    are room for the last two samples that arrive at each step, and after all, shape (steps + 1,).
    The other arrays have shape (steps,).
    """
    steps = len(ages)
    for s in range(steps):
        gone = int(lost[s] < loss) if loss > 0.0 else 0
        last[s], second[s] = (s | -gone) if jitter == 0.0 else -1, -1
    for s in range(steps if jitter > 0.0 else 0):
        at = min(s + int(np.floor(jitter * late[s])), steps)
        at = steps if loss > 0.0 and lost[s] < loss else at
        second[at], last[at] = last[at], s
    newest = previous = -1
    reach = 0
    for n in range(steps):  # without branches: nobody foresees a loss
        fresh = -int(last[n] > newest)
        previous += (max(newest, second[n]) - previous) & fresh
        newest += (last[n] - newest) & fresh
        ages[n], gaps[n] = n - newest, newest - previous
        oldest = previous if previous >= 0 else newest
        reach = max(reach, (n - oldest) & -int(oldest >= 0))
    return reach
