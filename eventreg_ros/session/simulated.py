# SPDX-License-Identifier: Apache-2.0
"""A scenario simulated and judged: what ``eventreg simulate`` does, for Python."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from ..analysis.changes import Change, changes_asked
from ..analysis.signal import Signal, Signals
from ..analysis.subject import subject_of
from ..analysis.verdict import Report
from ..analysis.verdict import judge as judge_signals
from ..bags.changes import node_switched, parameter_set
from ..bags.writer import write_bag
from ..errors import EventregError
from ..models.model import output_beside
from ..runtime.tick_grid import TickGrid
from ..scenario import Criteria, Scenario
from ..scenario.criteria import need_span
from ..scenario.interventions import Intervention, need_before, read_all, turns
from ..scenario.links import need_linked
from ..simulation.continuous import simulate as simulate_continuous
from ..simulation.impairment import Impairment
from ..simulation.loop import Loop
from ..simulation.model_time import steps_of
from ..simulation.noise import Noise
from ..simulation.sampled import simulate_sampled
from ..simulation.trajectory import Array, Trajectory
from .judged import Judged

FINE = 0.02
"""Model time between the samples in which a continuous run's events are looked for, at most."""


@dataclass(frozen=True, repr=False)
class Run(Judged):
    """A simulated scenario.

    ``t`` has shape (n,), in model time, every time_scale / rate from 0; so has each of ``signals``,
    the outputs of the blocks and of the stimulus by name, which ``run['y']`` reads as well.
    """

    scenario: Scenario
    t: Array
    signals: Mapping[str, Array]
    fine: Trajectory
    """The grid in which events are looked for; in a sampled run the same."""
    interventions: tuple[Intervention, ...] = ()
    """What was changed during the run, in the order and at the model times at which it acted."""
    messages: Mapping[str, int] = field(default_factory=dict)
    """In how many messages each signal was sent; empty for a continuous system."""

    @property
    def changes(self) -> tuple[Change, ...]:
        """What was changed during the run, in words."""
        return changes_asked(self.interventions)

    @cached_property
    def report(self) -> Report:
        """The verdict and everything behind it, by the scenario's criteria."""
        return self.judged_by()

    @property
    def criteria(self) -> Criteria:
        """By what it is judged."""
        return self.scenario.criteria

    def over_time(self) -> Signals:
        """Return the signals with their model times."""
        return {name: Signal(self.t, x) for name, x in self.signals.items()}

    def judged_by(
        self,
        settle: float | None = None,
        window: float | None = None,
        *,
        blind: float | None = None,
        until: float | None = None,
    ) -> Report:
        """Return the report by other criteria; see :func:`.judged.judge`."""
        subject = subject_of(self.scenario, self.signals)
        criteria = subject.criteria.overridden(settle=settle, window=window, blind=blind)
        need_span(criteria, float(self.t[-1]), settle=settle, until=until)
        signals = {name: Signal(self.fine.t, x) for name, x in self.fine.signals.items()}
        wanted = replace(subject, criteria=criteria)
        report = judge_signals(
            signals, wanted, until=until, changes=self.changes, counts=self.messages
        )
        coarse = {  # the fine grid is for the events alone
            name: replace(signal, samples=len(self.t)) for name, signal in report.signals.items()
        }
        return replace(report, signals=coarse)

    def to_bag(
        self,
        path: str | Path,
        storage: str = 'mcap',
        *,
        settle: float | None = None,
        window: float | None = None,
        blind: float | None = None,
    ) -> None:
        """Write a rosbag2, as a recorder would: signals, scenario, and what was changed.

        ``settle``, ``window`` and ``blind`` replace the scenario's in the bag. Raises BagError.
        """
        stamps = TickGrid(self.scenario.rate).stamps(len(self.t))
        scenario = self.scenario.with_criteria(settle=settle, window=window, blind=blind)
        changes = []
        for each in self.interventions:
            stamp = round(each.at / self.scenario.time_scale * 1e9)
            if each.action == 'set':
                written = parameter_set(stamp, each.node, each.parameter, each.value)
            else:
                written = node_switched(each.node, each.action)
            changes.append((stamp, written))
        signals = {name: (stamps, x) for name, x in self.signals.items()}
        write_bag(path, signals, scenario.name, scenario.to_yaml(), storage, changes)


def simulate(
    scenario: Scenario,
    duration: float | None = None,
    *,
    sampled: bool = False,
    delay: float = 0.0,
    loss: float = 0.0,
    jitter: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
    on: Collection[str] | None = None,
    at: Sequence[str] = (),
) -> Run:
    """Simulate a scenario over ``duration`` of model time.

    The default is 400, or 300 after settling if that is longer. The loop is one continuous system,
    or ``sampled``: sample by sample as the nodes do it in lockstep, each link with ``delay`` and
    ``jitter`` (model time) and ``loss`` (probability), drawn from ``seed``; ``on`` names the
    signals whose links are impaired (None: all). White ``noise`` of that standard deviation, drawn
    from ``seed`` too, is added to every sample of each plant's output: a sampled loop hears it, a
    continuous one is only judged through it. ``at`` holds interventions as texts
    ``T:NODE.PARAM:=VALUE``, ``T:NODE:activate`` or ``T:NODE:deactivate``, T in model time, before
    the end. Raises EventregError when the loop cannot be simulated or the state stops being finite.
    """
    if duration is None:
        duration = scenario.criteria.duration(400.0)
    if not sampled and (delay or loss or jitter or on or (seed and not noise)):
        raise EventregError(
            f'delay, loss, jitter, seed and on belong to a sampled simulation, got '
            f'{delay:g}, {loss:g}, {jitter:g}, {seed} and {on}; add sampled=True'
        )
    added = Noise(noise, seed, tuple(plant.output for plant in subject_of(scenario).plants))
    asked = read_all(at, scenario)
    need_before(duration, asked, 'of model time')
    loop, done = scenario.loop, turns(asked, scenario)
    if sampled:
        links = None if on is None else frozenset(on)
        impairment = Impairment(delay, loss, jitter, seed, need_linked(loop, links))
        found = simulate_sampled(loop, duration, impairment, done, noise=added)
        acted = tuple(_on_grid(each, loop) for each in asked)
        return Run(scenario, found.t, found.signals, found, acted, _messages(found))
    time_scale, rate = loop.grid
    every = max(math.ceil(time_scale / rate / FINE - 1e-9), 1)
    fine = loop.sampled_at(every * rate)
    found = simulate_continuous(fine, duration, turns=done)
    coarse = {name: x[::every] for name, x in found.signals.items()}
    t = found.t[::every]
    for name, draws in added.draw(len(t)):
        coarse[name] = coarse[name] + draws
    return Run(scenario, t, coarse, Trajectory(t, coarse) if noise else found, tuple(asked))


def _on_grid(each: Intervention, loop: Loop) -> Intervention:
    """Return an intervention at the model time of the sample at which it acts in a sampled loop."""
    time_scale, rate = loop.grid
    return each._replace(at=steps_of(each.at, time_scale / rate) * time_scale / rate)


def _messages(found: Trajectory) -> dict[str, int]:
    """Return in how many messages each signal was sent, what goes beside an output with it."""
    sent = dict.fromkeys(found.signals, len(found.t)) | dict(found.messages)
    beside = {name: output_beside(name, found.signals) for name in found.signals}
    return {name: sent[beside[name] or name] for name in found.signals}
