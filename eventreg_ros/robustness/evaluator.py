"""A scenario put to the test: the verdict on sampled simulations under delay, loss and jitter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..analysis.criteria import SETTLE, WINDOW
from ..analysis.verdict import judge
from ..errors import EventregError
from ..scenario import Scenario
from ..simulation.sampled import Network
from ..simulation.trajectory import Array
from ..simulation.wiring import count_steps

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
        blocks, stimulus, v = scenario.loop
        blocks = {name: replace(spec, hold=hold, rate=rate) for name, spec in blocks.items()}
        self._network = Network(blocks, stimulus, stimulus_output=v)
        self._scenario, self._setting = scenario, setting
        self.hold, self.rate, self.h = hold, rate, self._network.h
        self.on = on
        listened = {signal for _, signal in self._network.links}
        self.linked = [signal for signal in self._network.signals if signal in listened]
        """The signals that some block listens to."""
        count_steps(setting.duration, self.h)

    def verdict(
        self, *, delay: float = 0.0, loss: float = 0.0, jitter: float = 0.0, seed: int = 0
    ) -> str:
        """Return the verdict on one run; when its state leaves all bounds, ``not rejected``.

        ``delay`` and ``jitter`` are in model time, ``loss`` is a probability; see Network.run.
        """
        try:
            run = self._network.run(
                self._setting.duration,
                delay=delay,
                loss=loss,
                jitter=jitter,
                seed=seed,
                on=None if self.on is None else [self.on],
            )
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

    def rejected(self, **impairments: float) -> bool:
        """Say whether every seed is rejected; it stops at the first that is not."""
        return all(self._runs(impairments))

    def share(self, **impairments: float) -> float:
        """Return the part of the seeds that are rejected, 0 to 1."""
        runs = list(self._runs(impairments))
        return sum(runs) / len(runs)

    def _runs(self, impairments: Mapping[str, float]) -> Iterator[bool]:
        random = impairments.get('loss') or impairments.get('jitter')
        for seed in range(self._setting.seeds if random else 1):
            delay, loss, jitter = (impairments.get(n, 0.0) for n in ('delay', 'loss', 'jitter'))
            yield self.verdict(delay=delay, loss=loss, jitter=jitter, seed=seed) == 'rejected'


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
