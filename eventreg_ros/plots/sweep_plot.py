# SPDX-License-Identifier: Apache-2.0
"""Draws what a sweep gives: a map or a line of a grid, histograms of random sets."""

from __future__ import annotations

from typing import Any

from ..robustness.sweep import Sweep
from ..robustness.yields import yield_of
from .sweep_map import draw_sweep
from .yield_plot import draw_yield


def draw_result(sweep: Sweep) -> Any:
    """Return a matplotlib figure of a sweep. Raises EventregError for a grid that has no picture.

    That is one of more than two parameters, or of words.
    """
    plan = sweep.plan
    if plan.sets:
        return draw_yield(sweep.columns, yield_of(sweep.rejected, sweep.sets), plan.name)
    return draw_sweep(sweep.columns, [axis.name for axis in plan.axes], plan.name)
