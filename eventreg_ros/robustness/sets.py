# SPDX-License-Identifier: Apache-2.0
"""Sets of values made into runs: quickly where only numbers of blocks change, else one by one."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..errors import EventregError
from ..models import first_state
from ..scenario import Scenario
from ..scenario.hint import hint
from ..scenario.links import need_linked
from ..simulation.block import BlockSpec
from ..simulation.impairment import Impairment
from ..simulation.lanes import Start, first_output
from ..simulation.model_errors import ANYTHING, in_words
from ..simulation.model_time import count_steps
from ..simulation.noise import Noise
from .axes import Array
from .imperfections import Imperfect, Imperfections
from .lane_group import Template, packed
from .lane_run import lanes_can, run, run_alike
from .outcome import Case, Outcomes, nothing
from .places import in_force, places_of, plain
from .plan import Plan
from .setting import set_value


class Sets:
    """Runs the sets of a plan: values of its axes, any number of them at a time."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.axes = plan.axes
        self._scenario, self._subject = plan.scenario, plan.subject
        self._loop, self._imperfect = self._scenario.loop, Imperfect(plan)
        self._of_nodes = [i for i, axis in enumerate(self.axes) if not axis.of_run]
        self._fixed = [plan.fixed_after(axis) for axis in self.axes]
        places = [places_of(self._scenario, self.axes[i], self._fixed[i]) for i in self._of_nodes]
        self._places = in_force(places) if self.in_lanes else None

    @property
    def in_lanes(self) -> bool:
        """Whether sets go side by side; else one by one."""
        time_scale, rate = self._loop.grid
        steps = count_steps(self.plan.duration, time_scale / rate)
        return lanes_can(self._loop, steps, self._subject)

    def run(self, columns: Sequence[Array], pool: ThreadPoolExecutor | None = None) -> Outcomes:
        """Return the outcomes of the sets with these values, one array of shape (n,) per axis."""
        with in_words(self._loop.foreign_models):
            return self._run(columns, pool)

    def _run(self, columns: Sequence[Array], pool: ThreadPoolExecutor | None) -> Outcomes:
        count = len(columns[0]) if columns else 1
        reasons, of_links = self._refused(columns), dict[int, str]()
        around = self._imperfect.of(columns, count, of_links)
        for i in of_links if self._places is None else ():
            try:
                self.scenario([column[i] for column in columns])
            except EventregError as error:
                reasons[i] = str(error)
        reasons = of_links | reasons
        good = [i for i in range(count) if i not in reasons]
        rows = nothing(count)
        if good:
            chosen = [column[good] for column in columns]
            quick = self._quick if self._places is not None else self._slow
            found = quick(chosen, len(good), around.of(good), pool)
            rows[good] = found.rows
            reasons |= {good[i]: reason for i, reason in found.reasons.items()}
        return Outcomes(rows, dict(sorted(reasons.items())))

    # Rules

    def _refused(self, columns: Sequence[Array]) -> dict[int, str]:
        """Return by its place why a set is refused, as far as one value alone decides it."""
        reasons: dict[int, str] = {}
        if self._places is None:
            return reasons  # each set is checked as a whole
        pairs = zip(self._of_nodes, self._places, strict=True)
        every = [(place, columns[i]) for i, places in pairs for place in places]
        for place, column in sorted(every, key=lambda pair: pair[0].rank):
            for at in np.flatnonzero(~place.allowed(column)).tolist():
                reasons.setdefault(at, place.complaint(column[at]))
        return reasons

    # Runs

    def _quick(
        self,
        columns: Sequence[Array],
        count: int,
        around: Imperfections,
        pool: ThreadPoolExecutor | None,
    ) -> Outcomes:
        specs = list(self._loop.blocks.values())
        x = [np.tile(np.array(spec.x0, dtype=np.float64), (count, 1)) for spec in specs]
        params = [np.tile(np.array(tuple(spec.params)), (count, 1)) for spec in specs]
        for i, places in zip(self._of_nodes, self._places or (), strict=True):
            for place in places:
                (x if place.of_state else params)[place.block][:, place.slot] = columns[i]
        try:
            outputs = [_outputs(*each) for each in zip(specs, x, params, strict=True)]
        except ANYTHING:
            if not self._loop.foreign_models:
                raise
            return self._slow(columns, count, around, pool)  # which says it set by set
        template = Template(self._loop, self._subject, self.plan.duration)
        return run_alike(template, Start(x, params, outputs), *around, pool=pool)

    def _slow(
        self,
        columns: Sequence[Array],
        count: int,
        around: Imperfections,
        pool: ThreadPoolExecutor | None,
    ) -> Outcomes:
        cases, good, reasons = [], [], dict[int, str]()
        for i in range(count):
            try:
                scenario = self.scenario([column[i] for column in columns])
                cases.append(self._case(scenario, *around.at(i)))
            except EventregError as error:
                reasons[i] = str(error)
                continue
            good.append(i)
        rows, found = nothing(count), run(cases, pool)
        rows[good] = found.rows
        return Outcomes(rows, reasons | {good[i]: text for i, text in found.reasons.items()})

    def _case(self, scenario: Scenario, impairment: Impairment, noise: Noise) -> Case:
        """Return a set as a case. Raises EventregError where it is refused."""
        _ = scenario.rate, scenario.time_scale  # raises unless all nodes agree
        loop, subject = scenario.loop, self.plan.subject_of(scenario)
        need_linked(loop, impairment.on)
        for signal in noise.on:
            if signal not in loop.signals:
                raise EventregError(
                    f'noise.{signal}: nobody publishes it{hint(signal, loop.signals)}'
                )
        return Case(loop, impairment, subject, self.plan.duration, noise)

    def scenario(self, values: Sequence[Any]) -> Scenario:
        """Return the scenario with one value per axis. Raises EventregError where it is refused."""
        given = {node: dict(has) for node, has in self._scenario.given.items()}
        for i in self._of_nodes:
            set_value(self._scenario, given, self.axes[i], plain(values[i]))
            for later in self._fixed[i]:
                later.apply(given, ())
        return Scenario.of(self._scenario.name, given)

    def imperfections(self, values: Sequence[Any]) -> tuple[Impairment, Noise]:
        """Return what happens on the links and what is added to outputs, one value per axis."""
        return self._imperfect.of([np.array([value]) for value in values], 1).at(0)


def _outputs(spec: BlockSpec, x: Array, params: Array) -> Array:
    """Return the outputs of a block at the start of sets, shape (n,)."""
    if spec.model.output is first_state:
        return np.array(x[:, 0])
    pairs = zip(x.tolist(), params.tolist(), strict=True)
    return np.array([first_output(spec, tuple(s), packed(spec, p)) for s, p in pairs])
