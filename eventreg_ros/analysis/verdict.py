# SPDX-License-Identifier: Apache-2.0
"""The verdict on a run, recorded or simulated: one report, from signals and what is judged."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bags.finding import Finding
from ..errors import EventregError
from ..models.model import output_beside
from ..printed import Printed
from .changes import Change
from .decision import Decision, PlantDecision, decide, summary
from .events import Risen, Rises, ending, rises
from .evidence import Coverage, Evidence, coverage_of, gather
from .learning import Learned, after, learned
from .learning import findings as learning_findings
from .rejection import NOT_REJECTED, REJECTED, UNDECIDED, Outcomes, Rejection
from .signal import NOTHING, Signal, Signals, Size, Span, difference, ordered, size, together, total
from .subject import JudgedPlant, Subject
from .timing import Timing

EXIT_CODES = {REJECTED: 0, NOT_REJECTED: 1, UNDECIDED: 3}
"""What run, simulate and analyze exit with, by verdict."""


@dataclass(frozen=True)
class SignalSummary:
    """One signal: its samples, its finite range, the model times of its events in the whole run."""

    samples: int
    """How many there are; of a recorded signal, in how many messages it came."""
    min: float | None
    max: float | None
    events: tuple[float, ...]
    timing: Timing | None = None
    """How regularly it came, where it was recorded."""
    messages: int | None = None
    """In how many messages it was sent; None where nothing was, as in a continuous system."""
    energy: float | None = None
    """Of a control that was sent: the integral of its square over the run (model time)."""


@dataclass(frozen=True)
class PlantReport:
    """One plant: the verdict on it, why, and the figures within the judged span."""

    plant: JudgedPlant
    verdict: str
    reason: str
    rejection: Rejection
    outcomes: Outcomes
    residual: Size
    synchronisation: Size


@dataclass(frozen=True, repr=False)
class Report(Printed):
    """The report on a run, which ``print`` shows as a table; all times are model time.

    ``duration`` is that of the recording. ``rejection`` holds the sums over the plants.
    """

    subject: Subject
    duration: float
    verdict: str
    reason: str
    evidence: Evidence
    rejection: Rejection
    residual: Size
    synchronisation: Size
    plants: tuple[PlantReport, ...]
    signals: Mapping[str, SignalSummary]
    learned: tuple[Learned, ...] = ()
    changes: tuple[Change, ...] = ()
    """What was changed while the run went on."""

    def __repr__(self) -> str:
        return f'<Report on {self.scenario}: {self.verdict}; {self.reason}>'

    def __str__(self) -> str:
        from .report_table import table

        return table(self)

    @property
    def scenario(self) -> str:
        """The name of the scenario."""
        return self.subject.scenario

    @property
    def time_scale(self) -> float:
        """Model time units per second."""
        return self.subject.time_scale

    @property
    def settle(self) -> float:
        """From when on events count."""
        return self.evidence.span[0]

    @property
    def exit_code(self) -> int:
        """What a command exits with that gives this verdict."""
        return EXIT_CODES[self.verdict]


def judge(
    signals: Signals,
    subject: Subject,
    *,
    until: float | None = None,
    findings: Sequence[Finding] = (),
    lenient: bool = False,
    timings: Mapping[str, Timing] | None = None,
    counts: Mapping[str, int] | None = None,
    changes: Sequence[Change] = (),
) -> Report:
    """Return the report on ``signals``, by name, of a run of ``subject``.

    Judged is what lies from the subject's ``settle`` to ``until`` (None: the end). ``findings``
    are a reader's, with ``at`` in model time; ``lenient`` judges what was seen although they say
    that something is missing. ``counts`` are the messages in which signals were sent.
    ``changes``, in model time, are noted. Raises EventregError when there is no output of a plant
    to judge.
    """
    _need_outputs(signals, subject)
    criteria = subject.criteria
    end = max(float(t[-1]) for t, _ in signals.values() if len(t))
    span = (criteria.settle, max(criteria.settle, end if until is None else until))
    found = {name: rises(t, x, *criteria.detector[:2]) for name, (t, x) in signals.items()}
    events = {
        name: [] if output_beside(name, signals) else _events(each, subject)
        for name, each in found.items()
    }
    evidence = evidence_of(signals, found, subject, span, end, findings)
    plants = decide(subject, events, evidence, lenient=lenient)
    reports = tuple(_report(each, signals, span) for each in plants)
    decision: Decision = summary(plants)
    learners = after(subject.learners, changes)
    found_out = learned(signals, learners)
    said = learning_findings(learners, found_out, decision.rejection.spurious)
    evidence = replace(evidence, warnings=(*evidence.warnings, *said))
    given, sent = timings or {}, counts or {}
    controls = {u for each in plants for u in each.plant.controls}
    return Report(
        subject=subject,
        duration=end,
        verdict=decision.verdict,
        reason=decision.reason,
        evidence=evidence,
        rejection=decision.rejection,
        residual=together([each.residual for each in reports]),
        synchronisation=together([each.synchronisation for each in reports]),
        plants=reports,
        signals={
            name: replace(
                _summary(signals[name], events[name], given.get(name), sent.get(name)),
                energy=_energy(signals[name]) if name in controls & sent.keys() else None,
            )
            for name in ordered(signals)
        },
        learned=found_out,
        changes=tuple(changes),
    )


def evidence_of(
    signals: Signals,
    found: Mapping[str, Rises],
    subject: Subject,
    span: Span,
    end: float,
    findings: Sequence[Finding] = (),
) -> Evidence:
    """Return the evidence for a verdict on ``span`` of a run that ends at ``end``.

    ``found`` are the rises of its signals, ``findings`` a reader's; times are model time.
    """
    blind = subject.criteria.blind
    coverage = {name: _coverage(signals, name, blind) for name in subject.needed}
    compared = {name for plant in subject.plants for name in plant.compared}
    risen = {
        name: _risen(signals[name], each, subject, span if name in compared else None)
        for name, each in found.items()
    }
    return gather(subject, coverage, span, end, findings, risen)


def _need_outputs(signals: Signals, subject: Subject) -> None:
    plants = subject.plants or (JudgedPlant('y'),)
    missing = [p.output for p in plants if not len(signals.get(p.output, NOTHING)[0])]
    if not missing:
        return
    found = ', '.join(name for name in ordered(signals) if len(signals[name][0])) or 'none'
    raise EventregError(
        f"no samples of {missing[0]}, the plant's output, to judge "
        f'(signals found: {found}); record or remap it'
    )


def _events(found: Rises, subject: Subject) -> list[float]:
    limits = subject.criteria
    times: list[float] = found.start[found.events(limits.refractory, limits.min_width)].tolist()
    return times


def _risen(signal: Signal, found: Rises, subject: Subject, span: Span | None) -> Risen:
    """Return how a signal was above; how it was at the end of ``span``, if that matters."""
    longest = float(found.width.max(initial=0.0))
    if span is None:
        return Risen(longest, None)
    return Risen(longest, *ending(signal, subject.criteria.threshold, span[1]))


def _coverage(signals: Signals, name: str, blind: float) -> Coverage | None:
    return coverage_of(Signal(*signals[name]), blind) if name in signals else None


def _report(decision: PlantDecision, signals: Signals, span: Span) -> PlantReport:
    plant = decision.plant
    return PlantReport(
        plant,
        decision.verdict,
        decision.reason,
        decision.rejection,
        decision.outcomes,
        size(residual(signals, plant), span),
        size(synchronisation(signals, plant), span),
    )


def _summary(
    signal: Signal, events: Sequence[float], timing: Timing | None, count: int | None
) -> SignalSummary:
    t, x = signal
    finite = x[np.isfinite(x)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (math.nan, math.nan)
    known = len(finite) > 0
    return SignalSummary(
        count if timing is not None and count is not None else len(t),  # read, not made
        low if known else None,
        high if known else None,
        tuple(events),
        timing,
        count,
    )


def _energy(signal: Signal) -> float | None:
    """Return the integral of the square of a signal, None where it is not known."""
    t, x = signal
    rms = size(Signal(t, x), (-math.inf, math.inf)).rms
    energy = math.nan if rms is None else rms * rms * float(t[-1] - t[0])
    return energy if math.isfinite(energy) else None


def residual(signals: Signals, plant: JudgedPlant) -> Signal:
    """Return the output of ``plant`` less its reference, or the output where there is none."""
    y = total(signals, (plant.output,))
    y_r = total(signals, () if plant.reference is None else (plant.reference,))
    return difference(y, y_r) if len(y_r.t) else y


def synchronisation(signals: Signals, plant: JudgedPlant) -> Signal:
    """Return what exosystems and controllers leave together, w less u, as the plant plays it.

    At the times of the first w; n = 0 where a signal of them is missing.
    """
    acting = total(signals, plant.controls)
    played = Signal(acting.t + plant.lead, acting.x)
    return difference(total(signals, plant.disturbances), played)
