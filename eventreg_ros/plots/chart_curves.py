# SPDX-License-Identifier: Apache-2.0
"""The curves of a chart, and the marks that belong to them, as SVG."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.signal import Span
from .chart import Events, Line, Panel, Row
from .chart_scale import ACROSS, FINE, GLYPHS, glyph, part, short, within
from .decimate import Array, broken, min_max_decimate

ROW = 22
"""Height of a row of events, in pixels."""

TICKS = 5
"""Ticks of a scale, at most."""

MOST_EVENTS = 4000
"""Events of one signal that are drawn one by one; of more, one in each such part of the span."""

MOST_GLYPHS = 300
"""Faults, or places off the scale, that are marked one by one."""


class Drawn(NamedTuple):
    """What a panel consists of: its scale, its curves, and what stands above them."""

    scale: str
    curves: str
    above: str


# Panels of lines ---------------------------------------------------------------------------------


def draw_lines(panel: Panel, span: Span) -> Drawn:
    """Return a panel of lines."""
    height = panel.height
    rungs = [
        (height * (1.0 - float(panel.axis.place(np.float64(value)))), words)
        for value, words in panel.axis.ticks(TICKS)
    ]
    scale = ''.join(
        f'<text x="100%" dx="-6" y="{y + 4:.1f}" text-anchor="end">{words}</text>'
        for y, words in rungs
    )
    lines = ''.join(f'<path class="rung" d="M0 {y * FINE:.0f}h{ACROSS}"/>' for y, _ in rungs)
    if panel.level is not None:
        y = height * (1.0 - float(panel.axis.place(np.float64(panel.level))))
        lines += f'<path class="level" d="M0 {y * FINE:.0f}h{ACROSS}"/>'
    lines += ''.join(_line(line, panel, span) for line in panel.lines)
    lines += ''.join(_circles(events, panel, span) for events in panel.events)
    return Drawn(scale, lines, ''.join(_off_scale(panel, span)))


def _line(line: Line, panel: Panel, span: Span) -> str:
    t, x = within(line.t, line.x, span)
    x_units, y_units = _units(*min_max_decimate(*broken(t, x)), panel, span)
    found = f'<path class="line {line.look}" d="{_path(x_units, y_units)}"/>'
    if line.points:
        dots = zip(*(a[np.isfinite(y_units)].astype(int) for a in (x_units, y_units)), strict=True)
        path = ''.join(f'M{a} {b}h0' for a, b in dots)
        usual = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        count = (span[1] - span[0]) / usual if usual > 0.0 else len(t)
        found += f'<path class="points {line.look}" data-count="{count:.0f}" d="{path}"/>'
    return found


def _units(t: Array, x: Array, panel: Panel, span: Span) -> tuple[Array, Array]:
    """Return points in whole units of the curves; NaN stays, and what is far off comes close."""
    whole = panel.height * FINE
    y = (1.0 - panel.axis.place(x)) * whole
    across = (t - span[0]) * (ACROSS / ((span[1] - span[0]) or 1.0))
    return np.rint(across), np.rint(np.clip(y, -whole, 2.0 * whole))


def _path(x: Array, y: Array) -> str:
    """Return the path through points, broken where y is NaN."""
    known = np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return ''.join(_run(x[a:b].astype(np.int64), y[a:b].astype(np.int64)) for a, b in runs)


def _run(x: npt.NDArray[np.int64], y: npt.NDArray[np.int64]) -> str:
    """Return the path through points without gaps; those amid a level stretch are left out."""
    needed = np.ones(len(x), dtype=bool)
    needed[1:-1] = (y[1:-1] != y[:-2]) | (y[1:-1] != y[2:])
    x, y = x[needed], y[needed]
    steps = zip(np.diff(x).tolist(), np.diff(y).tolist(), strict=True)
    rest = ' '.join(f'{dx} {dy}' for dx, dy in steps if dx or dy)
    return f'M{x[0]} {y[0]}' + (f'l{rest}' if rest else 'h0')


def _circles(events: Events, panel: Panel, span: Span) -> str:
    y = panel.height * FINE * (1.0 - float(panel.axis.place(np.float64(events.level))))
    dots = ''.join(f'M{a} {y:.0f}h0' for a in _places(events.times, span))
    return f'<path class="ring {events.look}" d="{dots}"/><path class="hole" d="{dots}"/>'


def _places(times: Iterable[float], span: Span) -> list[int]:
    """Return where events are, in units of the curves; not more than can be told apart."""
    t = np.asarray(list(times), dtype=np.float64)
    t = t[(t >= span[0]) & (t <= span[1])]
    parts = (t - span[0]) / ((span[1] - span[0]) or 1.0)
    if len(t) > MOST_EVENTS:
        parts = np.unique(np.floor(parts * MOST_EVENTS)) / MOST_EVENTS
    places: list[int] = np.rint(parts * ACROSS).astype(int).tolist()
    return places


def _off_scale(panel: Panel, span: Span) -> Iterator[str]:
    """Yield a mark at the edge wherever a line leaves the panel."""
    for line in panel.lines:
        t, x = within(line.t, line.x, span)
        place = panel.axis.place(x)
        ways = [('above', place > 1.0, 0.0)]
        ways += [] if panel.axis.logarithmic else [('below', place < 0.0, float(panel.height))]
        for kind, off, y in ways:
            parts = np.unique(np.round((t[off] - span[0]) / ((span[1] - span[0]) or 1.0), 3))
            for a in parts[(parts >= 0.0) & (parts <= 1.0)][:MOST_GLYPHS].tolist():
                yield glyph(f'{kind} {line.look}', GLYPHS[kind], a, y)


# Rows of events ----------------------------------------------------------------------------------


def draw_rows(rows: Sequence[Row], span: Span) -> Drawn:
    """Return rows of events."""
    scale, curves, above = '', '', ''
    for i, row in enumerate(rows):
        top = ROW * i
        name = escape(short(row.name, 7))
        scale += f'<text x="100%" dx="-6" y="{top + 15}" text-anchor="end">{name}</text>'
        from_top, length = (top + 4) * FINE, (ROW - 8) * FINE
        ticks = ''.join(f'M{a} {from_top}v{length}' for a in _places(row.times, span))
        curves += f'<path class="tick {row.look}" d="{ticks}"/>'
        for kind, times in row.faults:
            for t in [t for t in times if span[0] <= t <= span[1]][:MOST_GLYPHS]:
                above += glyph(kind, GLYPHS[kind], part(t, span), top + ROW / 2)
    return Drawn(scale, curves, above)
