# SPDX-License-Identifier: Apache-2.0
"""A border over two parameters as the library returns it: on the grid, followed, and drawn."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..printed import Printed
from ..robustness import border as module
from ..robustness.border import Curve
from ..robustness.border_orbit import LIMIT, follow
from ..robustness.followed import Followed, orbit_curves
from ..robustness.plan import Plan
from ..robustness.store import Store
from ..robustness.sweep import Progress

if TYPE_CHECKING:
    from ..plots.run_plot import Figure


@dataclass(frozen=True, repr=False)
class Border(Printed):
    """The border between rejected and not: ``on_grid``, and ``followed`` as a periodic orbit.

    See :class:`.robustness.border.Border` and :class:`.robustness.followed.Followed`.
    """

    plan: Plan
    on_grid: module.Border
    followed: Followed

    def __repr__(self) -> str:
        return f'<Border of {self.plan.name} over {" and ".join(self.names)}>'

    def __str__(self) -> str:
        from ..robustness.sweep_words import border_words

        return border_words(self.plan, self.on_grid, self.followed)

    @property
    def names(self) -> tuple[str, str]:
        """The two parameters, x first."""
        return self.on_grid.names

    @property
    def curves(self) -> list[Curve]:
        """The pieces of the grid's border, shape (n, 2) each: x and y."""
        return self.on_grid.curves

    @property
    def orbit(self) -> list[Curve]:
        """The pieces of the followed border, shape (n, 2) each; none where it is not followed."""
        return orbit_curves(self.on_grid, self.followed)

    def as_json(self) -> dict[str, Any]:
        """Return what --json writes."""
        orbit = [curve.tolist() for curve in self.orbit]
        return {
            'border': list(self.names),
            'runs': self.on_grid.runs,
            'grid': self.on_grid.grid,
            'undecided': self.on_grid.undecided,
            'bad': self.on_grid.bad,
            'curves': [curve.tolist() for curve in self.curves],
            'orbit': {**self.followed.summary, 'curves': orbit},
        }

    def plot(self) -> Figure:
        """Return a matplotlib figure, which a notebook shows; ``savefig('border.pdf')`` writes it.

        The grid's border is drawn where there is something that the followed one leaves out.
        """
        import numpy as np

        from ..plots.sweep_map import draw_border, in_equal_ratios

        found, curves = self.on_grid, self.curves if self.followed.missed else []
        logs = in_equal_ratios(np.sort(found.x)), in_equal_ratios(np.sort(found.y))
        return draw_border(  # type: ignore[no-any-return]
            self.names, curves, found.points, self.plan.name, self.orbit, logs
        )


def border_of(
    plan: Plan,
    names: Sequence[str],
    progress: Progress = lambda done, count: None,
    store: Store | None = None,
) -> Border:
    """Find the border over the two axes ``names`` of a plan, x first, and follow it.

    That takes some seconds, or as long as finding it; ``store`` keeps what is run to find it.
    Raises EventregError when the plan has other axes.
    """
    began = time.process_time()
    found = module.find_border(plan, names, progress, store)
    limit = max(LIMIT, time.process_time() - began)
    return Border(plan, found, follow(plan, found, limit))
