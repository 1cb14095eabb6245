# SPDX-License-Identifier: Apache-2.0
"""What was seen of a run, and what was not: no verdict without evidence.

A signal is unseen where its finite samples are more than ``blind`` apart, and for more than
``blind`` before its first and after its last one. It is sampled too thinly where it usually comes
so seldom that a spike could pass between two samples.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..bags.finding import IMPAIRING, Finding
from .events import Risen
from .signal import Signal, Span
from .subject import Subject

PER_SPIKE = 4.0
"""Samples within a spike of the disturbance, at least; with fewer a smaller spike may be missed."""

FAR = 1e6
"""How many times its threshold or reset an output may be below 0; farther off it has diverged."""

UNSEEN, THIN, NOT_FINITE, ENDS_EARLY = 'unseen', 'thin', 'not-finite', 'ends-early'
STUCK = 'stuck'
"""Codes of what the samples themselves show; those of a reader are in :mod:`..bags.finding`."""

WITHHOLDING = IMPAIRING | {UNSEEN, THIN, ENDS_EARLY, STUCK}
"""Codes after which nothing is called rejected."""


class Coverage(NamedTuple):
    """When a signal was seen, in model time: from ``first`` to ``last``, except ``gaps``.

    ``period`` is the usual time between two samples, None where there are fewer; ``not_finite``
    counts samples without a value.
    """

    first: float
    last: float
    gaps: tuple[Span, ...]
    period: float | None
    not_finite: int = 0


@dataclass(frozen=True)
class Evidence:
    """What a verdict rests on, in model time.

    ``span`` is judged; ``seen`` says which part of it (0 to 1) was seen of each signal that decides
    the verdict, ``unseen`` where it was not. ``warnings`` are all findings, those of the reader
    first.
    """

    span: Span
    seen: Mapping[str, float]
    unseen: Mapping[str, tuple[Span, ...]]
    warnings: tuple[Finding, ...]

    def withholding(self, signals: Iterable[str]) -> list[Finding]:
        """Return the findings that forbid to call a plant of these signals rejected."""
        names = {None, *signals}
        return [f for f in self.warnings if f.code in WITHHOLDING and f.signal in names]

    def was_seen(self, signal: str, start: float, stop: float) -> bool:
        """Say whether ``signal`` was seen throughout from ``start`` to ``stop``."""
        return not any(a < stop and b > start for a, b in self.unseen.get(signal, ()))


def coverage_of(signal: Signal, blind: float) -> Coverage | None:
    """Return when a recorded signal was seen; None without a finite sample."""
    keep = np.isfinite(signal.x)
    t = signal.t if keep.all() else signal.t[keep]
    if len(t) == 0:
        return None
    wide = np.flatnonzero(np.diff(t) > blind)
    gaps = tuple(zip(t[wide].tolist(), t[wide + 1].tolist(), strict=True))
    return coverage(float(t[0]), float(t[-1]), gaps, len(t), len(signal.x) - len(t))


def coverage(
    first: float, last: float, gaps: tuple[Span, ...], samples: int, not_finite: int
) -> Coverage:
    """Return when a signal was seen that had so many finite ``samples`` and these ``gaps``."""
    close = samples - 1 - len(gaps)
    unseen = sum(b - a for a, b in gaps)
    # Where every sample is far from the next, that is how the signal comes.
    length, steps = (last - first - unseen, close) if close else (unseen, len(gaps))
    return Coverage(first, last, gaps, length / steps if steps else None, not_finite)


def gather(
    subject: Subject,
    coverage: Mapping[str, Coverage | None],
    span: Span,
    end: float,
    findings: Sequence[Finding] = (),
    risen: Mapping[str, Risen] | None = None,
) -> Evidence:
    """Return the evidence for a verdict on ``span``, of a recording that ends at ``end``.

    ``coverage`` is that of each signal that is there. ``findings`` are the reader's, in model time;
    ``risen`` says in model time how each signal has been above, where that is known.
    """
    blind, spike = subject.criteria.blind, _spike(subject, risen or {})
    unseen = {name: _unseen(coverage.get(name), span, blind) for name in subject.needed}
    warnings = [*findings]
    if subject.duration is not None and end < subject.duration - blind:
        warnings.append(_ends_early(end, subject.duration))
    for name, stretches in unseen.items():
        warnings += _of_signal(name, coverage.get(name), stretches, span, blind, spike)
    warnings += _held_up(subject, risen or {}, span)
    warnings += _fallen(subject, risen or {}, span)
    return Evidence(
        span=span,
        seen={name: _share(stretches, span) for name, stretches in unseen.items()},
        unseen={name: stretches for name, stretches in unseen.items() if stretches},
        warnings=tuple(warnings),
    )


def _held_up(subject: Subject, risen: Mapping[str, Risen], span: Span) -> list[Finding]:
    """Return what is to be said of outputs that are up all the time: no event could be seen.

    A reference that is up as long asks for nothing else.
    """
    since = {name: each.since for name, each in risen.items() if each.since is not None}
    up = {name: t for name, t in since.items() if t <= span[0] < span[1]}
    return [
        _stuck(plant.output, up[plant.output])
        for plant in subject.plants
        if plant.output in up and plant.reference not in up
    ]


def _fallen(subject: Subject, risen: Mapping[str, Risen], span: Span) -> list[Finding]:
    """Return what is to be said of outputs that end far below all that could be an event."""
    lowest = lowest_end(subject)
    ends = {name: each.last for name, each in risen.items() if each.last is not None}
    return [
        Finding(STUCK, plant.output, span[1], _diverged(plant.output, ends[plant.output]))
        for plant in subject.plants
        if ends.get(plant.output, lowest) < lowest
    ]


def lowest_end(subject: Subject) -> float:
    """Return how far below 0 an output may end; -inf where its limits are 0 and say nothing."""
    limit = max(abs(subject.criteria.threshold), abs(subject.criteria.reset))
    return -FAR * limit if limit > 0.0 else -np.inf


def _diverged(name: str, end: float) -> str:
    return (
        f'{name} ends at {end:.3g}, more than a million times its threshold below 0, so no event '
        'can begin: see whether it diverged, or give threshold and reset that fit it'
    )


def _stuck(name: str, since: float) -> Finding:
    text = (
        f'{name} has been above its threshold all the time since {since:.1f}, so no event can '
        'begin: see whether it diverged, or give threshold and reset that fit it'
    )
    return Finding(STUCK, name, since, text)


def _spike(subject: Subject, risen: Mapping[str, Risen]) -> float | None:
    """Return how long the longest spike of the disturbances lasts; None without any.

    The longest, since noise makes short ones.
    """
    names = {name for plant in subject.plants for name in plant.disturbances}
    return max((risen[name].longest for name in names if name in risen), default=0.0) or None


def _unseen(coverage: Coverage | None, span: Span, blind: float) -> tuple[Span, ...]:
    """Return the stretches of ``span`` in which a signal was not seen."""
    start, stop = span
    if coverage is None:
        return (span,)
    first, last, gaps = coverage[:3]
    found = [(start, first)] if first - start > blind else []
    found += gaps
    found += [(last, stop)] if stop - last > blind else []
    inside = [(max(a, start), min(b, stop)) for a, b in found]
    return tuple((a, b) for a, b in inside if b > a)


def _share(stretches: Sequence[Span], span: Span) -> float:
    length = span[1] - span[0]
    if not length > 0.0:
        return 0.0
    return max(0.0, 1.0 - sum(b - a for a, b in stretches) / length)


def _of_signal(
    name: str,
    coverage: Coverage | None,
    stretches: Sequence[Span],
    span: Span,
    blind: float,
    spike: float | None,
) -> list[Finding]:
    """Return what is to be said of one signal."""
    if coverage is None:
        return [Finding(UNSEEN, name, span[0], f'{name} was not seen at all')]
    most = blind if spike is None else min(blind, spike / PER_SPIKE)
    if coverage.period is not None and coverage.period > most * (1.0 + 1e-9):
        return [Finding(THIN, name, coverage.first, _thin(name, coverage.period, most))]
    bad = f'{coverage.not_finite} samples of {name} are not finite'
    if stretches:
        text = _not_seen(name, stretches, span) + (f'; {bad}' if coverage.not_finite else '')
        return [Finding(UNSEEN, name, stretches[0][0], text)]
    return [Finding(NOT_FINITE, name, None, bad)] if coverage.not_finite else []


def _thin(name: str, period: float, most: float) -> str:
    return (
        f'{name} is sampled too thinly: one sample every {period:.3g} of model time, and a spike '
        f'may pass between two that are more than {most:.3g} apart'
    )


def _not_seen(name: str, stretches: Sequence[Span], span: Span) -> str:
    missing = sum(b - a for a, b in stretches)
    (first, end), more = stretches[0], len(stretches) - 1
    return (
        f'{name} was not seen for {missing:.1f} of {span[1] - span[0]:.1f} units of model time: '
        f'from {first:.1f} to {end:.1f}' + (f' and {more} more such stretches' if more else '')
    )


def _ends_early(end: float, duration: float) -> Finding:
    text = f'the recording ends at {end:.1f}, and the scenario asks for {duration:g} of model time'
    return Finding(ENDS_EARLY, None, end, text)
