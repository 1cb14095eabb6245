# SPDX-License-Identifier: Apache-2.0
"""Charts as HTML: SVG that is as wide as there is room, and that the page's script can zoom.

Curves stand in an svg element whose box is stretched, in :data:`.chart_scale.ACROSS` parts of the
span; all else stands at a percentage of the width. What the script moves carries ``data-a`` (and
``data-b``), parts of the span. Everything that comes from outside is escaped here.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from ..analysis.signal import Span
from . import axis
from .chart import Chart, Mark, Panel, Raster
from .chart_curves import ROW, draw_lines, draw_rows
from .chart_scale import ACROSS, FINE, GLYPHS, glyph, part, short

TICKS = 6
"""Ticks of the time axis, at most; the script makes more where there is room."""

TOOLS = (
    ('in', 'Zoom in'), ('out', 'Zoom out'), ('back', 'Earlier'), ('on', 'Later'), ('all', 'All'),
)  # fmt: skip


def chart(chart: Chart, caption: str = '') -> str:
    """Return a chart as a figure with its caption, plain text."""
    start, stop = chart.span
    span = f'{start:.10g} {stop:.10g}'
    tools = ''.join(f'<button type="button" data-do="{do}">{words}</button>' for do, words in TOOLS)
    keys = ''.join(_chart_keys(chart))
    return (
        f'<figure class="chart" data-span="{span}">\n'
        f'<div class="tools" hidden>{tools}<output></output></div>\n'
        + (f'<div class="keys">{keys}</div>\n' if keys else '')
        + f'<div class="view" tabindex="0" role="group" aria-label="{escape(chart.title)}">\n'
        + '\n'.join(_panel(chart, panel, i == 0) for i, panel in enumerate(chart.panels))
        + f'\n<div class="plot"><svg class="scale" height="34" aria-hidden="true"></svg>'
        f'<svg class="time" height="34" aria-hidden="true"><g class="ticks">{_time(chart.span)}</g>'
        '<text x="50%" y="31" text-anchor="middle">t (model time)</text></svg></div>\n</div>\n'
        + (f'<figcaption>{escape(caption)}</figcaption>\n' if caption else '')
        + '</figure>'
    )


def _panel(chart: Chart, panel: Panel | Raster, first: bool) -> str:
    if isinstance(panel, Raster):
        height, keys = ROW * len(panel.rows), _title(panel.title)
        drawn = draw_rows(panel.rows, chart.span)
    else:
        height, keys = panel.height, ''.join(_panel_keys(panel))
        drawn = draw_lines(panel, chart.span)
    data = (
        f'<svg class="data" width="100%" height="100%" viewBox="0 0 {ACROSS} {height * FINE}" '
        f'preserveAspectRatio="none">{drawn.curves}</svg>'
    )
    grid = f'<g class="grid">{_grid(chart.span)}</g>'
    marks = ''.join(_marks(chart, height, first))
    return (
        '<div class="panel">'
        + (f'<div class="keys">{keys}</div>\n' if keys else '')
        + f'<div class="plot"><svg class="scale" height="{height}" aria-hidden="true">'
        f'{drawn.scale}</svg>'
        f'<svg class="area" height="{height}" aria-hidden="true">'
        f'{_shades(chart)}{grid}{marks}{data}{drawn.above}</svg></div></div>'
    )


# What lies over the whole height -----------------------------------------------------------------


def _shades(chart: Chart) -> str:
    spans = [(s, 'uncounted') for s in chart.uncounted] + [(s, 'unseen') for s in chart.unseen]
    return ''.join(_rect(span, kind, chart.span) for span, kind in spans)


def _rect(shaded: Span, kind: str, span: Span) -> str:
    a, b = (part(t, span) for t in shaded)
    fill = ' fill="url(#hatch)"' if kind == 'unseen' else ''
    return (
        f'<rect class="{kind}"{fill} x="{a:.4%}" width="{b - a:.4%}" height="100%" '
        f'data-a="{a:.6f}" data-b="{b:.6f}"/>'
    )


def _marks(chart: Chart, height: int, first: bool) -> Iterator[str]:
    for i, mark in enumerate(chart.marks, 1):
        number = f'<text class="number" x="4" y="11">{i}</text>' if first else ''
        yield glyph('change', f'M0 0V{height}', part(mark.at, chart.span), 0.0, number)
    if chart.at is not None:
        yield glyph('instant', f'M0 0V{height}', part(chart.at, chart.span), 0.0)


def _grid(span: Span) -> str:
    places = (f'{part(t, span):.4%}' for t, _ in axis.ticks(*_wide(span), TICKS))
    return ''.join(f'<line x1="{x}" x2="{x}" y2="100%"/>' for x in places)


def _time(span: Span) -> str:
    return ''.join(
        f'<text x="{part(t, span):.4%}" y="15" text-anchor="middle">{words}</text>'
        for t, words in axis.ticks(*_wide(span), TICKS)
    )


def _wide(span: Span) -> Span:
    return span if span[1] > span[0] else (span[0], span[0] + 1.0)


# Keys --------------------------------------------------------------------------------------------


def _title(title: str) -> str:
    return f'<b>{escape(short(title, 40))}</b>' if title else ''


def _panel_keys(panel: Panel) -> Iterator[str]:
    yield _title(panel.title)
    for line in () if panel.title else panel.lines:
        yield _key(f'<path class="line {line.look}" d="M1 6h24"/>', short(line.name, 40))
    if panel.level is not None:
        yield _key('<path class="level" d="M1 6h24"/>', panel.level_name)


def _chart_keys(chart: Chart) -> Iterator[str]:
    for look, words in chart.keys:
        yield _key(f'<path class="line {look}" d="M1 6h24"/>', words)
    if chart.uncounted:
        yield _key('<rect class="uncounted" width="26" height="12"/>', 'not counted')
    if chart.unseen:
        swatch = '<rect class="unseen" fill="url(#hatch)" width="26" height="12"/>'
        yield _key(swatch, 'unseen')
    kinds = dict.fromkeys(
        kind
        for panel in chart.panels
        if isinstance(panel, Raster)
        for row in panel.rows
        for kind, times in row.faults
        if len(times)
    )
    for kind in kinds:
        glyph = f'<path class="{kind}" d="{GLYPHS[kind]}" transform="translate(13 6)"/>'
        yield _key(glyph, kind)
    for i, mark in enumerate(chart.marks, 1):
        yield _key('<path class="change" d="M13 0V12"/>', _numbered(i, mark))
    if chart.at is not None:
        yield _key('<path class="instant" d="M13 0V12"/>', 'the event')


def _numbered(i: int, mark: Mark) -> str:
    return f'{i}: {mark.words}, t = {mark.at:.1f}'


def _key(swatch: str, words: str) -> str:
    return (
        f'<span class="key"><svg width="26" height="12" aria-hidden="true">{swatch}</svg>'
        f'{escape(words)}</span>'
    )
