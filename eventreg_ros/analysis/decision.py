# SPDX-License-Identifier: Apache-2.0
"""Event times to a verdict and its reason: one function for bags, simulations and live runs."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from .evidence import Evidence
from .rejection import (
    ENOUGH,
    NOT_REJECTED,
    REJECTED,
    UNDECIDED,
    Outcomes,
    Rejection,
    counted,
    outcomes,
    summed,
)
from .subject import JudgedPlant, Subject

Events = Mapping[str, Sequence[float]]
"""The event times of signals, in model time, increasing."""


@dataclass(frozen=True)
class Decision:
    """The verdict on one plant, or on all of them, and why."""

    verdict: str
    reason: str
    rejection: Rejection


@dataclass(frozen=True)
class PlantDecision(Decision):
    """The verdict on one plant, and what became of its events within the judged span."""

    plant: JudgedPlant
    outcomes: Outcomes


def decide(
    subject: Subject, events: Events, evidence: Evidence, *, lenient: bool = False
) -> tuple[PlantDecision, ...]:
    """Return the verdict on each plant of ``subject``.

    ``lenient`` judges what was seen although the evidence is incomplete.
    """
    return tuple(_judged(p, subject, events, evidence, lenient) for p in subject.plants)


def summary(plants: Sequence[PlantDecision]) -> Decision:
    """Return the verdict on all plants: not rejected if any is, else undecided if any is."""
    if not plants:
        return Decision(UNDECIDED, 'there is no plant to judge', Rejection(0, 0, 0, 0, 0))
    if len(plants) == 1:
        return plants[0]
    verdicts = {each.verdict for each in plants}
    worst = next(v for v in (NOT_REJECTED, UNDECIDED, REJECTED) if v in verdicts)
    words = [f'{p.plant.output}: {p.reason}' for p in plants if p.verdict == worst]
    return Decision(worst, '; '.join(words), summed([p.rejection for p in plants]))


def _judged(
    plant: JudgedPlant, subject: Subject, events: Events, evidence: Evidence, lenient: bool
) -> PlantDecision:
    start, stop = evidence.span
    window = subject.criteria.window
    reference = () if plant.reference is None else events.get(plant.reference, ())
    found = outcomes(events.get(plant.output, ()), reference, start, window, stop)
    disturbance = sum(start <= t <= stop for w in plant.disturbances for t in events.get(w, ()))
    rejection = counted(found, disturbance)
    words = _Words(plant, found, rejection, evidence)
    held = [f.text for f in evidence.withholding(plant.needed)]
    real = _really_spurious(plant, found, evidence, window)
    real += _really_missed(plant, found, evidence, window)
    if rejection.verdict == UNDECIDED:
        verdict, reason = UNDECIDED, words.too_few(subject.criteria.settle)
        reason += f'; {_some(held)}' if held else ''
    elif rejection.verdict == NOT_REJECTED and (lenient or real or not held):
        verdict, reason = NOT_REJECTED, words.not_rejected()
    elif held and not lenient:
        verdict, reason = UNDECIDED, _some(held)
    else:
        verdict, reason = REJECTED, words.rejected()
        reason += f', as far as it was seen: {_some(held)}' if held else ''
    return PlantDecision(verdict, reason, rejection, plant, found)


def _really_spurious(
    plant: JudgedPlant, found: Outcomes, evidence: Evidence, window: float
) -> list[float]:
    """Return the spurious events around which the reference was seen, if there is one."""
    asked = plant.reference
    return [
        t
        for t in found.spurious
        if asked is None or evidence.was_seen(asked, t - window, t + window)
    ]


def _really_missed(
    plant: JudgedPlant, found: Outcomes, evidence: Evidence, window: float
) -> list[float]:
    """Return the events of the reference that y missed although y was seen around them."""
    return [t for t in found.missed if evidence.was_seen(plant.output, t - window, t + window)]


def _some(texts: Collection[str], most: int = 2) -> str:
    shown = list(texts)[:most]
    more = len(texts) - len(shown)
    return '; '.join(shown) + (f'; and {more} more' if more else '')


class _Words:
    """The reasons for the verdicts on one plant."""

    def __init__(
        self, plant: JudgedPlant, found: Outcomes, rejection: Rejection, evidence: Evidence
    ) -> None:
        self._plant, self._found, self._rejection = plant, found, rejection
        self._start, self._stop = evidence.span
        self._w = ' and '.join(plant.disturbances) or 'w'

    def too_few(self, settle: float) -> str:
        n, start = self._rejection.disturbance_events, self._start
        if not self._plant.disturbances:
            return f'nothing disturbs {self._plant.output}: there is no w; add an exosystem'
        if self._stop <= start == settle:
            return f'there is nothing after {start:g}, from when on events count: run longer'
        return f'{count(n, "event")} of {self._w} after {start:g}, {ENOUGH} are needed: run longer'

    def rejected(self) -> str:
        plant, found = self._plant, self._found
        events = count(self._rejection.disturbance_events, 'event')
        words = f'after t = {self._start:g} {self._w} had {events}; '
        if found.preserved:
            asked = count(len(found.preserved), 'event')
            return words + f'{plant.output} had the {asked} of {plant.reference} and no other'
        return words + f'none made {plant.output} spike'

    def not_rejected(self) -> str:
        plant, found = self._plant, self._found
        words = []
        if found.spurious:
            unasked = count(len(found.spurious), 'event')
            words.append(
                f'after t = {self._start:g} {plant.output} had {unasked} that nothing asks for, '
                f'the first at {found.spurious[0]:.1f}'
            )
        if found.missed:
            events = count(len(found.missed), 'event')
            words.append(
                f'{plant.output} missed {events} of {plant.reference}, '
                f'the first at {found.missed[0]:.1f}'
            )
        if found.spurious and plant.stimuli and plant.reference is None:
            v = ' and '.join(plant.stimuli)
            words.append(
                f'stimulus without reference: events that {v} asks for count as spurious; add '
                '`reference:` to the file'
            )
        return '; '.join(words)


def count(n: int, what: str) -> str:
    """Return a number of things in words: 1 event, 2 events."""
    return f'{n} {what}{"" if n == 1 else "s"}'
