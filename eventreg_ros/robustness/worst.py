# SPDX-License-Identifier: Apache-2.0
"""The falsifier: a search, within ranges, for the parameters that come nearest to an event."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from .axes import Array
from .evaluations import Evaluations
from .outcome import VERDICTS, Rows
from .plan import Plan
from .store import Store
from .sweep import Progress, pool_here

POPULATION = 64
"""Sets that are tried at a time, at most."""

BAD = 1e6
"""What the search takes a wrong event to weigh beside a residual."""

Numbers = npt.NDArray[np.float64]


class Worst(NamedTuple):
    """The worst set of all that were tried: its values, one per axis, and what came of it.

    ``found`` is whether it is not rejected; ``runs`` how many sets were tried.
    """

    values: list[Any]
    verdict: str
    spurious: int
    missed: int
    residual_max_abs: float
    peak: float
    runs: int

    @property
    def found(self) -> bool:
        """Whether a set was found that is not rejected."""
        return self.verdict == 'not rejected'


OF_BADNESS = ('spurious', 'missed', 'residual_max_abs')
"""The numbers of a row that say how bad a set is."""


def badness(rows: Rows | Mapping[str, Array]) -> Numbers:
    """Return how bad each set is: its wrong events count most, then its residual; -1: no verdict.

    ``rows`` may be the columns of a table as well.
    """
    spurious, missed, size = (
        np.nan_to_num(np.asarray(rows[name], dtype=np.float64), nan=-1.0) for name in OF_BADNESS
    )
    unknown = size < 0.0
    return np.where(unknown, -1.0, (spurious + missed) * BAD + size)


def _population(budget: int) -> int:
    """Return how many sets are tried at a time, such that as few runs as possible are left over."""
    most = min(budget, POPULATION)
    return max(range(most, max(most // 2, 4), -1), key=lambda count: budget // count * count)


def search(
    plan: Plan,
    budget: int,
    progress: Progress = lambda done, count: None,
    store: Store | None = None,
) -> Worst:
    """Search within the ranges of a plan with ``budget`` runs, by scipy's differential evolution.

    ``plan.seed`` is of the search; ``store`` keeps what is run. Raises EventregError where nothing
    is varied or no set can run.
    """
    from scipy.optimize import differential_evolution

    axes = plan.axes
    if not axes:
        raise EventregError('--worst searches ranges, and none is given; add -p NODE.PARAM:=A..B')
    sets = Evaluations(plan, store, lambda done: progress(done, budget))
    count = _population(budget)
    rng = np.random.default_rng(plan.seed)
    best: list[Any] = [-np.inf, None, None, 0]
    with pool_here() as pool:

        def objective(u: Numbers) -> Numbers:
            columns = [axis.at(u[i]) for i, axis in enumerate(axes)]
            rows = sets.run(columns, pool)
            bad = badness(rows)
            at = int(np.argmax(bad))
            if bad[at] > best[0]:
                best[:3] = bad[at], [column[at] for column in columns], rows[at]
            best[3] += len(bad)
            return -bad

        differential_evolution(
            objective,
            [(0.0, 1.0)] * len(axes),
            init=np.clip(rng.random((count, len(axes))), 0.0, 1.0 - 1e-12),
            maxiter=budget // count - 1,
            tol=0.0, atol=-1.0, polish=False, vectorized=True, updating='deferred', seed=rng,
        )  # fmt: skip
    _, values, row, runs = best
    if row is None or row['verdict'] == 0:
        raise EventregError('no set within the ranges can be run; narrow them')
    verdict = VERDICTS[int(row['verdict'])]
    numbers = int(row['spurious']), int(row['missed'])
    sizes = float(row['residual_max_abs']), float(row['peak'])
    return Worst(values, verdict, *numbers, *sizes, runs)
