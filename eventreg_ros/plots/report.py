"""The report on a run: one HTML page, for a person who wants to know what happened."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from html import escape
from typing import Any

from ..analysis.recorded import Analysis
from ..analysis.rejection import outcomes
from ..analysis.verdict import Report, Signals
from . import html as page
from . import report_svg as report_plots
from .report_words import definitions, in_words, number

SYMBOLS = {'rejected': '✓', 'not rejected': '✗', 'undecided': '?'}
MOST_EVENTS = 2000
"""The table of events lists no more of them than this."""


@dataclass(frozen=True)
class ReportPage:
    """What the page is made from: a verdict's report, and what it was judged from.

    ``signals`` maps each name to (t, values), both of shape (n,), t in model time; ``report`` is
    :func:`.verdict.judge`'s of them (with each signal's timing, where it was recorded), given
    ``threshold``, ``reset`` and ``window``. ``parameters`` are those of each node, and ``text`` the
    parameter file, where known. ``start`` is the first sample's time stamp, in nanoseconds since
    1970 if the run had a wall clock.
    """

    source: str
    signals: Signals
    report: Report
    threshold: float
    reset: float
    window: float
    parameters: Mapping[str, Mapping[str, Any]]
    text: str | None = None
    start: int = 0


def report_page(analysis: Analysis, source: str) -> ReportPage:
    """Return what the page on a recorded bag is made from; ``source`` is what the bag is called."""
    threshold, reset = analysis.monitor
    scenario = analysis.scenario
    return ReportPage(
        source=source,
        signals=analysis.signals,
        report=analysis.report,
        threshold=threshold,
        reset=reset,
        window=analysis.window,
        parameters=scenario.given if scenario else {},
        text=scenario.to_yaml() if scenario else None,
        start=analysis.recording.start,
    )


def render(run: ReportPage) -> str:
    """Return the page."""
    report = run.report
    title = f'{report["scenario"]}: {report["verdict"]}'
    body = [
        f'<h1>Event disturbance rejection: {escape(report["scenario"])}</h1>',
        page.paragraph(_origin(run), 'muted'),
        _verdict(report),
        _counts(run),
        _signals(run),
        _raster(run),
        _residual(run),
        _synchronisation(run),
        _events(run),
        _timing(report),
        _parameters(run),
        _definitions(run),
    ]
    return page.page(title, [part for part in body if part])


def _origin(run: ReportPage) -> str:
    report = run.report
    seconds = report['duration'] / report['time_scale']
    words = (
        f'{run.source}: {report["duration"]:.1f} units of model time in {seconds:.1f} s '
        f'({report["time_scale"]:g} units per second)'
    )
    if run.start > 10**18:  # September 2001: older clocks are not the wall's
        start = datetime.fromtimestamp(run.start // 10**9, timezone.utc)
        words += f', from {start:%Y-%m-%d %H:%M:%S} UTC'
    return words + '.'


def _verdict(report: Report) -> str:
    verdict = report['verdict']
    return (
        f'<div class="verdict {verdict.replace(" ", "-")}" role="status">'
        f'<span class="symbol" aria-hidden="true">{SYMBOLS[verdict]}</span>'
        f'<div><b>{verdict.capitalize()}</b>{page.paragraph(in_words(report))}</div></div>'
    )


def _counts(run: ReportPage) -> str:
    report = run.report
    r, residual, synchronisation = (
        report[key] for key in ('rejection', 'residual', 'synchronisation')
    )
    entries = [
        ('disturbance events: w', r['disturbance_events']),
        ('reference events: y_r', r['reference_events']),
        ('preserved: y with y_r', r['preserved']),
        ('spurious: y alone', r['spurious']),
        ('missed: y_r alone', r['missed']),
        ('ratio of rejection', number(r['ratio'])),
        ('residual, largest', number(residual['max_abs'])),
        ('residual, rms', number(residual['rms'])),
        ('|w - u|, largest', number(synchronisation['max_abs'])),
        ('w - u, rms', number(synchronisation['rms'])),
    ]
    return page.section(f'After t = {report["settle"]:g}', page.tiles(entries))


def _signals(run: ReportPage) -> str:
    settle = run.report['settle']
    rows = [
        (
            name,
            s['samples'],
            number(s['min']),
            number(s['max']),
            len(s['events']),
            sum(t >= settle for t in s['events']),
        )
        for name, s in run.report['signals'].items()
    ]
    head = ('signal', 'samples', 'min', 'max', 'events', f'after t = {settle:g}')
    shown = set(report_plots.panels(run.signals))
    hidden = [name for name in run.report['signals'] if name not in shown]
    caption = (
        f'Circles: events. Dotted: the threshold, {run.threshold:g}. Shaded: the settling time, in '
        'which nothing is counted.' + (f' Not drawn: {", ".join(hidden)}.' if hidden else '')
    )
    svg = report_plots.signals_svg(run.signals, run.report, run.threshold)
    return page.section('Signals', page.figure(svg, caption), page.table(head, rows))


def _outcomes(run: ReportPage) -> dict[str, list[float]]:
    signals = run.report['signals']
    y, y_r = (signals.get(name, {}).get('events', []) for name in ('y', 'y_r'))
    return outcomes(y, y_r, run.report['settle'], run.window)


def _raster(run: ReportPage) -> str:
    caption = (
        'One row per signal, one tick per event. A cross marks an event of y that is spurious, a '
        'triangle one of y_r that y missed.'
    )
    svg = report_plots.raster_svg(run.signals, run.report, _outcomes(run))
    return page.section('Events', page.figure(svg, caption))


def _residual(run: ReportPage) -> str:
    size = run.report['residual']
    caption = (
        f'After settling at most {number(size["max_abs"])}, rms {number(size["rms"])}. Dotted: '
        f'the threshold of an event, {run.threshold:g}.'
    )
    svg = report_plots.residual_svg(run.signals, run.report, run.threshold)
    return page.section('Residual', page.figure(svg, caption))


def _synchronisation(run: ReportPage) -> str:
    svg = report_plots.synchronisation_svg(run.signals, run.report)
    if svg is None:
        return ''
    size = run.report['synchronisation']
    caption = (
        'Above: the disturbance w, wide, and on top of it, min_max_decimate, the control action u. '
        f'Below: their distance, after settling at most {number(size["max_abs"])}, '
        f'rms {number(size["rms"])}.'
    )
    return page.section('Does the controller follow the disturbance?', page.figure(svg, caption))


def _events(run: ReportPage) -> str:
    rows = sorted(
        (t, name, kind)
        for name, s in run.report['signals'].items()
        for t, kind in _kinds(run, name, s['events'])
    )
    text = [(f'{t:.4f}', name, kind) for t, name, kind in rows[:MOST_EVENTS]]
    more = len(rows) - len(text)
    note = [page.paragraph(f'and {more} more; --json lists all.', 'muted')] if more else []
    if not rows:
        return page.section('Table of events', page.paragraph('No signal has any event.'))
    return page.section(
        'Table of events', page.table(('t', 'signal', 'counted as'), text, 'long words'), *note
    )


def _kinds(run: ReportPage, name: str, events: list[float]) -> list[tuple[float, str]]:
    """Return (t, what it counts as) for each event of a signal."""
    before = 'before settling: not counted'
    found = _outcomes(run)
    kinds = {'w': 'disturbance', 'y': 'preserved', 'y_r': 'answered'}
    wrong = {'y': ('spurious', found['spurious']), 'y_r': ('missed', found['missed'])}
    word, times = wrong.get(name, ('', []))
    return [
        (t, before if t < run.report['settle'] else word if t in times else kinds.get(name, ''))
        for t in events
    ]


def _timing(report: Report) -> str:
    rows = [
        (
            name,
            f'{t["rate"]:.2f}',
            *(f'{t[part] * 1e3:.3f}' for part in ('period_p50', 'period_p99', 'period_max')),
            t['gaps'],
        )
        for name, t in ((name, s.get('timing')) for name, s in report['signals'].items())
        if t and t['rate'] is not None
    ]
    head = ('signal', 'rate, Hz', 'median, ms', '99 %, ms', 'longest, ms', 'gaps')
    caption = page.paragraph('The time between one sample and the next, by the stamps in the bag.')
    return page.section('Timing', caption, page.table(head, rows)) if rows else ''


def _parameters(run: ReportPage) -> str:
    if not run.parameters:
        words = 'The bag holds no scenario, and none was given: defaults were taken.'
        return page.section('Scenario', page.paragraph(words))
    nodes = list(run.parameters)
    names = dict.fromkeys(name for values in run.parameters.values() for name in values)
    rows = [
        (name, *(_value(run.parameters[node].get(name, '')) for node in nodes)) for name in names
    ]
    parts = [page.table(('', *nodes), rows, 'wide words')]
    if run.text is not None:
        parts.append(page.folded('The parameter file', run.text))
    return page.section('Scenario', *parts)


def _value(value: Any) -> str:
    """Return a parameter as text, numbers to six digits."""
    if isinstance(value, list):
        return ', '.join(map(_value, value))
    return f'{value:g}' if isinstance(value, float) else str(value)


def _definitions(run: ReportPage) -> str:
    entries = definitions(run.report['settle'], run.window, run.threshold, run.reset)
    return page.section('How the numbers are defined', page.definitions(entries))
