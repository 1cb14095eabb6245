# SPDX-License-Identifier: Apache-2.0
"""A scenario put to the test: the verdict on sampled simulations under delay, loss and jitter."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace

from ..analysis.rejection import NOT_REJECTED, REJECTED
from ..analysis.subject import subject_of
from ..errors import EventregError, ModelError
from ..scenario import Scenario
from ..scenario.criteria import SEEDS, SETTLE, WINDOW
from ..simulation.impairment import PERFECT, Impairment
from ..simulation.lanes import Start
from ..simulation.lanes_source import LANES
from ..simulation.sampled import SampledLoop
from .lane_group import Template
from .lane_run import lanes_can, run_alike
from .outcome import VERDICTS, judged

FEW = 4 * LANES
"""Runs up to which all seeds are run at once; beyond, only those of values that pass the first."""


@dataclass(frozen=True)
class Setting:
    """How a scenario is put to the test; times are in model time.

    Random impairments are tried with each seed from 0 to ``seeds`` - 1. ``rate`` (steps per
    second) is that of all simulations; None leaves it to the question.
    """

    duration: float = 400.0
    settle: float = SETTLE
    window: float = WINDOW
    seeds: int = SEEDS
    rate: float | None = None

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        *,
        duration: float | None = None,
        settle: float | None = None,
        window: float | None = None,
        seeds: int = SEEDS,
        rate: float | None = None,
    ) -> Setting:
        """Return the setting that ``scenario`` asks for, except what is given."""
        limits = scenario.criteria.overridden(settle=settle, window=window)
        usual = limits.duration(400.0)
        return cls(duration or usual, limits.settle, limits.window, seeds, rate)


class Evaluator:
    """A scenario with one hold on all its blocks, at one rate, run again and again.

    ``on``: the one signal, or those, whose links are impaired, None for all. ``led``: the lead of a
    loop that predicts is set to cover delay and jitter. Raises EventregError when the scenario
    cannot be simulated.
    """

    def __init__(
        self,
        scenario: Scenario,
        hold: str,
        rate: float,
        setting: Setting,
        on: str | tuple[str, ...] | None = None,
        *,
        led: bool = False,
    ) -> None:
        loop = scenario.loop.sampled_at(rate, hold)
        self._loop = SampledLoop(loop)
        self._setting, self.led = setting, led
        self.predicts = loop.predicts
        self.lead = max((spec.lead for spec in loop.blocks.values()), default=0.0)
        """The lead of the scenario, model time."""
        subject = subject_of(scenario, self._loop.signals)
        if not subject.plants:
            raise EventregError(f'scenario {scenario.name} has no plant to judge; name one')
        criteria = subject.criteria.overridden(settle=setting.settle, window=setting.window)
        self._subject = replace(subject, criteria=criteria)
        self.hold, self.rate, self.h = hold, rate, self._loop.h
        self.seeds = setting.seeds
        self.on = on
        listened = {signal for _, signal in self._loop.links}
        self.linked = [signal for signal in self._loop.signals if signal in listened]
        """The signals that some block listens to."""
        steps = self._loop.steps(setting.duration)
        self._known: dict[Impairment, str] = {}
        self._template = Template(loop, self._subject, setting.duration)
        self._in_lanes = lanes_can(loop, steps, self._subject)

    def on_only(self, on: str | tuple[str, ...] | None) -> Evaluator:
        """Return the same with the links of ``on`` impaired; what one of them has run, all know."""
        other = copy(self)
        other.on = on
        return other

    @property
    def family(self) -> int | None:
        """What those have in common that can run side by side; None: each must run by itself."""
        return id(self._known) if self._in_lanes else None

    def prepare(self, impairments: Iterable[Impairment], *, shares: bool = False) -> None:
        """Run what will be asked for, all at once, where runs can go side by side.

        That is what :meth:`rejected` asks for, or with ``shares`` what :meth:`share` does.
        """
        prepare([(self, each) for each in impairments], shares=shares)

    def run(self, wanted: Iterable[Impairment]) -> None:
        """Run all that is not known, side by side; what fails is left to :meth:`verdict`."""
        wanted = [each for each in dict.fromkeys(wanted) if each not in self._known]
        if wanted:
            blocks = list(self._template.loop.blocks.values())
            found = run_alike(self._template, Start.of([blocks]).times(len(wanted)), wanted)
            words = [VERDICTS[i] or NOT_REJECTED for i in found.rows['verdict'].tolist()]
            known = dict(zip(wanted, words, strict=True))
            if self._template.loop.foreign_models:  # what failed is run again, by itself
                for i in found.reasons:
                    del known[wanted[i]]
            self._known.update(known)

    def knows_rejected(self, run: Impairment) -> bool:
        """Say whether a run of these links has been seen to be rejected."""
        return self._known.get(run) == REJECTED

    def _on(self, impairment: Impairment) -> Impairment:
        if self.on is None:
            return impairment
        return replace(impairment, on=frozenset([self.on] if isinstance(self.on, str) else self.on))

    def verdict(self, impairment: Impairment = PERFECT) -> str:
        """Return the verdict on one run; when its state leaves all bounds, ``not rejected``."""
        impairment = self._on(impairment)
        if (known := self._known.get(impairment)) is not None:
            return known
        try:
            run = self._loop_for(impairment).run(self._setting.duration, impairment)
        except ModelError:
            raise
        except EventregError:  # all else that it may complain of was checked at the start
            return NOT_REJECTED
        return VERDICTS[int(judged(run, self._subject)['verdict'])]

    def _loop_for(self, impairment: Impairment) -> SampledLoop:
        if not self.led:
            return self._loop
        lead = impairment.delay + impairment.jitter
        return SampledLoop(self._template.loop.led_by(lead))

    def rejected(self, impairment: Impairment) -> bool:
        """Say whether every seed is rejected; it stops at the first that is not."""
        return all(self._runs(impairment))

    def share(self, impairment: Impairment) -> float:
        """Return the part of the seeds that are rejected, 0 to 1."""
        runs = list(self._runs(impairment))
        return sum(runs) / len(runs)

    def _runs(self, impairment: Impairment) -> Iterator[bool]:
        for seeded in self._seeds(impairment):
            yield self.verdict(seeded) == REJECTED

    def _seeds(self, impairment: Impairment) -> list[Impairment]:
        seeds = range(self.seeds if impairment.random else 1)
        return [replace(impairment, seed=seed) for seed in seeds]

    def runs_of(self, impairment: Impairment) -> list[Impairment]:
        """Return what is run for an impairment: with each seed, on the links that are impaired."""
        return self._seeds(self._on(impairment))


def prepare(asked: Sequence[tuple[Evaluator, Impairment]], *, shares: bool = False) -> None:
    """Run what evaluators of one family will be asked for; see :meth:`Evaluator.prepare`."""
    if not asked or asked[0][0].family is None:
        return
    run, known = asked[0][0].run, asked[0][0].knows_rejected
    runs = [each.runs_of(impairment) for each, impairment in asked]
    if not shares and sum(map(len, runs)) > FEW:
        run(first for first, *_ in runs)
        runs = [seeds for seeds in runs if known(seeds[0])]
    run(each for seeds in runs for each in seeds)
