# SPDX-License-Identifier: Apache-2.0
"""The report on a run: one HTML page, for a person who wants to know what happened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from html import escape
from typing import Any

from ..analysis.changes import named
from ..analysis.incident import first_incident
from ..analysis.incident import words as incident_words
from ..analysis.learning import words as learned_words
from ..analysis.recorded import Analysis
from ..analysis.signal import Signals, with_events
from ..analysis.verdict import PlantReport, Report
from ..bags.finding import Finding
from ..scenario import Criteria, Scenario
from . import html as page
from . import report_charts as charts
from . import report_tables as tables
from .chart_html import chart
from .report_words import definitions, number, percent, sentence

SYMBOLS = {'rejected': '✓', 'not rejected': '✗', 'undecided': '?'}


@dataclass(frozen=True)
class ReportPage:
    """What the page is made from: a verdict's report, and what it was judged from.

    ``signals`` maps each name to (t, values), both of shape (n,), t in model time; ``report`` is
    :func:`.verdict.judge`'s of them. ``parameters`` are those of each node, and ``text`` the
    parameter file, where known. ``start`` is the first sample's time stamp, in nanoseconds since
    1970 if the run had a wall clock, ``time`` says which stamps counted. ``noted`` is what else was
    noticed, ``at`` in model time, and ``measured`` what nodes measured of themselves, as text.
    """

    source: str
    signals: Signals
    report: Report
    parameters: Mapping[str, Mapping[str, Any]]
    text: str | None = None
    start: int = 0
    time: str | None = None
    noted: Sequence[Finding] = ()
    measured: str = ''

    @property
    def criteria(self) -> Criteria:
        """The numbers that the verdict rests on."""
        return self.report.subject.criteria


def report_page(
    analysis: Analysis, source: str, noted: Sequence[Finding] = (), measured: str = ''
) -> ReportPage:
    """Return what the page on a recorded bag is made from; ``source`` is what the bag is called."""
    recording = analysis.recording
    return ReportPage(
        source, analysis.signals, analysis.report, *_of(analysis.scenario), recording.start,
        recording.time, noted, measured,
    )  # fmt: skip


def simulated_page(signals: Signals, report: Report, scenario: Scenario) -> ReportPage:
    """Return what the page on a simulation is made from."""
    return ReportPage('simulated', signals, report, *_of(scenario))


def _of(scenario: Scenario | None) -> tuple[Mapping[str, Mapping[str, Any]], str | None]:
    return (scenario.given, scenario.to_yaml()) if scenario else ({}, None)


def render(run: ReportPage) -> str:
    """Return the page."""
    report = run.report
    body = [
        f'<h1>Event disturbance rejection: {escape(report.scenario)}</h1>',
        page.paragraph(_origin(run), 'muted'),
        _verdict(report),
        page.hint(),
        _evidence(run),
        _counts(run),
        _incident(run),
        _signals(run),
        _raster(run),
        _residual(run),
        _synchronisation(run),
        _learned(run),
        _changes(report),
        tables.trains(run.signals, report),
        tables.events(report),
        tables.timing(report, run.time, run.measured),
        tables.parameters(run.parameters, run.text),
        page.section(
            'How the numbers are defined',
            page.definitions(definitions(report.settle, run.criteria)),
        ),
    ]
    return page.page(f'{report.scenario}: {report.verdict}', [part for part in body if part])


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
    box = (
        f'<div class="verdict {verdict.replace(" ", "-")}" role="status">'
        f'<span class="symbol" aria-hidden="true">{SYMBOLS[verdict]}</span>'
        f'<div><b>{verdict.capitalize()}</b>{page.paragraph(sentence(report.reason))}</div></div>'
    )
    return box if len(report.plants) < 2 else f'{box}\n{tables.plants(report)}'


def _evidence(run: ReportPage) -> str:
    evidence = run.report.evidence
    start, stop = evidence.span
    words = f'The verdict covers t = {round(start, 1):.10g} to {round(stop, 1):.10g}.'
    if evidence.seen:
        seen = ', '.join(f'{name} {percent(share)}' for name, share in evidence.seen.items())
        words += f' Seen of it: {seen}.'
    if not evidence.warnings:
        words += ' Nothing was found to be wrong.'
    lists = [tables.findings(evidence.warnings)] if evidence.warnings else []
    lists += [page.paragraph('Also noticed:'), tables.noted(run.noted)] if run.noted else []
    return page.section('Evidence', page.paragraph(words), *lists)


def _counts(run: ReportPage) -> str:
    report = run.report
    r, residual, synchronisation = report.rejection, report.residual, report.synchronisation
    compared = any(each.plant.reference for each in report.plants)
    entries = [
        ('disturbance events: w', r.disturbance_events),
        *([('reference events: y_r', r.reference_events)] if compared else []),
        *([('preserved: y with y_r', r.preserved)] if compared else []),
        ('spurious: y alone', r.spurious),
        *([('missed: y_r alone', r.missed)] if compared else []),
        ('ratio of rejection', number(r.ratio)),
        ('residual, largest', number(residual.max_abs)),
        ('residual, rms', number(residual.rms)),
        ('|w - u|, largest', number(synchronisation.max_abs)),
        ('w - u, rms', number(synchronisation.rms)),
    ]
    return page.section(f'After t = {report.settle:g}', page.tiles(entries))


def _incident(run: ReportPage) -> str:
    found = first_incident(run.report, run.signals, run.noted)
    if found is None:
        return ''
    picture = charts.incident_chart(run.signals, run.report, found)
    return page.section(
        'The first unwanted event',
        page.items(incident_words(found, run.report.time_scale)),
        chart(
            picture,
            f'From t = {found.span[0]:.1f} to {found.span[1]:.1f}. Close up, dots are samples.',
        ),
    )


def _signals(run: ReportPage) -> str:
    shown = set(charts.panels(run.signals))
    hidden = [name for name in with_events(run.report.signals) if name not in shown]
    caption = 'Circles: events. Triangles at an edge: samples off the scale.' + (
        f' Not drawn: {", ".join(hidden)}.' if hidden else ''
    )
    return page.section(
        'Signals',
        chart(charts.signals_chart(run.signals, run.report), caption),
        tables.signals(run.report),
    )


def _raster(run: ReportPage) -> str:
    caption = (
        'One row per signal, one tick per event. A cross marks an event of y that is spurious, a '
        'triangle one of y_r that y missed.'
    )
    return page.section('Events', chart(charts.raster_chart(run.signals, run.report), caption))


def _residual(run: ReportPage) -> str:
    return page.section('Residual', *(_residual_of(run, plant) for plant in run.report.plants))


def _residual_of(run: ReportPage, plant: PlantReport) -> str:
    size = plant.residual
    caption = (
        f'After settling at most {number(size.max_abs)}, rms {number(size.rms)}. Dotted: '
        f'the threshold of an event, {run.criteria.threshold:g}.'
    )
    return chart(charts.residual_chart(run.signals, run.report, plant.plant), caption)


def _synchronisation(run: ReportPage) -> str:
    found = [figure for plant in run.report.plants if (figure := _follows(run, plant))]
    return page.section('Does the controller follow the disturbance?', *found) if found else ''


def _follows(run: ReportPage, plant: PlantReport) -> str:
    picture = charts.synchronisation_chart(run.signals, run.report, plant.plant)
    if picture is None:
        return ''
    size = plant.synchronisation
    caption = (
        'Above: the disturbance w, wide, and on top of it, thin, the control action u. '
        f'Below: their distance, after settling at most {number(size.max_abs)}, '
        f'rms {number(size.rms)}.'
    )
    return chart(picture, caption)


def _learned(run: ReportPage) -> str:
    if not run.report.learned:
        return ''
    caption = f'{"; ".join(map(learned_words, run.report.learned))}. Dotted: the generator.'
    picture = charts.learned_chart(run.signals, run.report)
    return page.section('What was learned', chart(picture, caption))


def _changes(report: Report) -> str:
    if not report.changes:
        return ''
    lines = [f't = {change.at:.1f}: {named(change)}' for change in report.changes]
    return page.section('What was changed during the run', tables.cut(lines))
