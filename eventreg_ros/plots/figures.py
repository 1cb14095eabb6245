# SPDX-License-Identifier: Apache-2.0
"""Draws a figure of a paper: panels of signals over model time, and below them their events.

What a figure shows is a :class:`Layout`, a table; :func:`draw` turns it and the data into a
picture. The data are named columns on one grid of model time, the same that a file of them holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..analysis.events import detect
from ..scenario.criteria import RESET, THRESHOLD
from .style import (
    LABELS,
    LOOKS,
    PURPLE,
    SERIES,
    TIME,
    Look,
    mark_events,
    mark_threshold,
    shade_settle,
    style,
)

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

WIDTH = 3.4
"""Inches: one column of a paper."""

PANEL, ROW, LINE, FOOT = 0.95, 0.15, 0.14, 0.4
"""Heights in inches: a panel, a row of events, a line of notes, the axis of time."""

FLOOR = 1e-12
"""Smaller values are drawn as this in logarithmic panels: they are below the integrator's error."""


CROWD = 250
"""Marks in a row of a raster at most; more would be on top of each other."""

ROUND = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 50.0, 100.0)
"""Ticks of a logarithmic horizontal axis."""


@dataclass(frozen=True)
class Curve:
    """One line of a panel, or one row of events: a column of the data, its label, its look."""

    column: str
    label: str
    look: Look


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    ``label`` is that of the vertical axis, ``title`` stands above; ``log`` draws absolute values on
    a logarithmic axis; ``limits`` are those of the vertical axis; ``threshold`` draws the threshold
    of the events; ``pulses`` names a column (v) during whose positive phases the panel is shaded.
    """

    label: str
    curves: tuple[Curve, ...]
    title: str = ''
    log: bool = False
    limits: tuple[float, float] | None = None
    threshold: bool = False
    pulses: str = ''


@dataclass(frozen=True)
class Layout:
    """A figure: its panels from top to bottom, and the columns whose events are marked below.

    Before ``settle`` (model time) the panels are shaded. ``along`` is the label of the horizontal
    axis, which is logarithmic with ``log``. With a ``raster``, which is what they are called, all
    samples that are not 0 are marked instead of events.
    """

    panels: tuple[Panel, ...]
    events: tuple[Curve, ...] = ()
    settle: float = 0.0
    along: str = TIME
    log: bool = False
    raster: str = ''


def curves(*signals: str) -> tuple[Curve, ...]:
    """Return curves for signals of the paper, each with its label and look."""
    return tuple(Curve(signal, LABELS[signal], LOOKS[signal]) for signal in signals)


def series(columns: Sequence[str], labels: Sequence[str] = ()) -> tuple[Curve, ...]:
    """Return curves for several runs of one signal, distinguished by colour and line."""
    given = labels or [''] * len(columns)
    return tuple(map(Curve, columns, given, SERIES))


def draw(
    layout: Layout,
    t: Array,
    data: Mapping[str, Array],
    *,
    notes: Sequence[str] = (),
    threshold: float = THRESHOLD,
    reset: float = RESET,
) -> Any:
    """Return a matplotlib figure of ``data``, columns of shape (n,) at the model times ``t``.

    ``notes`` are lines of text above the panels; ``threshold`` and ``reset`` define the events.
    Raises KeyError when a column of ``layout`` is missing.
    """
    with style():
        figure, axes = _frame(layout, notes)
        axes[0].set_xlim(float(t[0]), float(t[-1]))
        if layout.log:
            _in_ratios(axes[-1], t)
        for axis, panel in zip(axes, layout.panels, strict=False):
            _panel(axis, panel, t, data)
            if panel.threshold:
                mark_threshold(axis, threshold)
        if layout.events:
            mark_events(axes[-1], _found(layout, t, data, threshold, reset))
            axes[-1].set_ylabel(layout.raster or 'events')
        for axis in axes if layout.settle else ():
            shade_settle(axis, layout.settle)
        explained: set[str] = set()
        for axis in axes[: len(layout.panels)]:
            _legend(axis, explained)
        axes[-1].set_xlabel(layout.along)
        figure.align_ylabels(axes)
        _lay_out(figure)
    return figure


def _in_ratios(axis: Any, x: Array) -> None:
    """Make the shared horizontal axis logarithmic, with plain numbers on it."""
    axis.set_xscale('log')
    axis.minorticks_off()
    ticks = [tick for tick in ROUND if x[0] <= tick <= x[-1]]
    if len(ticks) < 2:
        decades = [digit * 10.0**power for power in range(-9, 9) for digit in (1, 3)]
        ticks = [tick for tick in decades if x[0] * (1 - 1e-9) <= tick <= x[-1] * (1 + 1e-9)]
    axis.set_xticks(ticks, [f'{tick:g}' for tick in ticks])


def _lay_out(figure: Any) -> None:
    """Lay the figure out for good, the same in every format and, by rounding, in every run.

    The layout's solver leaves differences in the last bit, which svg files would show.
    """
    figure.draw_without_rendering()
    figure.set_layout_engine('none')
    for axis in figure.axes:
        axis.set_position([round(edge, 4) for edge in axis.get_position().bounds])


def _found(
    layout: Layout, t: Array, data: Mapping[str, Array], threshold: float, reset: float
) -> list[tuple[str, Look, list[float]]]:
    """Return the marks of each row, as :func:`.plots.mark_events` takes them."""
    return [
        (
            row.label,
            row.look,
            _apart(t[data[row.column] != 0.0], float(t[-1] - t[0]) / CROWD)
            if layout.raster
            else detect(t, data[row.column], threshold, reset),
        )
        for row in layout.events
    ]


def _apart(times: Array, least: float) -> list[float]:
    """Return those of ``times`` that are at least so far from the one before."""
    kept: list[float] = []
    for time in times.tolist():
        if not kept or time - kept[-1] >= least - 1e-9:
            kept.append(time)
    return kept


def _frame(layout: Layout, notes: Sequence[str]) -> tuple[Any, list[Any]]:
    """Return an empty figure and its axes: the panels', then the events' if there are any."""
    from matplotlib.figure import Figure

    heights = [PANEL] * len(layout.panels)
    if layout.events:
        heights.append(ROW * len(layout.events))
    figure = Figure(figsize=(WIDTH, sum(heights) + LINE * len(notes) + FOOT))
    if notes:
        figure.suptitle('\n'.join(notes), x=0.02, ha='left', fontsize=7.0)
    axes = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, gridspec_kw={'height_ratios': heights}
    )
    return figure, list(axes[:, 0])


def _panel(axis: Any, panel: Panel, t: Array, data: Mapping[str, Array]) -> None:
    for curve in panel.curves:
        shown = data[curve.column]
        axis.plot(
            t,
            abs(shown).clip(FLOOR) if panel.log else shown,
            color=curve.look.colour,
            linestyle=curve.look.line,
            linewidth=curve.look.width,
            label=curve.label,
        )
    axis.set_ylabel(panel.label)
    axis.set_title(panel.title, loc='left', fontsize=7.0, pad=2.5)
    if panel.log:
        axis.set_yscale('log')
    if panel.limits:
        axis.set_ylim(panel.limits)
    if panel.pulses:
        _shade_pulses(axis, t, data[panel.pulses])


def _shade_pulses(axis: Any, t: Array, v: Array) -> None:
    label = LABELS['v']
    high = [False, *(v > 0.0).tolist(), False]
    edges = [i for i in range(len(v) + 1) if high[i] != high[i + 1]]
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        last = float(t[min(end, len(t) - 1)])
        axis.axvspan(float(t[start]), last, color=PURPLE, alpha=0.3, lw=0, zorder=0, label=label)
        label = ''


def _legend(axis: Any, explained: set[str]) -> None:
    """Put one line of legend above the panel, at its right; leave out what was ``explained``."""
    found = zip(*axis.get_legend_handles_labels(), strict=True)
    shown = {label: handle for handle, label in found if label not in explained}
    explained.update(shown)
    if shown:
        axis.legend(
            shown.values(), shown.keys(), loc='lower right', bbox_to_anchor=(1.0, 1.0),
            ncols=len(shown), borderaxespad=0.0, borderpad=0.1, columnspacing=1.0,
            handlelength=2.0, handletextpad=0.4,
        )  # fmt: skip
