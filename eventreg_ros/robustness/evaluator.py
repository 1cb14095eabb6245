"""A scenario put to the test: the verdict on sampled simulations under delay, loss and jitter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..analysis.criteria import SETTLE, WINDOW
from ..analysis.verdict import judge
from ..errors import EventregError
from ..scenario import Scenario
from ..simulation.impairment import PERFECT, Impairment
from ..simulation.sampled import SampledLoop
from ..simulation.trajectory import Array

JUDGED = ('w', 'y', 'y_r')
"""The signals that decide the verdict."""


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
        self._scenario, self._setting = scenario, setting
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
            return 'not rejected'
        threshold, reset = self._scenario.monitor
        signals = {s: run.signals[s] for s in JUDGED if s in run.signals}
        report = judge(
            {s: keep_crossings(run.t, x, threshold, reset) for s, x in signals.items()},
            scenario=self._scenario.name,
            time_scale=self._scenario.time_scale,
            threshold=threshold,
            reset=reset,
            settle=self._setting.settle,
            window=self._setting.window,
        )
        return str(report['verdict'])

    def rejected(self, impairment: Impairment) -> bool:
        """Say whether every seed is rejected; it stops at the first that is not."""
        return all(self._runs(impairment))

    def share(self, impairment: Impairment) -> float:
        """Return the part of the seeds that are rejected, 0 to 1."""
        runs = list(self._runs(impairment))
        return sum(runs) / len(runs)

    def _runs(self, impairment: Impairment) -> Iterator[bool]:
        for seed in range(self._setting.seeds if impairment.random else 1):
            yield self.verdict(replace(impairment, seed=seed)) == 'rejected'


def keep_crossings(t: Array, x: Array, threshold: float, reset: float) -> tuple[Array, Array]:
    """Return the few samples of a signal that have its events, all of them, at the same times.

    The detector asks of a sample whether it is at or below ``reset`` and whether it has reached
    ``threshold``; where neither answer changes from one sample to the next, nothing happens. So the
    first sample and those on both sides of each change will do. Arrays of shape (n,), all finite.
    """
    answer = (x > reset).astype(np.int8) + (x >= threshold)
    change = np.flatnonzero(np.diff(answer))
    keep = np.unique(np.concatenate(([0], change, change + 1)))
    return t[keep], x[keep]
