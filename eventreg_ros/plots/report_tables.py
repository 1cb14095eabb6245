# SPDX-License-Identifier: Apache-2.0
"""The tables and lists of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..analysis.messages import Messages, messages
from ..analysis.noise import words as noise_words
from ..analysis.signal import Signals
from ..analysis.train_report import PlantTrains, TrainReport, train_report
from ..analysis.verdict import PlantReport, Report
from ..bags.finding import Finding
from . import html as page
from .report_words import number

MOST_EVENTS = 2000
"""The table of events lists no more of them than this."""

MOST_LINES = 100
"""Findings and changes that are listed."""


def plants(report: Report) -> str:
    """Return the verdict on each plant."""
    head = ('plant', 'verdict', 'spurious', 'missed', 'preserved', 'residual', 'why')
    rows = [
        (
            each.plant.output,
            each.verdict,
            each.rejection.spurious,
            each.rejection.missed,
            each.rejection.preserved,
            number(each.residual.max_abs),
            each.reason,
        )
        for each in report.plants
    ]
    return page.table(head, rows, 'wide words', 'the verdict on each plant')


def findings(found: Sequence[Finding]) -> str:
    """Return findings as a list, each with its code, its signal and its time."""
    lines = []
    for code, signal, at, text in found:
        where = [
            code,
            *([signal] if signal else []),
            *([f't = {at:.1f}'] if at is not None else []),
        ]
        lines.append(f'{text} ({", ".join(where)})')
    return cut(lines)


def noted(found: Sequence[Finding]) -> str:
    """Return what else was noticed: of what came from one source again and again, the last."""
    groups: dict[object, list[Finding]] = {}
    for i, each in enumerate(found):
        groups.setdefault(i if each.signal is None else (each.code, each.signal), []).append(each)
    return cut([_line(same) for same in groups.values()])


def _line(same: Sequence[Finding]) -> str:
    """Return the last of some findings, how many there are, and since when."""
    code, _, at, text = same[-1]
    first = same[0].at
    if len(same) > 1:
        begin = '' if first is None else f', from t = {first:.1f} on'
        return f'{text} ({code}, {len(same)} times{begin})'
    return f'{text} ({code})' if at is None else f'{text} ({code}, t = {at:.1f})'


def cut(lines: Sequence[str]) -> str:
    """Return a list of plain texts, of which only the first are shown where there are many."""
    more = len(lines) - MOST_LINES
    rest = page.paragraph(f'and {more} more; --json lists all.', 'muted') if more > 0 else ''
    return page.items(lines[:MOST_LINES]) + rest


def signals(report: Report) -> str:
    """Return samples, range and events of each signal."""
    start, stop = report.evidence.span
    rows = [
        (
            name,
            s.samples,
            number(s.min),
            number(s.max),
            len(s.events),
            sum(start <= t <= stop for t in s.events),
        )
        for name, s in report.signals.items()
    ]
    head = ('signal', 'samples', 'min', 'max', 'events', f'after t = {start:g}')
    return page.table(head, rows, name='the signals')


def events(report: Report) -> str:
    """Return every event and what it counts as."""
    rows = sorted(
        (t, name, kind)
        for name, s in report.signals.items()
        for t, kind in _kinds(report, name, s.events)
    )
    text = [(f'{t:.4f}', name, kind) for t, name, kind in rows[:MOST_EVENTS]]
    more = len(rows) - len(text)
    note = [page.paragraph(f'and {more} more; --json lists all.', 'muted')] if more else []
    if not rows:
        return page.section('Table of events', page.paragraph('No signal has any event.'))
    head = ('t', 'signal', 'counted as')
    return page.section(
        'Table of events', page.table(head, text, 'long words', 'the events'), *note
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


def _per_event(sent: Messages | None) -> str:
    return '' if sent is None or sent.per_event is None else f'{sent.per_event:.3g}'


def timing(report: Report, time: str | None, measured: str) -> str:
    """Return how regularly the signals came, and what the nodes measured of themselves."""
    sent = messages(report)
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
            _per_event(sent.get(name)),
        )
        for name, t in ((name, s.timing) for name, s in report.signals.items())
        if t is not None and t.rate is not None
    ]
    if not rows:
        return ''
    head = (
        'signal', 'messages/s', 'median, ms', '99 %, ms', 'longest, ms', 'gaps',
        'messages per event of the disturbance',
    )  # fmt: skip
    stamps = f'{time} times of the messages' if time else 'stamps in the bag'
    parts = [
        page.paragraph(f'The time between one sample and the next, by the {stamps}.'),
        page.table(head, rows, name='the time between samples'),
    ]
    if measured:
        parts.append(page.folded('What the nodes measured of themselves', measured))
    return page.section('Timing', *parts)


def parameters(given: Mapping[str, Mapping[str, Any]], text: str | None) -> str:
    """Return the parameters by node, and the parameter file."""
    if not given:
        words = 'The bag holds no scenario, and none was given: defaults were taken.'
        return page.section('Scenario', page.paragraph(words))
    names = dict.fromkeys(name for values in given.values() for name in values)
    rows = [(name, *(_value(values.get(name, '')) for values in given.values())) for name in names]
    parts = [page.table(('parameter', *given), rows, 'wide words', 'the parameters')]
    if text is not None:
        parts.append(page.folded('The parameter file', text))
    return page.section('Scenario', *parts)


def _value(value: Any) -> str:
    """Return a parameter as text, numbers to six digits."""
    if isinstance(value, list):
        return ', '.join(map(_value, value))
    return f'{value:g}' if isinstance(value, float) else str(value)


# Spike trains ------------------------------------------------------------------------------------


def trains(signals: Signals, report: Report) -> str:
    """Return the figures of each train of events, and how they go together."""
    criteria = report.subject.criteria
    found = train_report(signals, criteria, [each.plant for each in report.plants])
    head = ('signal', 'events', 'rate', 'mean interval', 'shortest', 'longest', 'CV', 'CV2', 'LV',
            'width', 'bursts')  # fmt: skip
    rows = [
        (
            name,
            train.count,
            *map(number, (train.rate, train.interval_mean, train.interval_min)),
            *map(number, (train.interval_max, train.cv, train.cv2, train.lv, train.width_median)),
            len(train.bursts),
        )
        for name, train in found.trains.items()
    ]
    words = (
        f'From t = {criteria.settle:g} on; times and rate in model time '
        f'(one unit is {1e3 / report.time_scale:g} ms).'
    )
    lines = [line for each in report.plants for line in _together(each, found)]
    noise = [noise_words(name, each) for name, each in found.noise.items()]
    return page.section(
        'Spike trains',
        page.paragraph(words),
        page.table(head, rows, name='the figures of each train'),
        page.items([*lines, *filter(None, noise)]),
    )


def _together(each: PlantReport, found: TrainReport) -> list[str]:
    plant = each.plant
    trains = found.plants[plant.output]
    lines = [_settling(trains, plant.output)]
    if (answer := trains.answer) is not None:
        lines.append(
            f'{plant.output} answers {plant.reference}: {answer.matched} events match, precision '
            f'{number(answer.precision)}, recall {number(answer.recall)}, median latency '
            f'{number(answer.latency_median)}.'
        )
    if (following := trains.following) is not None and following.locking is not None:
        lines.append(
            f'{plant.controls[0]} follows {plant.disturbances[0]}: locking '
            f'{number(following.locking)}, mean phase {number(following.mean)} of a period.'
        )
    return lines


def _settling(trains: PlantTrains, output: str) -> str:
    if trains.settling is None:
        return (
            f'Settling time of {output}: not known, too few events of the disturbance followed the '
            'last unwanted event.'
        )
    if trains.settling == 0.0:
        return f'Settling time of {output}: 0, there is no unwanted event in the whole run.'
    return f'Settling time of {output}: {trains.settling:.1f}, when it had its last unwanted event.'
