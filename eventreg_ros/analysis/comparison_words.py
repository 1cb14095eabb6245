# SPDX-License-Identifier: Apache-2.0
"""A comparison as a table for people and as JSON for programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from .comparison import Comparison, SignalComparison

MOST = 20
"""No more events are listed in one line than this."""


def table(comparison: Comparison) -> str:
    """Return the verdicts side by side, the events that differ, distances, and parameters."""
    parts = [_runs(comparison), _pairs(comparison), _apart(comparison), _some(comparison)]
    return '\n\n'.join('\n'.join(part) for part in [*parts, _parameters(comparison)] if part)


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Return what ``eventreg compare --json`` writes.

    ``{"runs": [NAME, ...], "verdicts", "window", "signals": {NAME: {"runs", "counts", "pairs":
    [{"one", "other", "matched", "only_one": [t, ...], "only_other", "distances": {"span",
    "victor_purpura", "van_rossum", "spike", "isi"}}], "events": [{"time", "spread", "share",
    "runs"}]}}, "parameters": {NODE.PARAM: [VALUE, ...]}}``, times in model time, one verdict and
    one value per run.
    """
    return {
        'runs': list(comparison.runs),
        'verdicts': list(comparison.verdicts),
        'window': comparison.window,
        'signals': {signal.signal: _signal(signal) for signal in comparison.signals},
        'parameters': {row.parameter: list(row.values) for row in comparison.parameters},
    }


def _signal(signal: SignalComparison) -> dict[str, Any]:
    return {
        'runs': list(signal.runs),
        'counts': list(signal.counts),
        'pairs': [asdict(pair) for pair in signal.pairs],
        'events': [{**asdict(o), 'share': signal.share(o)} for o in signal.occurrences],
    }


def _runs(comparison: Comparison) -> list[str]:
    """Return a line per run: its name, its verdict, and how many events each signal has."""
    width = max(len(name) for name in ('run', *comparison.runs))
    names = [signal.signal for signal in comparison.signals]
    wide = [max(6, len(name)) for name in names]
    head = ' '.join(f'{name:>{size}}' for name, size in zip(names, wide, strict=True))
    lines = [f'{"run":{width}}  {"verdict":12}  {head}  events']
    for run, verdict in zip(comparison.runs, comparison.verdicts, strict=True):
        cells = []
        for signal, size in zip(comparison.signals, wide, strict=True):
            counts = dict(zip(signal.runs, signal.counts, strict=True))
            cells.append(f'{counts.get(run, "-"):>{size}}')
        lines.append(f'{run:{width}}  {verdict or "-":12}  {" ".join(cells)}')
    return lines


def _pairs(comparison: Comparison) -> list[str]:
    """Return a line per signal and pair of runs: how many events they share, how far they are."""
    rows = [(s.signal, pair) for s in comparison.signals for pair in s.pairs]
    names = [f'{pair.one} / {pair.other}' for _, pair in rows]
    width = max((len(name) for name in ('one / other', *names)), default=0)
    wide = max((len(signal) for signal, _ in rows), default=0)
    lines = [
        f'{"":{wide}}  {"one / other":{width}} {"both":>6} {"one":>6} {"other":>6} '
        f'{"Victor-Purpura":>15} {"van Rossum":>11} {"SPIKE":>9} {"ISI":>9}'
    ]
    for (signal, pair), name in zip(rows, names, strict=True):
        line = (
            f'{signal:{wide}}  {name:{width}} {pair.matched:6d} {len(pair.only_one):6d} '
            f'{len(pair.only_other):6d}'
        )
        if (d := pair.distances) is not None:
            line += f' {d.victor_purpura:15.3g} {d.van_rossum:11.3g} {d.spike:9.3g} {d.isi:9.3g}'
        lines.append(line)
    return lines if rows else []


def _apart(comparison: Comparison) -> list[str]:
    """Return the times of the events that one of two runs lacks."""
    return [
        f'{signal.signal} in {name}, not in {other}: {listed(times)}'
        for signal in comparison.signals
        for pair in signal.pairs
        for name, other, times in (
            (pair.one, pair.other, pair.only_one),
            (pair.other, pair.one, pair.only_other),
        )
        if times
    ]


def _some(comparison: Comparison) -> list[str]:
    """Return how often the events occur that not all of three runs or more have."""
    lines = []
    for signal in comparison.signals:
        n = len(signal.runs)
        some = [o for o in signal.occurrences if len(o.runs) < n]
        if n > 2 and some:
            words = ', '.join(f'{o.time:.1f} in {len(o.runs)}' for o in some[:MOST])
            more = f' and {len(some) - MOST} more' if len(some) > MOST else ''
            lines.append(f'{signal.signal}, not in all {n} runs: {words}{more}')
    return lines


def _parameters(comparison: Comparison) -> list[str]:
    if not comparison.parameters:
        return ['parameters: no difference known']
    return [
        f'{row.parameter}: ' + ' | '.join(value_in_words(value) for value in row.values)
        for row in comparison.parameters
    ]


def listed(times: Sequence[float]) -> str:
    """Return times as text, no more than :data:`MOST` of them."""
    words = ', '.join(f'{t:.1f}' for t in times[:MOST])
    return words + (f' and {len(times) - MOST} more' if len(times) > MOST else '')


def value_in_words(value: object) -> str:
    """Return a parameter's value as text, numbers to six digits; a dash for None."""
    if isinstance(value, list | tuple):
        return '[' + ', '.join(value_in_words(item) for item in value) + ']'
    if value is None:
        return '-'
    return f'{value:g}' if isinstance(value, float) else str(value)
