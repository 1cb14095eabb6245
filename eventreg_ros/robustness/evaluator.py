"""A scenario put to the test: the verdict on sampled simulations under delay, loss and jitter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..analysis.decision import decide, summary
from ..analysis.events import detect
from ..analysis.evidence import complete
from ..analysis.rejection import NOT_REJECTED, REJECTED
from ..analysis.subject import subject_of
from ..errors import EventregError
from ..scenario import Scenario
from ..scenario.criteria import SETTLE, WINDOW
from ..simulation.impairment import PERFECT, Impairment
from ..simulation.sampled import SampledLoop


@dataclass(frozen=True)
class Setting:
    """How a scenario is put to the test; times are in model time.

    Random impairments are tried with each seed from 0 to ``seeds`` - 1. ``rate`` (steps per
    second) is that of all simulations; None leaves it to the question.
    """

    duration: float = 400.0
    settle: float = SETTLE
    window: float = WINDOW
    seeds: int = 5
    rate: float | None = None

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        *,
        duration: float | None = None,
        settle: float | None = None,
        window: float | None = None,
        seeds: int = 5,
        rate: float | None = None,
    ) -> Setting:
        """Return the setting that ``scenario`` asks for, but for what is given."""
        limits = scenario.criteria.overridden(settle=settle, window=window)
        usual = limits.duration(400.0)
        return cls(duration or usual, limits.settle, limits.window, seeds, rate)


class Evaluator:
    """A scenario with one hold on all its blocks, at one rate, run again and again.

    ``on``: the one signal whose links are impaired, None for all. Raises EventregError when the
    scenario cannot be simulated.
    """

    def __init__(
        self,
        scenario: Scenario,
        hold: str,
        rate: float,
        setting: Setting,
        on: str | None = None,
    ) -> None:
        self._loop = SampledLoop(scenario.loop.sampled_at(rate, hold))
        self._setting = setting
        subject = subject_of(scenario, self._loop.signals)
        if not subject.plants:
            raise EventregError(f'scenario {scenario.name} has no plant to judge; name one')
        criteria = subject.criteria.overridden(settle=setting.settle, window=setting.window)
        self._subject = replace(subject, criteria=criteria)
        self.hold, self.rate, self.h = hold, rate, self._loop.h
        self.on = on
        listened = {signal for _, signal in self._loop.links}
        self.linked = [signal for signal in self._loop.signals if signal in listened]
        """The signals that some block listens to."""
        self._loop.steps(setting.duration)

    def verdict(self, impairment: Impairment = PERFECT) -> str:
        """Return the verdict on one run; when its state leaves all bounds, ``not rejected``."""
        if self.on is not None:
            impairment = replace(impairment, on=frozenset([self.on]))
        try:
            run = self._loop.run(self._setting.duration, impairment)
        except EventregError:  # all else that it may complain of was checked at the start
            return NOT_REJECTED
        limits = self._subject.criteria.detector
        events = {s: detect(run.t, run.signals[s], *limits) for s in self._subject.needed}
        evidence = complete(self._setting.settle, float(run.t[-1]))
        return summary(decide(self._subject, events, evidence)).verdict

    def rejected(self, impairment: Impairment) -> bool:
        """Say whether every seed is rejected; it stops at the first that is not."""
        return all(self._runs(impairment))

    def share(self, impairment: Impairment) -> float:
        """Return the part of the seeds that are rejected, 0 to 1."""
        runs = list(self._runs(impairment))
        return sum(runs) / len(runs)

    def _runs(self, impairment: Impairment) -> Iterator[bool]:
        for seed in range(self._setting.seeds if impairment.random else 1):
            yield self.verdict(replace(impairment, seed=seed)) == REJECTED
