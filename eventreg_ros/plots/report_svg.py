"""The report's pictures, as SVG that takes its colours from the page it stands in."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import numpy as np

from ..analysis.signal import Signals, total, with_events
from ..analysis.subject import JudgedPlant
from ..analysis.verdict import Report, residual, synchronisation
from ..models.roles import SIGNALS
from .decimate import Array, broken, min_max_decimate
from .style import BLACK, DOTTED, GREY, LOOKS, ORANGE, VERMILLION, look, shade_settle, style
from .style import mark_events as raster

MOST = 8
"""Panels of signals in one picture; a foreign bag may hold any number of them."""

WIDTH, TOP, FOOT, BETWEEN = 9.2, 0.12, 0.42, 0.14
"""Inches: a picture's width, its margins above and below the panels, and the space between."""

FLOOR = 1e-16
"""Lower end of logarithmic axes; what is smaller is rounding."""

TIME = 't (model time)'
PAPER, GRID = '#fefefe', '#dfe3e8'

VARIABLES = {
    BLACK: '--ink',
    GREY: '--grey',
    ORANGE: '--other',
    PAPER: '--paper',
    GRID: '--grid',
    **{shown.colour: f'--{name}' for name, shown in LOOKS.items() if name != 'y'},
}
"""The page's name for each colour: there it has a light and a dark value."""

SPURIOUS, MISSED = 'X', 'v'
"""Markers of the events that should not be: those of y alone, and those of y_r alone."""

SETTINGS = {
    'figure.constrained_layout.use': False,
    'axes.grid': True,
    'grid.color': GRID,
    'grid.linewidth': 0.5,
    'lines.linewidth': 1.1,
    'svg.fonttype': 'none',  # the page's font; text that can be searched
    'text.parse_math': False,  # names come from the bag, not from us
}


def signals_svg(signals: Signals, report: Report) -> str:
    """Draw every signal over model time, the reference over y, with circles at the events."""
    threshold = report.subject.criteria.threshold
    beside = {
        p.plant.output: p.plant.reference
        for p in report.plants
        if p.plant.reference is not None and len(signals.get(p.plant.reference, ((),))[0])
    }
    names = [n for n in panels(signals) if n not in beside.values()]
    outputs = [p.plant.output for p in report.plants]
    heights = [1.5 if name in outputs else 1.1 for name in names]

    def draw(axes: list[Any]) -> None:
        for ax, name in zip(axes, names, strict=True):
            reference = beside.get(name)
            for each in (name,) if reference is None else (name, reference):
                _draw(ax, each, *signals[each])
                _circle(ax, each, report.signals[each].events, threshold)
            ax.axhline(threshold, color=GREY, linewidth=0.8, linestyle=DOTTED, zorder=1)
            _frame(ax, name if reference is None else f'{name} and {reference}', report)

    return svg(draw, heights, 'Signals over model time, with their events')


def raster_svg(signals: Signals, report: Report) -> str:
    """Draw the events of all signals as rows of ticks; mark those of y and y_r that are wrong."""
    names = panels(signals)

    def draw(axes: list[Any]) -> None:
        ax = axes[0]
        raster(ax, [(_short(n), look(n), report.signals[n].events) for n in names])
        for marker, name, times in _faults(report):
            if times and name in names:
                above = np.full(len(times), 0.46 - names.index(name))
                ax.plot(times, above, marker, markersize=6.5, color=VERMILLION, clip_on=False,
                        markeredgewidth=0.0)  # fmt: skip
        _frame(ax, '', report)
        ax.grid(axis='y', visible=False)

    return svg(draw, [0.15 + 0.3 * len(names)], 'Events of every signal, one row each')


def _faults(report: Report) -> list[tuple[str, str | None, list[float]]]:
    """Return the marker of each kind of event that should not be, its signal, and the times."""
    return [
        fault
        for each in report.plants
        for fault in (
            (SPURIOUS, each.plant.output, each.outcomes.spurious),
            (MISSED, each.plant.reference, each.outcomes.missed),
        )
    ]


def residual_svg(signals: Signals, report: Report, plant: JudgedPlant) -> str:
    """Draw |y - y_r| (|y| without a reference) over model time, on a logarithmic axis."""
    threshold, compared = report.subject.criteria.threshold, plant.output
    if plant.reference is not None and len(signals.get(plant.reference, ((),))[0]):
        compared = f'{plant.output} - {plant.reference}'
    name = f'|{compared}|'

    def draw(axes: list[Any]) -> None:
        _magnitude(axes[0], *residual(signals, plant))
        axes[0].axhline(abs(threshold) or 1.0, color=GREY, linewidth=0.8, linestyle=DOTTED)
        _frame(axes[0], name, report)

    return svg(draw, [1.6], f'The residual, {name}, over model time')


def synchronisation_svg(signals: Signals, report: Report, plant: JudgedPlant) -> str | None:
    """Draw u on top of w, sums where there are several, and |w - u|; None when one is missing."""
    t, difference = synchronisation(signals, plant)
    if len(t) == 0:
        return None
    w, u = ' + '.join(plant.disturbances), ' + '.join(plant.controls)
    both = f'{w} - {u}' if len(plant.controls) == 1 else f'{w} - ({u})'

    def draw(axes: list[Any]) -> None:
        above, below = (total(signals, names) for names in (plant.disturbances, plant.controls))
        _draw(axes[0], 'w', *above, label=_short(w), linewidth=3.5, alpha=0.5)
        _draw(axes[0], 'u', *below, label=_short(u), linewidth=1.0, linestyle='-')
        axes[0].legend(loc='lower right', ncols=2, borderaxespad=0.0, bbox_to_anchor=(1.0, 1.0))
        _magnitude(axes[1], t, difference)
        _frame(axes[0], f'{w} and {u}', report)
        _frame(axes[1], f'|{both}|', report)

    return svg(draw, [1.4, 1.2], 'Disturbance w and control action u, and their difference', 0.3)


def learned_svg(signals: Signals, report: Report) -> str:
    """Draw 1/tau of every controller that learned it, and that of the generator it came to."""

    def draw(axes: list[Any]) -> None:
        for ax, each in zip(axes, report.learned, strict=True):
            t, x = signals[each.signal]
            if each.value is not None:
                ax.axhline(1.0 / each.value, color=GREY, linewidth=0.8, linestyle=DOTTED)
            _draw(ax, 'u', t, 1.0 / x, linestyle='-')
            _frame(ax, f'1 / {each.signal}', report)

    return svg(draw, [1.1] * len(report.learned), 'What the controllers learned over model time')


def panels(signals: Signals) -> list[str]:
    """Return the names of the signals that are drawn: with samples, the paper's first."""
    names = [name for name in with_events(signals) if len(signals[name][0])]
    return names[: max(MOST, sum(name in SIGNALS for name in names))]


def _draw(ax: Any, signal: str, t: Array, x: Array, **more: Any) -> None:
    shown = look(signal)
    ax.plot(
        *min_max_decimate(*broken(t, x)), **{'color': shown.colour, 'linestyle': shown.line, **more}
    )


def _magnitude(ax: Any, t: Array, x: Array) -> None:
    """Draw |x| on a logarithmic axis; where x changes its sign, the line leaves it below."""
    size = np.maximum(np.abs(x), FLOOR)
    _draw(ax, 'y', t, size)
    ax.set_yscale('log')
    ax.minorticks_off()
    ax.yaxis.set_major_formatter(lambda value, _: f'{value:g}')
    if len(size):
        low, high = np.percentile(size, 3.0), size.max()
        ax.set_ylim(low / 3.0, max(3.0 * high, 10.0 * low))


def _circle(ax: Any, signal: str, events: Sequence[float], level: float) -> None:
    ax.plot(events, np.full(len(events), level), 'o', markersize=4.0, markerfacecolor=PAPER,
            markeredgecolor=look(signal).colour, zorder=3)  # fmt: skip


def _frame(ax: Any, label: str, report: Report) -> None:
    """Name the axis, show the whole run, and shade the settling time."""
    ax.set_ylabel(_short(label))
    ax.yaxis.set_label_coords(-0.06, 0.5)
    ax.set_xlim(0.0, report.duration or 1.0)
    shade_settle(ax, min(report.settle, report.duration))


def _short(name: str) -> str:
    return name if len(name) <= 16 else f'{name[:7]}...{name[-7:]}'


def svg(
    draw: Callable[[list[Any]], None], heights: Sequence[float], title: str, top: float = TOP
) -> str:
    """Return an svg element that fits its container: ``draw`` fills panels of these heights."""
    from matplotlib.figure import Figure

    space = BETWEEN * (len(heights) - 1)
    whole = top + sum(heights) + space + FOOT
    margins = {'left': 0.08, 'right': 0.985, 'top': 1.0 - top / whole, 'bottom': FOOT / whole}
    buffer = io.StringIO()
    with style(**SETTINGS):
        figure = Figure(figsize=(WIDTH, whole))
        axes = figure.subplots(
            len(heights), 1, sharex=True, squeeze=False,
            gridspec_kw={**margins, 'height_ratios': heights,
                         'hspace': BETWEEN * len(heights) / sum(heights)},
        )[:, 0]  # fmt: skip
        draw(list(axes))
        axes[-1].set_xlabel(TIME)
        figure.savefig(buffer, format='svg', transparent=True, metadata={'Date': None})
    return _themed(buffer.getvalue(), title)


def _themed(document: str, title: str) -> str:
    """Return the svg element of a document of matplotlib's, colours named, groups anonymous."""
    svg = document[document.index('<svg') :].strip()
    svg = re.sub(r'<metadata>.*?</metadata>', '', svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*">', '<g>', svg)
    width, height = 72.0 * WIDTH, float(re.findall(r'viewBox="0 0 \S+ (\S+)"', svg)[0])
    head = f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{escape(title)}">'
    svg = head + svg[svg.index('>') + 1 :]
    for colour, variable in VARIABLES.items():
        svg = re.sub(f': {colour}', f': var({variable})', svg, flags=re.IGNORECASE)
    return svg
