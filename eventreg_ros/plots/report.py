"""The report on a run: one HTML page, for a person who wants to know what happened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from html import escape
from typing import Any

from ..analysis.learning import words as learned_words
from ..analysis.recorded import Analysis
from ..analysis.signal import Signals, with_events
from ..analysis.verdict import PlantReport, Report
from ..scenario import Criteria
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
    :func:`.verdict.judge`'s of them. ``parameters`` are those of each node, and ``text`` the
    parameter file, where known. ``start`` is the first sample's time stamp, in nanoseconds since
    1970 if the run had a wall clock.
    """

    source: str
    signals: Signals
    report: Report
    parameters: Mapping[str, Mapping[str, Any]]
    text: str | None = None
    start: int = 0

    @property
    def criteria(self) -> Criteria:
        """The numbers that the verdict rests on."""
        return self.report.subject.criteria


def report_page(analysis: Analysis, source: str) -> ReportPage:
    """Return what the page on a recorded bag is made from; ``source`` is what the bag is called."""
    scenario = analysis.scenario
    return ReportPage(
        source=source,
        signals=analysis.signals,
        report=analysis.report,
        parameters=scenario.given if scenario else {},
        text=scenario.to_yaml() if scenario else None,
        start=analysis.recording.start,
    )


def render(run: ReportPage) -> str:
    """Return the page."""
    report = run.report
    title = f'{report.scenario}: {report.verdict}'
    body = [
        f'<h1>Event disturbance rejection: {escape(report.scenario)}</h1>',
        page.paragraph(_origin(run), 'muted'),
        _verdict(report),
        _counts(run),
        _signals(run),
        _raster(run),
        _residual(run),
        _synchronisation(run),
        _learned(run),
        _events(run),
        _timing(report),
        _parameters(run),
        _definitions(run),
    ]
    return page.page(title, [part for part in body if part])


def _origin(run: ReportPage) -> str:
    report = run.report
    seconds = report.duration / report.time_scale
    words = (
        f'{run.source}: {report.duration:.1f} units of model time in {seconds:.1f} s '
        f'({report.time_scale:g} units per second)'
    )
    if run.start > 10**18:  # September 2001: older clocks are not the wall's
        start = datetime.fromtimestamp(run.start // 10**9, timezone.utc)
        words += f', from {start:%Y-%m-%d %H:%M:%S} UTC'
    return words + '.'


def _verdict(report: Report) -> str:
    verdict = report.verdict
    return (
        f'<div class="verdict {verdict.replace(" ", "-")}" role="status">'
        f'<span class="symbol" aria-hidden="true">{SYMBOLS[verdict]}</span>'
        f'<div><b>{verdict.capitalize()}</b>{page.paragraph(in_words(report))}</div></div>'
    )


def _counts(run: ReportPage) -> str:
    report = run.report
    r, residual, synchronisation = report.rejection, report.residual, report.synchronisation
    entries = [
        ('disturbance events: w', r.disturbance_events),
        ('reference events: y_r', r.reference_events),
        ('preserved: y with y_r', r.preserved),
        ('spurious: y alone', r.spurious),
        ('missed: y_r alone', r.missed),
        ('ratio of rejection', number(r.ratio)),
        ('residual, largest', number(residual.max_abs)),
        ('residual, rms', number(residual.rms)),
        ('|w - u|, largest', number(synchronisation.max_abs)),
        ('w - u, rms', number(synchronisation.rms)),
    ]
    return page.section(f'After t = {report.settle:g}', page.tiles(entries))


def _signals(run: ReportPage) -> str:
    settle = run.report.settle
    rows = [
        (
            name,
            s.samples,
            number(s.min),
            number(s.max),
            len(s.events),
            sum(t >= settle for t in s.events),
        )
        for name, s in run.report.signals.items()
    ]
    head = ('signal', 'samples', 'min', 'max', 'events', f'after t = {settle:g}')
    shown = set(report_plots.panels(run.signals))
    hidden = [name for name in with_events(run.report.signals) if name not in shown]
    caption = (
        f'Circles: events. Dotted: the threshold, {run.criteria.threshold:g}. Shaded: the settling '
        'time, in which nothing is counted.'
        + (f' Not drawn: {", ".join(hidden)}.' if hidden else '')
    )
    svg = report_plots.signals_svg(run.signals, run.report)
    return page.section('Signals', page.figure(svg, caption), page.table(head, rows))


def _raster(run: ReportPage) -> str:
    caption = (
        'One row per signal, one tick per event. A cross marks an event of y that is spurious, a '
        'triangle one of y_r that y missed.'
    )
    svg = report_plots.raster_svg(run.signals, run.report)
    return page.section('Events', page.figure(svg, caption))


def _residual(run: ReportPage) -> str:
    return page.section('Residual', *(_residual_of(run, plant) for plant in run.report.plants))


def _residual_of(run: ReportPage, plant: PlantReport) -> str:
    size = plant.residual
    caption = (
        f'After settling at most {number(size.max_abs)}, rms {number(size.rms)}. Dotted: '
        f'the threshold of an event, {run.criteria.threshold:g}.'
    )
    return page.figure(report_plots.residual_svg(run.signals, run.report, plant.plant), caption)


def _synchronisation(run: ReportPage) -> str:
    found = [figure for plant in run.report.plants if (figure := _follows(run, plant))]
    return page.section('Does the controller follow the disturbance?', *found) if found else ''


def _follows(run: ReportPage, plant: PlantReport) -> str:
    svg = report_plots.synchronisation_svg(run.signals, run.report, plant.plant)
    if svg is None:
        return ''
    size = plant.synchronisation
    caption = (
        'Above: the disturbance w, wide, and on top of it, thin, the control action u. '
        f'Below: their distance, after settling at most {number(size.max_abs)}, '
        f'rms {number(size.rms)}.'
    )
    return page.figure(svg, caption)


def _learned(run: ReportPage) -> str:
    if not run.report.learned:
        return ''
    caption = f'{"; ".join(map(learned_words, run.report.learned))}. Dotted: the generator.'
    svg = report_plots.learned_svg(run.signals, run.report)
    return page.section('What was learned', page.figure(svg, caption))


def _events(run: ReportPage) -> str:
    rows = sorted(
        (t, name, kind)
        for name, s in run.report.signals.items()
        for t, kind in _kinds(run.report, name, s.events)
    )
    text = [(f'{t:.4f}', name, kind) for t, name, kind in rows[:MOST_EVENTS]]
    more = len(rows) - len(text)
    note = [page.paragraph(f'and {more} more; --json lists all.', 'muted')] if more else []
    if not rows:
        return page.section('Table of events', page.paragraph('No signal has any event.'))
    return page.section(
        'Table of events', page.table(('t', 'signal', 'counted as'), text, 'long words'), *note
    )


def _kinds(report: Report, name: str, events: Sequence[float]) -> list[tuple[float, str]]:
    """Return (t, what it counts as) for each event of a signal."""
    start, stop = report.evidence.span
    words: dict[float, str] = {}
    usual = ''
    for each in report.plants:
        if name in each.plant.disturbances:
            usual = 'disturbance'
        elif name == each.plant.output:
            usual, words = 'preserved', dict.fromkeys(each.outcomes.spurious, 'spurious')
        elif name == each.plant.reference:
            usual, words = 'answered', dict.fromkeys(each.outcomes.missed, 'missed')

    def kind(t: float) -> str:
        if t < start:
            return 'before settling: not counted'
        return 'after the judged span: not counted' if t > stop else words.get(t, usual)

    return [(t, kind(t)) for t in events]


def _timing(report: Report) -> str:
    rows = [
        (
            name,
            f'{t.rate:.2f}',
            *(
                f'{p * 1e3:.3f}'
                for p in (t.period_p50, t.period_p99, t.period_max)
                if p is not None
            ),
            t.gaps,
        )
        for name, t in ((name, s.timing) for name, s in report.signals.items())
        if t is not None and t.rate is not None
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
    entries = definitions(run.report.settle, run.criteria)
    return page.section('How the numbers are defined', page.definitions(entries))
