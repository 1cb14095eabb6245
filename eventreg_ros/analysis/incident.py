# SPDX-License-Identifier: Apache-2.0
"""The first event that should not be, or is missing, and what happened around it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..bags.finding import Finding
from .changes import Change, named
from .signal import NOTHING, Signal, Signals, Span
from .subject import JudgedPlant
from .verdict import PlantReport, Report

SPURIOUS, MISSED = 'spurious', 'missed'

REACH = 3.0
"""Windows of matching before and after the event that are looked at."""

MOST = 6
"""Findings that are reported with one incident."""

SHARE = 0.05
"""Part of the run that is looked at instead where the window is 0."""


class Neighbour(NamedTuple):
    """How long before and after the incident a signal has its nearest events, in model time."""

    signal: str
    before: float | None
    after: float | None


class Stream(NamedTuple):
    """How a signal's samples came around the incident; times in model time.

    ``usual`` is the median interval of the whole run, ``longest`` the longest one around the
    incident, which began ``at``; ``missing`` is how many samples would have filled such gaps.
    """

    signal: str
    samples: int
    usual: float
    longest: float
    at: float
    missing: int


@dataclass(frozen=True)
class Incident:
    """An unwanted event at ``t`` of model time, and what happened within ``span``.

    ``changes`` hold the last one before the span, too. ``findings`` are those within it.
    """

    kind: str
    t: float
    plant: JudgedPlant
    span: Span
    neighbours: tuple[Neighbour, ...]
    streams: tuple[Stream, ...]
    changes: tuple[Change, ...]
    findings: tuple[Finding, ...]


def first_incident(
    report: Report, signals: Signals, findings: Sequence[Finding] = ()
) -> Incident | None:
    """Return the first unwanted event of a run that was judged; None where there is none.

    ``signals`` are those that were judged, ``findings`` further ones, with ``at`` in model time.
    """
    found = [
        (t, kind, each)
        for each in report.plants
        for kind, times in ((SPURIOUS, each.outcomes.spurious), (MISSED, each.outcomes.missed))
        for t in times[:1]
    ]
    if not found:
        return None
    t, kind, plant = min(found, key=lambda entry: entry[0])
    return _around(t, kind, plant, report, signals, (*report.evidence.warnings, *findings))


def _around(
    t: float,
    kind: str,
    found: PlantReport,
    report: Report,
    signals: Signals,
    findings: Iterable[Finding],
) -> Incident:
    plant, window = found.plant, report.subject.criteria.window
    reach = REACH * window or SHARE * report.duration
    span = (max(0.0, t - reach), min(max(report.duration, t), t + reach))
    names = (*plant.needed, *plant.controls, *plant.stimuli)
    before = [change for change in report.changes if change.at < span[0]]
    return Incident(
        kind,
        t,
        plant,
        span,
        tuple(_neighbour(n, report.signals[n].events, t) for n in names if n in report.signals),
        tuple(s for n in names if (s := _stream(n, signals.get(n, NOTHING), span)) is not None),
        (*before[-1:], *(c for c in report.changes if span[0] <= c.at <= span[1])),
        _nearest(findings, t, span),
    )


def _nearest(findings: Iterable[Finding], t: float, span: Span) -> tuple[Finding, ...]:
    """Return the findings within ``span``, in order; of many those nearest to ``t``."""
    known = [(f.at, f) for f in findings if f.at is not None and span[0] <= f.at <= span[1]]
    near = sorted(known, key=lambda pair: abs(pair[0] - t))[:MOST]
    return tuple(f for _, f in sorted(near, key=lambda pair: pair[0]))


def _neighbour(signal: str, events: Sequence[float], t: float) -> Neighbour:
    before = [t - event for event in events if event < t]
    after = [event - t for event in events if event > t]
    return Neighbour(signal, min(before, default=None), min(after, default=None))


def _stream(name: str, signal: Signal, span: Span) -> Stream | None:
    """Return how the samples came within ``span``; None with fewer than two intervals at all."""
    whole = signal[0]
    if len(whole) < 3:
        return None
    usual = float(np.median(np.diff(whole)))
    first = max(int(np.searchsorted(whole, span[0], 'right')) - 1, 0)
    t = whole[first : int(np.searchsorted(whole, span[1], 'left')) + 1]
    intervals = np.diff(t)
    if len(intervals) == 0 or not usual > 0.0:
        return None
    place = int(intervals.argmax())
    missing = int(np.maximum(np.rint(intervals / usual) - 1.0, 0.0).sum())
    return Stream(name, len(t), usual, float(intervals[place]), float(t[place]), missing)


def words(incident: Incident, time_scale: float) -> list[str]:
    """Return what happened in sentences; ``time_scale`` in model time units per second."""
    plant, t = incident.plant, incident.t
    if incident.kind == MISSED:
        lines = [f'{plant.reference} has an event at t = {t:.4f} that {plant.output} missed.']
    else:
        lines = [f'{plant.output} has an event at t = {t:.4f} that nothing asks for.']
    lines += [
        f'{named(change)} at t = {change.at:.1f}, {abs(t - change.at):.1f} '
        f'{"before" if change.at <= t else "after"} it.'
        for change in incident.changes
    ]
    lines += [f'At t = {finding.at:.1f}: {finding.text}.' for finding in incident.findings]
    lines += [_stream_words(each, time_scale) for each in incident.streams if each.missing]
    if incident.streams and not any(each.missing for each in incident.streams):
        lines.append('No sample is missing around it.')
    near = '; '.join(filter(None, map(_neighbour_words, incident.neighbours)))
    return [*lines, f'The nearest other events: {near}.'] if near else lines


def _neighbour_words(each: Neighbour) -> str:
    parts = [
        f'{distance:.2f} {where}'
        for distance, where in ((each.before, 'before'), (each.after, 'after'))
        if distance is not None
    ]
    return f'{each.signal} {" and ".join(parts)}' if parts else ''


def _stream_words(each: Stream, time_scale: float) -> str:
    count = f'{each.missing} sample{"" if each.missing == 1 else "s"}'
    return (
        f'{count} of {each.signal} missing: the longest interval is {each.longest:.3g} '
        f'({1e3 * each.longest / time_scale:.3g} ms) from t = {each.at:.2f}, the usual one '
        f'{each.usual:.3g}.'
    )
