# SPDX-License-Identifier: Apache-2.0
"""Sets of values made into runs: quickly where only numbers of blocks change, else one by one."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..errors import EventregError
from ..models import Model, first_state
from ..scenario import Scenario
from ..scenario.hint import hint
from ..scenario.links import need_linked
from ..scenario.parameters import has, is_foreign, parameters_of
from ..scenario.reader import Override
from ..simulation.block import BlockSpec
from ..simulation.impairment import Impairment
from ..simulation.lanes import Start, first_output
from ..simulation.model_errors import ANYTHING, in_words
from ..simulation.model_time import count_steps
from ..simulation.noise import Noise
from .axes import Array, Axis
from .imperfections import Imperfect, Imperfections
from .lane_group import Template, packed
from .lane_run import lanes_can, run, run_alike
from .outcome import Case, Outcomes, nothing
from .plan import Plan


class Sets:
    """Runs the sets of a plan: values of its axes, any number of them at a time."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.axes = plan.axes
        self._scenario, self._subject = plan.scenario, plan.subject
        self._loop, self._imperfect = self._scenario.loop, Imperfect(plan)
        self._of_nodes = [i for i, axis in enumerate(self.axes) if not axis.of_run]
        places = [_places(self._scenario, self.axes[i]) for i in self._of_nodes]
        self._places = None if None in places or not self._in_lanes else places

    @property
    def _in_lanes(self) -> bool:
        time_scale, rate = self._loop.grid
        steps = count_steps(self.plan.duration, time_scale / rate)
        return lanes_can(self._loop, steps, self._subject)

    def run(self, columns: Sequence[Array], pool: ThreadPoolExecutor | None = None) -> Outcomes:
        """Return the outcomes of the sets with these values, one array of shape (n,) per axis."""
        with in_words(self._loop.foreign_models):
            return self._run(columns, pool)

    def _run(self, columns: Sequence[Array], pool: ThreadPoolExecutor | None) -> Outcomes:
        count = len(columns[0]) if columns else 1
        reasons = self._refused(columns)
        around = self._imperfect.of(columns, count, reasons)
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
        for i, places in zip(self._of_nodes, self._places, strict=True):
            for place in places or ():
                bad = ~place.allowed(columns[i])
                for at in np.flatnonzero(bad).tolist():
                    reasons.setdefault(at, place.complaint(columns[i][at]))
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
            for place in places or ():
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
            _apply(self._scenario, given, self.axes[i], _plain(values[i]))
        return Scenario.of(self._scenario.name, given)

    def imperfections(self, values: Sequence[Any]) -> tuple[Impairment, Noise]:
        """Return what happens on the links and what is added to outputs, one value per axis."""
        return self._imperfect.of([np.array([value]) for value in values], 1).at(0)


def _plain(value: Any) -> Any:
    """Return a number or a word as a parameter file holds it."""
    return value.item() if isinstance(value, np.generic) else value


def _apply(scenario: Scenario, given: dict[str, dict[str, Any]], axis: Axis, value: Any) -> None:
    """Set the value of an axis in ``given``."""
    if axis.index is not None:
        for node in _nodes(scenario, axis):
            whole = list(scenario.nodes[node].get(axis.parameter, ()))
            whole = list(given[node].get(axis.parameter, whole)) or whole
            if axis.index >= len(whole):
                raise EventregError(
                    f'{axis.name}: {node}.{axis.parameter} has {len(whole)} entries; count from 0'
                )
            whole[axis.index] = value
            given[node][axis.parameter] = whole
        return
    Override(f'{axis.name}:={value}', axis.node, axis.parameter, value).apply(given, ())


def _nodes(scenario: Scenario, axis: Axis) -> list[str]:
    if axis.node != '/**':
        return [axis.node]
    return [
        node
        for node, values in scenario.given.items()
        if not is_foreign(values) and has(node, values, axis.parameter)
    ]


def _outputs(spec: BlockSpec, x: Array, params: Array) -> Array:
    """Return the outputs of a block at the start of sets, shape (n,)."""
    if spec.model.output is first_state:
        return np.array(x[:, 0])
    pairs = zip(x.tolist(), params.tolist(), strict=True)
    return np.array([first_output(spec, tuple(s), packed(spec, p)) for s, p in pairs])


class _Place:
    """Where a value goes that is nothing but a number of one block, and its rule."""

    def __init__(self, node: str, axis: Axis, block: int, slot: int, values: Any) -> None:
        self.block, self.slot = block, slot
        self.of_state = axis.parameter == 'x0'
        self._node, self._axis = node, axis
        self._row, self._values = parameters_of(node, values)[axis.parameter], values

    def allowed(self, values: Array) -> Any:
        """Return which values keep the rule, shape (n,)."""
        row = self._row
        good = np.isfinite(values)
        if self._axis.index is None and row.low is not None:
            good &= values > row.low if row.open_low else values >= row.low
        if self._axis.index is None and row.high is not None:
            good &= values <= row.high
        return good

    def complaint(self, value: float) -> str:
        """Return what is wrong with a value that is not allowed."""
        given: Any = _plain(value)
        if self._axis.index is not None:
            given = list(self._values[self._axis.parameter])
            given[self._axis.index] = _plain(value)
        try:
            self._row.check(self._node, given)
        except EventregError as error:
            return str(error)
        return f'{self._axis.name} must be {self._row.rule}, got {value!r}'


def _places(scenario: Scenario, axis: Axis) -> list[_Place] | None:
    """Return where the values of an axis go, None when they are more than numbers of blocks."""
    blocks = list(scenario.blocks.items())
    numbers = axis.is_law or all(isinstance(value, float) for value in axis.values)
    found = []
    for node in _nodes(scenario, axis):
        b = next((i for i, (name, _) in enumerate(blocks) if name == node), None)
        if b is None or not numbers:
            return None
        slot = _slot(axis, blocks[b][1])
        if slot is None:
            return None
        found.append(_Place(node, axis, b, slot, scenario.nodes[node]))
    return found or None


def _free(model: Model) -> list[str]:
    """Return the parameters of a model that learns with which its learning has no rule."""
    own = () if model.base is None else model.base.parameters
    return [parameter.name for parameter in own if parameter.name not in model.learned]


def _slot(axis: Axis, spec: BlockSpec) -> int | None:
    """Return the place of an axis in the state or the parameters of a block, None without one."""
    model, pack = spec.model, type(spec.params)
    if axis.parameter == 'x0':
        return axis.index if axis.index is not None and axis.index < model.own else None
    if not ((pack is tuple and model.pack is None) or model.pack is pack):
        return None
    if model.learned and axis.parameter not in _free(model):
        return None  # a state, or a bound of one
    slot = 0
    for parameter in model.parameters:
        length = parameter.length
        if parameter.name == axis.parameter:
            if (length is None) != (axis.index is None) or (axis.index or 0) >= (length or 1):
                return None
            return slot + (axis.index or 0)
        slot += length or 1
    return None
