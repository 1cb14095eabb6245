# SPDX-License-Identifier: Apache-2.0
"""Draws the yield of random sets: how large residuals are, and how soon events end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .style import BLUE, ORANGE, style
from .sweep_map import set_log

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..robustness.yields import Yield

    Array = npt.NDArray[Any]

SIZE = (6.4, 2.5)
"""Inches."""

PANELS = (
    ('residual_max_abs', 'largest |y - y_r|', True),
    ('settling', 'last wrong event, model time', False),
    ('latency', 'mean of y - y_r, model time', False),
)
"""Column, label, and whether it is drawn over its logarithm."""


def draw_yield(columns: Mapping[str, Array], share: Yield, title: str) -> Any:
    """Return a matplotlib figure of random sets: a histogram per quantity, by verdict.

    ``columns`` are the table's, shape (n,) each. Quantities that are 0 throughout are left out.
    """
    from matplotlib.figure import Figure

    rejected = np.array([word == 'rejected' for word in columns['verdict']])
    shown = [panel for panel in PANELS if np.nan_to_num(columns[panel[0]]).any()]
    with style():
        figure = Figure(figsize=SIZE, layout='constrained')
        for axis, (name, label, log) in zip(
            np.atleast_1d(figure.subplots(1, max(len(shown), 1), sharey=True)), shown, strict=False
        ):
            _histogram(axis, np.asarray(columns[name], float), rejected, log)
            axis.set_xlabel(label)
        figure.axes[0].set_ylabel('sets')
        if figure.axes[0].get_legend_handles_labels()[0]:
            handles = figure.axes[0].get_legend_handles_labels()
            figure.legend(*handles, loc='outside upper right', ncols=2, handlelength=1.2)
        figure.suptitle(
            f'{title}: {100.0 * share.share:.2f} % of {len(rejected)} sets rejected, 95 % interval '
            f'{100.0 * share.low:.2f} to {100.0 * share.high:.2f} %',
            x=0.01, ha='left', fontsize=8.0,
        )  # fmt: skip
    return figure


def _histogram(axis: Any, values: Array, rejected: Array, log: bool) -> None:
    known = np.isfinite(values) & ((values > 0.0) | (not log))
    if not known.any():
        return
    low, high = values[known].min(), values[known].max()
    edges = np.linspace(low, high if high > low else low + 1.0, 41)
    if log and high > low:
        edges = np.geomspace(low, high, 41)
        set_log(axis, True, np.array([low, high]))
    axis.hist([values[known & chosen] for chosen in (rejected, ~rejected)], edges, stacked=True,
              color=[BLUE, ORANGE], label=['rejected', 'not rejected'])  # fmt: skip
    axis.set_yscale('symlog', linthresh=1.0)
