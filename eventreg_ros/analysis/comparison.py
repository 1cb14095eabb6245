# SPDX-License-Identifier: Apache-2.0
"""Several runs side by side: which events each has, how far apart they are, what was set otherwise.

All times are in model time. Two runs are compared over the span that both have.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import EventregError
from ..printed import Printed
from ..scenario import Scenario
from ..scenario.criteria import WINDOW
from .differences import Difference, Value, differences
from .distances import isi_distance, spike_distance, van_rossum, victor_purpura
from .rejection import match
from .signal import with_events
from .verdict import Report


@dataclass(frozen=True)
class Trains:
    """One run: its name, its verdict, the event times of each signal, and what it was run with.

    ``events`` maps each signal that the run has to its increasing event times from ``start`` to
    ``stop``; ``parameters`` maps NODE.PARAM to its value, and is None where they are not known.
    """

    name: str
    events: Mapping[str, Sequence[float]]
    stop: float
    start: float = 0.0
    verdict: str | None = None
    parameters: Mapping[str, Value] | None = None


def trains_of(name: str, report: Report, scenario: Scenario | None) -> Trains:
    """Return one run as it is compared: from its report, and its scenario where that is known."""
    return Trains(
        name=name,
        events={signal: sorted(entry.events) for signal, entry in report.signals.items()},
        stop=report.duration,
        verdict=report.verdict,
        parameters=None
        if scenario is None
        else {
            f'{n}.{p}': value for n, values in scenario.nodes.items() for p, value in values.items()
        },
    )


def distinct(names: Sequence[str]) -> list[str]:
    """Return ``names`` with a number added to those that came before: exact, exact (2)."""
    return [
        name if names.index(name) == i else f'{name} ({names[: i + 1].count(name)})'
        for i, name in enumerate(names)
    ]


@dataclass(frozen=True)
class Distances:
    """Distances of two trains; see :mod:`.distances`. ``span`` is (start, stop) of both.

    Victor-Purpura moves an event by the window at cost 1, van Rossum's time constant is the window.
    """

    span: tuple[float, float]
    victor_purpura: float
    van_rossum: float
    spike: float
    isi: float


@dataclass(frozen=True)
class Pair:
    """One signal of two runs: the events without a partner, by time, and the distances.

    ``one`` and ``other`` are the runs' names. No distances where the runs share no span.
    """

    one: str
    other: str
    matched: int
    only_one: tuple[float, ...]
    only_other: tuple[float, ...]
    distances: Distances | None


@dataclass(frozen=True)
class Occurrence:
    """An event that some runs have: the median of its times, their spread, and the runs' names."""

    time: float
    spread: float
    runs: tuple[str, ...]


@dataclass(frozen=True)
class SignalComparison:
    """One signal in all runs that have it, named in ``runs``; ``pairs`` are with the first one."""

    signal: str
    runs: tuple[str, ...]
    counts: tuple[int, ...]
    pairs: tuple[Pair, ...]
    occurrences: tuple[Occurrence, ...]

    def share(self, occurrence: Occurrence) -> float:
        """Return in which part of the runs an event occurs."""
        return len(occurrence.runs) / len(self.runs)


@dataclass(frozen=True, repr=False)
class Comparison(Printed):
    """All runs, in the order given, and what differs; ``print`` shows it as a table."""

    runs: tuple[str, ...]
    verdicts: tuple[str | None, ...]
    window: float
    signals: tuple[SignalComparison, ...]
    parameters: tuple[Difference, ...]

    def __repr__(self) -> str:
        verdicts = (str(verdict) for verdict in self.verdicts)
        runs = (f'{run} {verdict}' for run, verdict in zip(self.runs, verdicts, strict=True))
        return f'<Comparison: {", ".join(runs)}>'

    def __str__(self) -> str:
        from .comparison_words import table

        return table(self)


def compare(runs: Sequence[Trains], window: float = WINDOW) -> Comparison:
    """Compare two runs or more; every other one with the first.

    Events at most ``window`` apart are the same. Raises EventregError for fewer than two runs,
    equal names, or a window that is not positive.
    """
    names = [run.name for run in runs]
    if len(runs) < 2 or len(set(names)) < len(names):
        raise EventregError(
            f'two runs or more with names of their own are compared, got '
            f'{", ".join(names) or "none"}; add a run or rename one'
        )
    if not window > 0.0:
        raise EventregError(f'window must be > 0, got {window:g}; give another value')
    signals = with_events({signal for run in runs for signal in run.events})
    return Comparison(
        runs=tuple(names),
        verdicts=tuple(run.verdict for run in runs),
        window=window,
        signals=tuple(_signal(name, runs, window) for name in signals),
        parameters=differences([run.parameters for run in runs]),
    )


def _signal(signal: str, runs: Sequence[Trains], window: float) -> SignalComparison:
    having = [run for run in runs if signal in run.events]
    return SignalComparison(
        signal=signal,
        runs=tuple(run.name for run in having),
        counts=tuple(len(run.events[signal]) for run in having),
        pairs=tuple(_pair(signal, having[0], other, window) for other in having[1:]),
        occurrences=_occurrences(signal, having, window),
    )


def _pair(signal: str, one: Trains, other: Trains, window: float) -> Pair:
    a, b = one.events[signal], other.events[signal]
    pairs = match(a, b, window)
    used_a, used_b = {i for i, _ in pairs}, {j for _, j in pairs}
    span = _common([one, other])
    return Pair(
        one=one.name,
        other=other.name,
        matched=len(pairs),
        only_one=_within(span, [t for i, t in enumerate(a) if i not in used_a]),
        only_other=_within(span, [t for j, t in enumerate(b) if j not in used_b]),
        distances=_distances(_within(span, a), _within(span, b), span, window),
    )


def _distances(
    a: Sequence[float], b: Sequence[float], span: tuple[float, float], window: float
) -> Distances | None:
    if not span[1] > span[0]:
        return None
    return Distances(
        span=span,
        victor_purpura=victor_purpura(a, b, 1.0 / window),
        van_rossum=van_rossum(a, b, window),
        spike=spike_distance(a, b, *span),
        isi=isi_distance(a, b, *span),
    )


def _occurrences(signal: str, runs: Sequence[Trains], window: float) -> tuple[Occurrence, ...]:
    """Return the events of all runs, those within ``window`` that are the same as one."""
    groups = group([run.events[signal] for run in runs], window)
    span = _common(runs)
    found = []
    for members in groups:
        times = [t for t, _ in members]
        middle = float(np.median(times))
        if span[0] <= middle <= span[1]:
            names = tuple(runs[i].name for i in sorted(i for _, i in members))
            found.append(Occurrence(middle, times[-1] - times[0], names))
    return tuple(found)


def group(trains: Sequence[Sequence[float]], window: float) -> list[list[tuple[float, int]]]:
    """Group the events of several trains: at most one of each, at most ``window`` after the first.

    Returns the groups' events as (time, index of the train), in order of time. Each event joins the
    earliest group that takes it; of two trains this makes the pairs of :func:`.rejection.match`.
    """
    merged = sorted((float(t), i) for i, times in enumerate(trains) for t in times)
    groups: list[list[tuple[float, int]]] = []
    first = 0
    for t, i in merged:
        while first < len(groups) and t - groups[first][0][0] > window:
            first += 1
        for members in groups[first:]:
            if all(i != other for _, other in members):
                members.append((t, i))
                break
        else:
            groups.append([(t, i)])
    return groups


def _common(runs: Sequence[Trains]) -> tuple[float, float]:
    return max(run.start for run in runs), min(run.stop for run in runs)


def _within(span: tuple[float, float], times: Sequence[float]) -> tuple[float, ...]:
    return tuple(t for t in times if span[0] <= t <= span[1])
