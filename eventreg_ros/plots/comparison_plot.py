# SPDX-License-Identifier: Apache-2.0
"""Several runs over each other: every signal in one panel, and the events of y a row per run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..analysis.signal import Signals, with_events
from .decimate import broken, min_max_decimate
from .style import SERIES, TIME, Look, mark_events, style

MOST = 5
"""Panels in one picture."""

LONGEST = 24
"""Characters of a run's name that are drawn."""

WIDTH, PANEL, ROW, LABEL, REST = 3.4, 1.0, 0.16, 0.7, 0.75
"""Inches: a paper's column, a panel, a row of events, the least that their label needs, and key,
labels and axis together."""


@dataclass(frozen=True)
class Shown:
    """One run as it is drawn: its name, its signals and its events, all in model time.

    ``signals`` maps each name to (t, values), both of shape (n,); ``events`` to the event times.
    """

    name: str
    signals: Signals
    events: Mapping[str, Sequence[float]]


def draw_comparison(runs: Sequence[Shown]) -> Any:
    """Return a matplotlib figure of the runs, for a column of a paper."""
    from matplotlib.figure import Figure

    heights = _heights(runs)
    with style(**{'text.parse_math': False}):
        figure = Figure(figsize=(WIDTH, sum(heights) + REST))
        axes = figure.subplots(
            len(heights), 1, sharex=True, squeeze=False, height_ratios=heights
        )[:, 0]  # fmt: skip
        _fill(list(axes), runs)
        axes[-1].set_xlabel(TIME, parse_math=True)
        figure.legend(handles=_key(runs), loc='outside upper left', ncols=2)
    return figure


def panels(runs: Sequence[Shown]) -> list[str]:
    """Return the signals that are drawn: those with samples, the paper's first."""
    names = {name for run in runs for name, (t, _) in run.signals.items() if len(t)}
    return with_events(names)[:MOST]


def _heights(runs: Sequence[Shown]) -> list[float]:
    return [PANEL] * len(panels(runs)) + [max(0.15 + ROW * len(runs), LABEL)]


def _short(name: str) -> str:
    return name if len(name) <= LONGEST else f'{name[: LONGEST - 3]}...'


def _key(runs: Sequence[Shown]) -> list[Any]:
    """Return what a legend shows: the number of each run, which its row has too, and its name."""
    from matplotlib.lines import Line2D

    looks = [_look(i) for i in range(len(runs))]
    return [
        Line2D([], [], color=s.colour, linestyle=s.line, linewidth=s.width,
               label=f'{i + 1}: {_short(run.name)}')
        for i, (run, s) in enumerate(zip(runs, looks, strict=True))
    ]  # fmt: skip


def _look(i: int) -> Look:
    return SERIES[i % len(SERIES)]


def _fill(axes: Sequence[Any], runs: Sequence[Shown]) -> None:
    """Draw each signal in one panel, the first run below the others, and the events at the end."""
    for ax, name in zip(axes, panels(runs), strict=False):
        for i, run in enumerate(runs):
            if name in run.signals:
                shown = _look(i)
                ax.plot(*min_max_decimate(*broken(*run.signals[name])), color=shown.colour,
                        linestyle=shown.line, linewidth=shown.width)  # fmt: skip
        ax.set_ylabel(_short(name))
    rows = [(f'{i + 1}', _look(i), run.events.get('y', ())) for i, run in enumerate(runs)]
    mark_events(axes[-1], rows)
    axes[-1].set_ylabel('events of y')
    ends = [t[-1] for run in runs for t, _ in run.signals.values() if len(t)]
    axes[-1].set_xlim(0.0, max(ends, default=1.0) or 1.0)
