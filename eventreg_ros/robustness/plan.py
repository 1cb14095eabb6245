# SPDX-License-Identifier: Apache-2.0
"""What a sweep was asked for, as plain data: it names a sweep, and goes to other machines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, SupportsFloat, SupportsIndex

from .. import scenario as scenarios
from ..analysis.subject import Subject, subject_of
from ..errors import EventregError, shown
from ..scenario import Scenario
from ..scenario.criteria import need_span
from ..scenario.hint import hint
from ..scenario.links import need_linked
from ..scenario.parameters import parameters_of
from ..scenario.reader import Override
from ..simulation.impairment import Impairment
from ..simulation.noise import SILENCE, Noise
from .axes import LINKS, NOISE, Axis, in_order, read
from .design import Design, design_of
from .setting import nodes_of, set_value


@dataclass(frozen=True)
class Plan:
    """A sweep: the scenario's text, what is varied and what is fixed, and how it is judged.

    ``parameters`` are NODE.PARAM:=SPEC as given, see :mod:`.axes`; ``sampling`` is ``grid`` or one
    of :data:`.design.SAMPLINGS`; ``on`` are the signals whose links are impaired, None for all.
    ``duration``, ``settle`` and ``window`` are in model time; None: as the scenario says.
    ``question`` is what is asked of the sets but for a table of them all, in words.
    """

    name: str
    text: str
    parameters: tuple[str, ...]
    sets: int | None = None
    seed: int = 0
    sampling: str = 'grid'
    on: tuple[str, ...] | None = None
    duration: float = 400.0
    settle: float | None = None
    window: float | None = None
    question: str = ''

    @classmethod
    def of(cls, scenario: Scenario, parameters: Sequence[str], **more: Any) -> Plan:
        """Return the plan to vary ``parameters`` of a scenario, checked as far as it can be.

        Raises EventregError.
        """
        more = {name: _checked(name, value) for name, value in more.items() if value is not None}
        plan = cls(scenario.name, scenario.to_yaml(), tuple(parameters), **more)
        if 'duration' not in more:
            plan = replace(plan, duration=plan.subject.criteria.duration(plan.duration))
        plan.check()
        return plan

    def check(self) -> None:
        """Raise EventregError unless the sweep can begin."""
        loop, axes = self.scenario.loop, self.axes
        _ = self.scenario.rate, self.scenario.time_scale, self.design
        need_linked(loop, self.impairment.on)
        _ = self.noise
        need_span(self.subject.criteria, self.duration, settle=self.settle, until=None)
        for axis in axes:
            if not axis.of_run:
                nodes_of(self.scenario, axis)
                self._need_parameter(axis)

    def _need_parameter(self, axis: Axis) -> None:
        """Raise EventregError unless a node that the axis names may have its parameter."""
        of_all = axis.node == '/**'
        named = [node for node in self.scenario.nodes if of_all or node == axis.node]
        tables = [parameters_of(node, self.scenario.nodes[node]) for node in named]
        chosen = {a.parameter for a in self.axes if a.node in (axis.node, '/**')}
        if 'model' in chosen:
            return  # another model has other parameters
        if any(axis.parameter in table for table in tables):
            if axis.index is not None:
                self._need_entry(axis)
            return
        known = [name for table in tables for name in table]
        raise EventregError(
            f'{axis.name}: {axis.node} has no parameter {axis.parameter!r}'
            f'{hint(axis.parameter, known)}'
        )

    def _need_entry(self, axis: Axis) -> None:
        """Raise EventregError where an axis is of an entry that no list has."""
        scenario = self.scenario
        given = {node: dict(values) for node, values in scenario.given.items()}
        set_value(scenario, given, axis, 0.0)

    def fixed_after(self, axis: Axis) -> list[Override]:
        """Return what is fixed after an axis was given: it counts, where both set the same."""
        found = in_order(self.parameters)
        later = found[found.index(axis) + 1 :]
        return [Override.read(each) for each in later if isinstance(each, str)]

    @property
    def _fixed(self) -> list[str]:
        return read(self.parameters)[1]

    @property
    def scenario(self) -> Scenario:
        """The scenario with what is fixed."""
        found = scenarios.parse(self.text, self.name, self._fixed)
        entries = [a for a in read(self.parameters)[0] if a.fixed and not a.of_run]
        if not entries:
            return found
        given = {node: dict(values) for node, values in found.given.items()}
        for entry in entries:
            set_value(found, given, entry, entry.values[0])
        return Scenario.of(self.name, given)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """What is varied."""
        return tuple(axis for axis in read(self.parameters)[0] if not axis.fixed)

    def _fixed_of(self, node: str) -> dict[str, float]:
        found = read(self.parameters)[0]
        return {
            axis.parameter: axis.values[0] for axis in found if axis.node == node and axis.fixed
        }

    @property
    def impairment(self) -> Impairment:
        """What happens on the links, as far as it is fixed."""
        on = None if self.on is None else frozenset(self.on)
        return impairment(on=on, **self._fixed_of(LINKS))

    @property
    def noise(self) -> Noise:
        """What is added to the outputs of the plants, as far as it is fixed; 0 where it is varied.

        As ``simulate --noise`` does it. Raises EventregError where no plant has such an output.
        """
        asked = [axis.parameter for axis in read(self.parameters)[0] if axis.node == NOISE]
        if not asked:
            return SILENCE
        outputs = tuple(plant.output for plant in subject_of(self.scenario).plants)
        for signal in asked:
            if signal not in outputs:
                raise EventregError(
                    f'{NOISE}.{signal}: noise is on the output of a plant, and {signal!r} is '
                    f'none{hint(signal, outputs)}'
                )
        fixed = self._fixed_of(NOISE)
        sds = tuple(fixed.get(signal, 0.0) for signal in outputs)
        return Noise(sds, self.impairment.seed, outputs)

    @property
    def design(self) -> Design:
        """Which sets are run."""
        return design_of(self.axes, self.sets, self.seed, self.sampling)

    @property
    def subject(self) -> Subject:
        """What is judged. Raises EventregError when there is no plant."""
        return self.subject_of(self.scenario)

    def subject_of(self, scenario: Scenario) -> Subject:
        """Return the same for a set whose scenario is another."""
        subject = subject_of(scenario, scenario.loop.signals)
        if not subject.plants:
            raise EventregError(f'scenario {self.name} has no plant to judge; name one')
        limits = subject.criteria.overridden(settle=self.settle, window=self.window)
        return replace(subject, criteria=limits)

    def as_dict(self) -> dict[str, Any]:
        """Return the plan as JSON holds it."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in asdict(self).items()
        }


def _checked(name: str, value: Any) -> Any:
    """Return what is asked for as a plan holds it. Raises EventregError for another type."""
    if name in ('sets', 'seed'):
        whole = isinstance(value, SupportsIndex) and not isinstance(value, bool)
        if not whole or value.__index__() < (name == 'sets'):
            least = 1 if name == 'sets' else 0
            raise EventregError(f'{name} must be a whole number >= {least}, got {shown(value)}')
        return value.__index__()
    if name in ('duration', 'settle', 'window'):
        if not isinstance(value, SupportsFloat):
            raise EventregError(f'{name} must be a number, of model time, got {shown(value)}')
        return float(value)
    if name == 'on' and not value:
        raise EventregError(
            f'on must name signals (y, u), got {shown(value)}; leave it out for all'
        )
    return value


def impairment(
    delay: float = 0.0,
    loss: float = 0.0,
    jitter: float = 0.0,
    seed: float = 0,
    on: frozenset[str] | None = None,
) -> Impairment:
    """Return an impairment; a seed may come as a float. Raises EventregError for a bad value."""
    return Impairment(float(delay), float(loss), float(jitter), whole_seed(seed), on)


def whole_seed(seed: float) -> int:
    """Return a seed that may come as a float. Raises EventregError unless it is whole."""
    if not float(seed).is_integer():
        raise EventregError(f'links.seed must be a whole number, got {seed:g}')
    return int(seed)
