# SPDX-License-Identifier: Apache-2.0
"""Draws what a sweep gives: maps or a line of a grid, histograms of random sets."""

from __future__ import annotations

from typing import Any

from ..errors import EventregError
from ..robustness.plan import Plan
from ..robustness.sweep import Sweep
from ..robustness.yields import yield_of_sweep
from .sweep_map import draw_sweep
from .yield_plot import PANELS, draw_yield


def need_picture(plan: Plan) -> None:
    """Raise EventregError for a grid that has no picture: of more than two parameters."""
    if not plan.sets:
        shown(plan)


def shown(plan: Plan) -> list[str]:
    """Return the parameters over which a grid is drawn. Raises EventregError for more than two."""
    names = [axis.name for axis in plan.axes]
    varied = [axis.name for axis in plan.axes if len(axis.values) > 1]
    if not 1 <= len(varied or names) <= 2:
        raise EventregError(
            f'a picture shows one or two parameters, got {", ".join(varied) or "none"}; leave out '
            f'--plot and --report, or give the others one value each'
        )
    return varied or names[:1]


def draw_result(sweep: Sweep) -> Any:
    """Return a matplotlib figure of a sweep. Raises EventregError for a grid that has no picture.

    That is one of more than two parameters that take several values.
    """
    plan = sweep.plan
    if plan.sets:
        columns = sweep.only(['verdict', *(panel[0] for panel in PANELS)])
        return draw_yield(columns, yield_of_sweep(sweep), plan.name)
    names = shown(plan)
    columns = sweep.only([*names, 'verdict', 'spurious', 'missed', 'residual_max_abs'])
    return draw_sweep(columns, names, plan.name)
