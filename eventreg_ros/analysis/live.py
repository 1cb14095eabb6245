# SPDX-License-Identifier: Apache-2.0
"""The verdict on a run that goes on, by the same code as on a recorded one."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

from ..models.roles import SIGNALS
from ..scenario import Criteria, parse
from .coded import Coded, codings
from .decision import Decision, PlantDecision, decide, summary
from .events import Risen
from .evidence import Coverage, Evidence, coverage, gather
from .signal import Span, is_of
from .subject import Subject, subject_by_name, subject_of


class LiveVerdict(NamedTuple):
    """The verdict so far, at ``t`` of model time.

    ``margin_used`` is the largest part of the delay margin that a block has measured, None where
    none has measured any.
    """

    t: float
    decision: Decision
    plants: tuple[PlantDecision, ...]
    evidence: Evidence
    margin_used: float | None

    def values(self) -> dict[str, str]:
        """Return it as a diagnostic status shows it: keys and values."""
        found = {
            'verdict': self.decision.verdict,
            'reason': self.decision.reason,
            't': f'{self.t:.3f}',
            'settle': f'{self.evidence.span[0]:g}',
        }
        if self.margin_used is not None:
            found['margin_used'] = f'{self.margin_used:.3f}'
        for each in self.plants:
            for name, count in vars(each.rejection).items():
                found[f'{each.plant.output}.{name}'] = str(count)
        found |= {f'{name}.seen': f'{share:.4f}' for name, share in self.evidence.seen.items()}
        return found


class LiveJudge:
    """Collects events and samples of a run, and judges it when asked.

    Times come in seconds of any clock; model time begins with the first sample of one of the
    paper's signals. ``coded`` are the signals of which not every sample is sent.
    """

    def __init__(self, subject: Subject, coded: Mapping[str, Coded] | None = None) -> None:
        # How long the run was meant to take is of no concern before its end.
        self._subject = replace(subject, duration=None)
        self._scale = subject.time_scale
        self._since: float | None = None
        self._base = 0.0
        blind, self._coded = subject.criteria.blind, coded or {}
        self._seen = {name: _Watch(blind, self._coded.get(name)) for name in subject.needed}
        self._last: dict[str, tuple[float, float]] = {}
        self._events: dict[str, list[float]] = {name: [] for name in subject.needed}
        self.margin_used: float | None = None

    @classmethod
    def of(
        cls,
        signals: Collection[str],
        criteria: Criteria,
        time_scale: float,
        text: str | None = None,
        namespace: str = '',
    ) -> LiveJudge:
        """Return the judge of a run of which ``signals`` are heard.

        ``text`` is the scenario's parameter file, and ``namespace`` where the signals are in it;
        without it names decide. Raises ScenarioError.
        """
        if text is None:
            return cls(subject_by_name(signals, criteria, time_scale=time_scale))
        scenario = parse(text, 'of the run').within(namespace)
        subject = subject_of(scenario, signals)
        return cls(replace(subject, criteria=criteria, time_scale=time_scale), codings(scenario))

    def rescale(self, now: float, time_scale: float) -> None:
        """Let model time go on at another pace from ``now`` on."""
        if self._since is not None:
            self._base, self._since = self.model_time(now), now
        self._scale = time_scale

    def saw(self, signal: str, t: float, value: float) -> None:
        """Take a sample."""
        if self._since is None and _is_ours(signal):
            self._since = t
        watch = self._seen.get(signal)
        if watch is not None:
            watch.saw(self.model_time(t), value)

    def points(self, signal: str, t: float, value: float) -> list[tuple[float, float]]:
        """Return what a detector of events is given for a sample, as (seconds, value).

        A signal of which not every sample is sent stays as it is until a step before the next.
        """
        coded = self._coded.get(signal)
        if coded is None:
            return [(t, value)]
        before = self._last.get(signal)
        self._last[signal] = (t, value)
        step = coded.h / coded.time_scale
        if before is None or not 1.5 * step < t - before[0] <= coded.patience:
            return [(t, value)]
        return [(t - step, before[1]), (t, value)]

    def event(self, signal: str, t: float) -> None:
        """Take an event."""
        if signal in self._events:
            self._events[signal].append(self.model_time(t))

    @property
    def disturbances(self) -> int:
        """How many events the disturbances have had."""
        names = {name for plant in self._subject.plants for name in plant.disturbances}
        return sum(len(self._events.get(name, ())) for name in names)

    def model_time(self, t: float) -> float:
        """Return the model time at ``t`` seconds; before the first sample 0."""
        return 0.0 if self._since is None else self._base + (t - self._since) * self._scale

    def verdict(self, now: float, risen: Mapping[str, Risen] | None = None) -> LiveVerdict:
        """Return the verdict so far, at ``now`` seconds.

        ``risen`` says in seconds how each signal has been above, where that is known.
        """
        t, settle = self.model_time(now), self._subject.criteria.settle
        coverage = {name: watch.coverage(t) for name, watch in self._seen.items()}
        above = {name: self._in_model_time(each) for name, each in (risen or {}).items()}
        span = (settle, max(settle, t))
        evidence = gather(self._subject, coverage, span, t, risen=above)
        plants = decide(self._subject, self._events, evidence)
        return LiveVerdict(t, summary(plants), plants, evidence, self.margin_used)

    def _in_model_time(self, risen: Risen) -> Risen:
        since = None if risen.since is None else self.model_time(risen.since)
        return Risen(risen.longest * self._scale, since, risen.last)

    def note_margin(self, part: float) -> None:
        """Take which part of the delay margin a block has measured to be used."""
        self.margin_used = max(self.margin_used or 0.0, part)


class _Watch:
    """When one signal was seen, sample by sample, in model time.

    A signal that is sent on delta is seen between its samples as at every step.
    """

    def __init__(self, blind: float, coded: Coded | None = None) -> None:
        self._held = coded.longest if coded is not None else 0.0
        self._h = coded.h if coded is not None else 1.0
        self._longest = max(blind, self._held)
        self._first: float | None = None
        self._last = 0.0
        self._gaps: list[Span] = []
        self._not_finite = 0
        self._samples = 0

    def saw(self, t: float, value: float) -> None:
        """Take a sample."""
        if not math.isfinite(value):
            self._not_finite += 1
            return
        passed = t - self._last
        if self._first is None:
            self._first = t
        elif passed > self._longest:
            self._gaps.append((self._last, t))
        self._samples += self._steps(passed)
        self._last = t

    def coverage(self, now: float) -> Coverage | None:
        """Return when the signal was seen until ``now``; None where it was not."""
        if self._first is None:
            return None
        gaps = tuple(self._gaps)
        last, samples = self._last, self._samples
        if 0.0 < now - last <= self._held:
            last, samples = now, samples + self._steps(now - last)
        return coverage(self._first, last, gaps, samples, self._not_finite)

    def _steps(self, passed: float) -> int:
        """Return how many samples a sample is worth after so much time."""
        return max(1, round(passed / self._h)) if passed <= self._held else 1


def _is_ours(signal: str) -> bool:
    return any(is_of(name, signal.rpartition('/')[2]) for name in SIGNALS)
