# SPDX-License-Identifier: Apache-2.0
"""Draws the verdict over delay and loss, one panel for each hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .style import BLACK, BLUE, ORANGE, style

if TYPE_CHECKING:
    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

SIZE = (6.4, 2.9)
"""Inches."""

PALE = '#DDEAF3'
KEYS = (
    (ORANGE, 'with none'),
    (PALE, 'with some'),
    (BLUE, 'rejected with every seed'),
)
"""The colours of a cell, in this order; they also differ in lightness."""


def draw_map(
    delays: Array, losses: Array, rejected: Mapping[str, Array], title: str, time_scale: float
) -> Any:
    """Return a matplotlib figure of the verdict over delay (model time) and loss (probability).

    ``delays`` has shape (m,), ``losses`` (n,), both evenly spaced; ``rejected`` maps each hold to
    the part of the seeds (0 to 1) that are rejected, shape (n, m). ``time_scale`` is in model time
    units per second; it gives the axis in milliseconds. A line surrounds what is always rejected.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=SIZE)
        figure.set_layout_engine('none')
        axes = figure.subplots(
            1, len(rejected), sharey=True, squeeze=False,
            gridspec_kw={'left': 0.08, 'right': 0.985, 'bottom': 0.15, 'top': 0.72, 'wspace': 0.08},
        )[0]  # fmt: skip
        for axis, (hold, share) in zip(axes, rejected.items(), strict=True):
            _panel(axis, _edges(delays), _edges(losses), share)
            axis.set_xlabel('delay of every link, model time')
            axis.set_title(f'hold: {hold}', loc='left', pad=24.0)
            _milliseconds(axis, time_scale)
        axes[0].set_ylabel('loss, probability')
        figure.suptitle(title, x=0.01, y=0.985, ha='left', va='top', fontsize=7.0)
        _key(figure)
    return figure


def _edges(values: Array) -> Sequence[float]:
    """Return the edges of cells that have the evenly spaced ``values`` in their middle."""
    half = 0.5 * float(values[1] - values[0])
    return [*(values - half).tolist(), float(values[-1]) + half]


def _panel(axis: Any, x: Sequence[float], y: Sequence[float], share: Array) -> None:
    from matplotlib.colors import ListedColormap

    kind = (share > 0.0).astype(int) + (share == 1.0)
    colours = ListedColormap([colour for colour, _ in KEYS])
    axis.pcolormesh(
        x, y, kind, cmap=colours, vmin=0, vmax=2, edgecolors='white', linewidth=0.2, clip_on=False
    )  # there is nothing to clip, and an eighth of a file is what clips
    for a, b in _border(x, y, kind == 2):
        axis.plot(a, b, color=BLACK, linewidth=1.2, solid_capstyle='projecting')
    axis.set_xlim(x[0], x[-1])
    axis.set_ylim(y[0], y[-1])


def _border(x: Sequence[float], y: Sequence[float], inside: Any) -> list[tuple[Any, Any]]:
    """Return the edges between cells that are ``inside`` and their neighbours that are not."""
    across = [
        ((x[j + 1], x[j + 1]), (y[i], y[i + 1])) for i, j in np.argwhere(np.diff(inside, axis=1))
    ]
    return across + [
        ((x[j], x[j + 1]), (y[i + 1], y[i + 1])) for i, j in np.argwhere(np.diff(inside, axis=0))
    ]


def _milliseconds(axis: Any, time_scale: float) -> None:
    factor = 1000.0 / time_scale
    top = axis.secondary_xaxis('top', functions=(lambda t: t * factor, lambda ms: ms / factor))
    top.set_xlabel(f'ms at time_scale {time_scale:g}', fontsize=7.0, labelpad=2.0)
    top.tick_params(length=2.0, pad=1.0)


def _key(figure: Any) -> None:
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=c, edgecolor='none', label=words) for c, words in KEYS[::-1]]
    figure.legend(
        handles=handles, loc='upper right', bbox_to_anchor=(0.99, 0.945), ncols=len(handles),
        borderaxespad=0.0, borderpad=0.0, columnspacing=1.2, handlelength=1.2, handletextpad=0.4,
    )  # fmt: skip
