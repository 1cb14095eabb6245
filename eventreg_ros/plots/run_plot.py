# SPDX-License-Identifier: Apache-2.0
"""One run as a picture: its signals over model time, and below them their events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from io import BytesIO
from typing import TYPE_CHECKING, Any, NamedTuple

from ..analysis.signal import Signals, family, with_events
from ..analysis.verdict import Report
from ..models.roles import SIGNALS
from .axis import around
from .decimate import broken, min_max_decimate
from .style import (
    DASHDOT,
    DASHED,
    GREY,
    LABELS,
    ORANGE,
    SOLID,
    TIME,
    Look,
    look,
    mark_events,
    mark_threshold,
    shade_settle,
    style,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Figure

WIDTH, COLUMN, PANEL, ROW, REST = 6.8, 3.4, 1.25, 0.17, 0.75
"""Inches: the picture, a paper's column, a panel, a row of events, and all else together."""

MOST_SHADES = 200
"""Stretches of one signal that are shaded, at most."""

KEY = 0.65
"""Inches that an entry of the legend takes."""

DPI = 120
"""Of the picture that a notebook shows."""

BESIDE = {'u': 'w', 'y_r': 'y'}
"""Which signals share a panel."""


class Shade(NamedTuple):
    """A time that is shaded, in model time, and the words above it."""

    start: float
    stop: float
    words: str


def draw_report(signals: Signals, report: Report, width: float = WIDTH) -> Figure:
    """Return the picture of a run that was judged.

    What was not seen is shaded, and what was changed is a vertical line. ``width`` is in
    inches; in a paper's column the caption is the title.
    """
    return draw_run(
        signals,
        {name: signal.events for name, signal in report.signals.items()},
        threshold=report.subject.criteria.threshold,
        settle=report.settle,
        shades=[
            Shade(start, stop, '' if i else f'{name} unseen')
            for name, stretches in report.evidence.unseen.items()
            for i, (start, stop) in enumerate(stretches[:MOST_SHADES])
        ],
        marks=sorted({change.at for change in report.changes}),
        title=f'{report.scenario}: {report.verdict}' if width > COLUMN else '',
        width=width,
    )


def draw_run(
    signals: Signals,
    events: Mapping[str, Sequence[float]],
    *,
    threshold: float,
    settle: float = 0.0,
    shades: Sequence[Shade] = (),
    marks: Sequence[float] = (),
    title: str = '',
    width: float = WIDTH,
) -> Figure:
    """Return a matplotlib figure that a notebook shows and ``savefig`` writes.

    The panels of the loop's signals share one scale, that of the threshold too: what does not spike
    looks small. Samples that are far off all others are off the scale. Before
    ``settle`` (model time) events do not count, and the picture is shaded. At ``marks`` (model
    time) something was changed.
    """
    names = with_events(name for name, signal in signals.items() if len(signal.t))
    panels = _panels(names)
    heights = [PANEL] * len(panels) + [0.1 + ROW * len(names)]
    with style():
        figure: Figure = _picture()(figsize=(width, sum(heights) + REST))
        axes = figure.subplots(
            len(heights), 1, sharex=True, squeeze=False, height_ratios=heights
        )[:, 0]  # fmt: skip
        for ax, shown in zip(axes, panels, strict=False):
            _draw_panel(ax, shown, signals, threshold)
        _scale(list(axes), panels, signals, threshold)
        mark_events(axes[-1], [(_label(n), _look(n), events.get(n, ())) for n in names])
        for ax in axes:
            for t in marks:
                ax.axvline(t, color=GREY, linewidth=0.8, linestyle=DASHDOT, label='change')
        _finish(figure, list(axes), signals, settle, shades)
        if title:
            figure.suptitle(title, x=0.01, ha='left')
    return figure


def _panels(names: Sequence[str]) -> list[list[str]]:
    """Return the signals of each panel: w with u, y with y_r, others by themselves."""
    panels: dict[str, list[str]] = {}
    for name in names:
        panels.setdefault(BESIDE.get(family(name), family(name)), []).append(name)
    return list(panels.values())


def _label(name: str) -> str:
    return LABELS.get(name, name)


def _look(name: str) -> Look:
    """Return the look of a signal; w_2 has that of w, dashed where w is not."""
    shown = look(family(name))
    if name == family(name) or shown.colour == ORANGE:
        return shown
    return Look(shown.colour, DASHED if shown.line == SOLID else SOLID, 0.7 * shown.width)


def _draw_panel(ax: Any, names: Sequence[str], signals: Signals, threshold: float) -> None:
    for name in names:
        shown = _look(name)
        ax.plot(
            *min_max_decimate(*broken(*signals[name])), color=shown.colour, linestyle=shown.line,
            linewidth=shown.width, label=_label(name),
        )  # fmt: skip
    ax.set_ylabel(', '.join(map(_label, names)))
    mark_threshold(ax, threshold)


def _scale(
    axes: Sequence[Any], panels: Sequence[list[str]], signals: Signals, threshold: float
) -> None:
    """Give the panels of the loop's signals one scale, and others their own."""
    ours = [family(names[0]) in SIGNALS for names in panels]
    loop = [n for names, own in zip(panels, ours, strict=True) if own for n in names]
    one = around((signals[name].x for name in loop), (threshold,))
    for ax, names, own in zip(axes, panels, ours, strict=False):
        axis = one if own else around(signals[name].x for name in names)
        ax.set_ylim(axis.low, axis.high)


def _finish(
    figure: Figure, axes: list[Any], signals: Signals, settle: float, shades: Sequence[Shade]
) -> None:
    """Set shades and the legend, which stands above the panels and covers nothing."""
    ends = [float(signal.t[-1]) for signal in signals.values() if len(signal.t)]
    axes[-1].set_xlim(0.0, max(ends, default=1.0) or 1.0)
    for ax in axes:
        if settle > 0.0:
            shade_settle(ax, settle)
        for shade in shades:
            ax.axvspan(shade.start, shade.stop, color=GREY, alpha=0.35, linewidth=0, zorder=0)
    for shade in shades:
        middle = 0.5 * (shade.start + shade.stop)
        axes[0].annotate(shade.words, (middle, 1.0), (0, 2), xycoords=('data', 'axes fraction'),
                         textcoords='offset points', ha='center', va='bottom')  # fmt: skip
    axes[-1].set_xlabel(TIME)
    keys = {label: handle for ax in axes[:-1]
            for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}  # fmt: skip
    labels = sorted(keys, key=('threshold', 'change', 'settling').__contains__)  # after the signals
    columns = min(len(labels), max(int(figure.get_figwidth() / KEY), 1))
    figure.legend(
        [keys[label] for label in labels], labels, loc='outside upper right', ncols=columns,
        handlelength=1.6, columnspacing=1.2,
    )  # fmt: skip


@cache
def _picture() -> type:
    """Return matplotlib's Figure with what notebooks ask for, without pyplot and its state."""
    from matplotlib.figure import Figure

    class Picture(Figure):
        def _repr_png_(self) -> bytes:
            data = BytesIO()
            with style():
                self.savefig(data, format='png', dpi=DPI)
            return data.getvalue()

    return Picture
