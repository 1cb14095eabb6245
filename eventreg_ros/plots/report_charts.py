# SPDX-License-Identifier: Apache-2.0
"""The charts of a report: which signals, on which scale, with which marks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis.changes import named
from ..analysis.incident import MISSED, SPURIOUS, Incident
from ..analysis.signal import NOTHING, Signal, Signals, Span, family, total, with_events
from ..analysis.subject import JudgedPlant
from ..analysis.verdict import Report, residual, synchronisation
from ..models.roles import SIGNALS
from .axis import Axis, around, decades
from .chart import Chart, Events, Fault, Line, Mark, Panel, Raster, Row
from .chart_scale import within

MOST = 8
"""Panels of signals in one chart; a foreign bag may hold any number of them."""

MOST_MARKS = 40
"""Changes that are marked, and stretches that are hatched, in one chart."""

FLOOR = 1e-16
"""Lower end of logarithmic axes; what is smaller is rounding."""

POINTS = 4000
"""Samples of a magnified signal up to which each is a point of its own."""


def look(signal: str) -> str:
    """Return the class of the page's style for a signal; one that is none of ours is ``other``."""
    name = family(signal.rpartition('/')[2])
    return name if name in SIGNALS else 'other'


def panels(signals: Signals) -> list[str]:
    """Return the names of the signals that are drawn: with samples, the paper's first."""
    names = [name for name in with_events(signals) if len(signals[name][0])]
    return names[: max(MOST, sum(look(name) != 'other' for name in names))]


def signals_chart(signals: Signals, report: Report) -> Chart:
    """Return the chart of every signal, each reference over the output it is compared with."""
    beside = _references(signals, report)
    names = [name for name in panels(signals) if name not in beside.values()]
    outputs = [each.plant.output for each in report.plants]
    shown = [
        _panel(
            [n for n in (name, beside.get(name)) if n is not None],
            signals, report, height=140 if name in outputs else 100,
        )
        for name in names
    ]  # fmt: skip
    return _chart('Signals over model time', report, shown)


def _references(signals: Signals, report: Report) -> dict[str, str]:
    return {
        p.plant.output: p.plant.reference
        for p in report.plants
        if p.plant.reference is not None and len(signals.get(p.plant.reference, NOTHING)[0])
    }


def _panel(
    names: Sequence[str],
    signals: Signals,
    report: Report,
    *,
    height: int = 110,
    span: Span | None = None,
    points: bool = False,
) -> Panel:
    """Return a panel of signals on the scale of the threshold, where it is theirs."""
    criteria = report.subject.criteria
    found = {name: _within(signals[name], span) for name in names}
    room = criteria.threshold - criteria.reset
    levels = (criteria.reset - room, criteria.threshold + room)
    axis = around((s.x for s in found.values()), levels if look(names[0]) != 'other' else ())
    here = axis.low <= criteria.threshold <= axis.high
    return Panel(
        [
            Line(n, _beside(n, names), s.t, s.x, points and len(s.t) <= POINTS)
            for n, s in found.items()
        ],
        axis,
        criteria.threshold if here else None,
        f'threshold {criteria.threshold:g}',
        [Events(look(n), report.signals[n].events, criteria.threshold) for n in names if here],
        height,
    )


def _beside(name: str, others: Sequence[str]) -> str:
    """Return the look of a signal among others: w is a band where u lies upon it."""
    band = look(name) == 'w' and any(look(other) == 'u' for other in others)
    return f'{look(name)} band' if band else look(name)


def _within(signal: Signal, span: Span | None) -> Signal:
    return Signal(*(signal if span is None else within(*signal, span)))


def raster_chart(signals: Signals, report: Report) -> Chart:
    """Return the events of all signals, a row each, with those of y and y_r that are wrong."""
    faults: dict[str | None, list[Fault]] = {}
    for each in report.plants:
        faults.setdefault(each.plant.output, []).append(Fault(SPURIOUS, each.outcomes.spurious))
        faults.setdefault(each.plant.reference, []).append(Fault(MISSED, each.outcomes.missed))
    rows = [Row(n, look(n), report.signals[n].events, faults.get(n, ())) for n in panels(signals)]
    return _chart('Events of every signal, one row each', report, [Raster(rows)])


def residual_chart(signals: Signals, report: Report, plant: JudgedPlant) -> Chart:
    """Return |y - y_r| (|y| without a reference) over model time, on a logarithmic axis."""
    threshold, compared = report.subject.criteria.threshold, plant.output
    if plant.output in _references(signals, report):
        compared = f'{plant.output} \u2212 {plant.reference}'
    level = float(np.log10(abs(threshold) or 1.0))
    panel = _magnitude(f'|{compared}|', 'y', residual(signals, plant), level)
    return _chart(f'The residual, |{compared}|, over model time', report, [panel])


def synchronisation_chart(signals: Signals, report: Report, plant: JudgedPlant) -> Chart | None:
    """Return u on top of w, sums where there are several, and |w - u|; None when one is missing."""
    left = synchronisation(signals, plant)
    if len(left.t) == 0:
        return None
    w, u = ' + '.join(plant.disturbances), ' + '.join(plant.controls)
    both = f'{w} \u2212 {u}' if len(plant.controls) == 1 else f'{w} \u2212 ({u})'
    above, below = (total(signals, names) for names in (plant.disturbances, plant.controls))
    lines = [Line(w, 'w band', *above), Line(u, 'u', *below)]
    over = Panel(lines, around((above.x, below.x)))
    return _chart(
        'Disturbance w and control action u, and their difference',
        report,
        [over, _magnitude(f'|{both}|', 'y', left)],
    )


def learned_chart(signals: Signals, report: Report) -> Chart:
    """Return 1/tau of every controller that learned it, and that of the generator it came to."""
    shown = []
    for each in report.learned:
        t, x = signals[each.signal]
        level = None if each.value is None else 1.0 / each.value
        with np.errstate(divide='ignore'):
            line = Line(f'1 / {each.signal}', 'u', t, 1.0 / x)
        axis = around([line.x], () if level is None else (level,))
        shown.append(Panel([line], axis, level, f'1/{each.parameter} of {each.generator}'))
    return _chart('What the controllers learned over model time', report, shown)


def _magnitude(name: str, kind: str, signal: Signal, level: float | None = None) -> Panel:
    axis, logs = decades(np.abs(signal.x), FLOOR)
    if level is not None:
        axis = Axis(min(axis.low, level - 0.5), max(axis.high, level + 0.5), True)
    words = '' if level is None else f'threshold {10.0**level:g}'
    return Panel([Line(name, kind, signal.t, logs)], axis, level, words)


def incident_chart(signals: Signals, report: Report, incident: Incident) -> Chart:
    """Return what happened around the first unwanted event, sample by sample."""
    plant = incident.plant
    groups = [
        (*plant.disturbances, *plant.controls),
        plant.stimuli,
        (plant.output, *(n for n in (plant.reference,) if n is not None)),
    ]
    there = [[n for n in names if len(signals.get(n, NOTHING)[0])] for names in groups]
    shown = [_panel(n, signals, report, span=incident.span, points=True) for n in there if n]
    title = f'The first unwanted event, at t = {incident.t:.2f}, magnified'
    return _chart(title, report, shown, incident.span, incident.t)


def _chart(
    title: str,
    report: Report,
    shown: Sequence[Panel | Raster],
    span: Span | None = None,
    at: float | None = None,
) -> Chart:
    start, stop = whole = (0.0, report.duration) if span is None else span
    first, last = report.evidence.span
    unseen = sorted({s for spans in report.evidence.unseen.values() for s in spans})
    return Chart(
        title,
        whole,
        shown,
        _cut([(start, first), (last, stop)], whole),
        _cut(unseen, whole)[: 5 * MOST_MARKS],
        [
            Mark(change.at, named(change))
            for change in report.changes
            if whole[0] <= change.at <= whole[1]
        ][:MOST_MARKS],
        at=at,
    )


def _cut(spans: Sequence[Span], whole: Span) -> list[Span]:
    """Return the parts of ``spans`` that lie within ``whole``."""
    inside = [(max(a, whole[0]), min(b, whole[1])) for a, b in spans]
    return [(a, b) for a, b in inside if b > a]
