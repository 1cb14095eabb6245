# SPDX-License-Identifier: Apache-2.0
"""The page on several runs: verdicts side by side, what differs, all signals over each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from ..analysis.comparison import Comparison, Pair
from ..analysis.comparison_words import listed, value_in_words
from . import html as page
from .axis import around
from .chart import Chart, Key, Line, Panel, Raster, Row
from .chart_html import chart
from .chart_scale import short
from .comparison_plot import LONGEST, Shown, panels
from .report_words import number

LOOKS = 4
"""Classes of the page's style for runs: run0 to run3."""


def render_comparison(comparison: Comparison, runs: Sequence[Shown]) -> str:
    """Return the page; ``runs`` are those of the comparison, in its order."""
    title = ', '.join(comparison.runs)
    body = [
        '<h1>Runs side by side</h1>',
        page.paragraph(
            f'{title}. Events at most {comparison.window:g} apart are the same.', 'muted'
        ),
        page.hint(),
        _verdicts(comparison),
        _signals(comparison, runs),
        _pairs(comparison),
        _occurrences(comparison),
        _parameters(comparison),
        _definitions(comparison),
    ]
    return page.page(f'Comparison: {title}', [part for part in body if part])


def _verdicts(comparison: Comparison) -> str:
    counts = [dict(zip(s.runs, s.counts, strict=True)) for s in comparison.signals]
    rows = [
        (name, verdict or '-', *(count.get(name, '-') for count in counts))
        for name, verdict in zip(comparison.runs, comparison.verdicts, strict=True)
    ]
    head = ('run', 'verdict', *(f'events of {s.signal}' for s in comparison.signals))
    return page.section('Verdicts', page.table(head, rows))


def _signals(comparison: Comparison, runs: Sequence[Shown]) -> str:
    hidden = [s.signal for s in comparison.signals if s.signal not in panels(runs)]
    caption = 'Below: a row per run, a tick per event of y.' + (
        f' Not drawn: {", ".join(hidden)}.' if hidden else ''
    )
    return page.section('Signals', chart(comparison_chart(runs), caption))


def comparison_chart(runs: Sequence[Shown]) -> Chart:
    """Return every signal of all runs over each other, and the events of y, a row per run."""
    looks = {run.name: f'run{i % LOOKS}' for i, run in enumerate(runs)}
    keys = [
        Key(looks[run.name], f'{i}: {short(run.name, LONGEST)}') for i, run in enumerate(runs, 1)
    ]
    shown: list[Panel | Raster] = []
    for signal in panels(runs):
        there = [run for run in runs if signal in run.signals]
        lines = [Line(signal, looks[run.name], *run.signals[signal]) for run in there]
        shown.append(Panel(lines, around([line.x for line in lines]), title=signal))
    rows = [Row(f'{i}', looks[run.name], run.events.get('y', ())) for i, run in enumerate(runs, 1)]
    shown.append(Raster(rows, 'events of y'))
    ends = [float(t[-1]) for run in runs for t, _ in run.signals.values() if len(t)]
    end = max(ends, default=1.0) or 1.0
    return Chart('Signals of all runs over model time', (0.0, end), shown, keys=keys)


def _pairs(comparison: Comparison) -> str:
    rows = [_pair(signal.signal, pair) for signal in comparison.signals for pair in signal.pairs]
    head = ('signal', 'one', 'other', 'in both', 'only in one', 'only in the other',
            'Victor-Purpura', 'van Rossum', 'SPIKE', 'ISI')  # fmt: skip
    return page.section('Events and distances', page.table(head, rows)) if rows else ''


def _pair(signal: str, pair: Pair) -> tuple[object, ...]:
    d = pair.distances
    sizes = (d.victor_purpura, d.van_rossum, d.spike, d.isi) if d is not None else (None,) * 4
    only = (
        f'{len(times)}: {listed(times)}' if times else '0'
        for times in (pair.only_one, pair.only_other)
    )
    return (signal, pair.one, pair.other, pair.matched, *only, *map(number, sizes))


def _occurrences(comparison: Comparison) -> str:
    if len(comparison.runs) < 3:
        return ''
    rows = chain.from_iterable(
        (
            (s.signal, f'{o.time:.2f}', f'{o.spread:.2g}', f'{len(o.runs)} of {len(s.runs)}')
            for o in s.occurrences
        )
        for s in comparison.signals
    )
    head = ('signal', 't', 'spread', 'runs')
    return page.section('How often each event occurs', page.table(head, rows, 'long'))


def _parameters(comparison: Comparison) -> str:
    if not comparison.parameters:
        return page.section('Parameters', page.paragraph('No difference is known.'))
    rows = [(row.parameter, *map(value_in_words, row.values)) for row in comparison.parameters]
    table = page.table(('parameter', *comparison.runs), rows, 'wide words')
    return page.section('What differs in the parameters', table)


def _definitions(comparison: Comparison) -> str:
    window = f'{comparison.window:g}'
    entries = [
        (
            'in both, only in one',
            f'events of two runs are matched one to one, at most {window} of model time apart; '
            'those without a partner count where both runs have been.',
        ),
        (
            'Victor-Purpura',
            'the least cost of turning one train into the other: 1 to add or remove an event, 1 to '
            f'move it by {window} (Victor and Purpura 1996).',
        ),
        (
            'van Rossum',
            f'the distance of the trains as decaying exponentials with time constant {window}; an '
            'event more makes 1 (van Rossum 2001).',
        ),
        (
            'SPIKE, ISI',
            'from 0, equal, to 1: how far the nearest event of the other train is, relative to the '
            'intervals (Kreuz et al. 2013), and how much the intervals differ (Kreuz et al. 2007).',
        ),
    ]
    return page.section('How the numbers are defined', page.definitions(entries))
