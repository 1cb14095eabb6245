# SPDX-License-Identifier: Apache-2.0
"""What --at says: a time, and what is done then: a parameter set, a node switched off or on."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from ..errors import ParameterError, ScenarioError
from ..simulation.block import BlockSpec
from ..simulation.stimulus import Stimulus
from ..simulation.turns import Action, Turn
from .blocks import block_spec
from .hint import hint
from .parameter import ACTIVE
from .parameters import completed, is_foreign, parameters_of
from .reader import typed
from .scenario import Scenario

_SWITCH = re.compile(r'([^:]+):([^:.\s]+):(activate|deactivate)')
_SET = re.compile(r'([^:]+):([^:.\s]+)\.([^:\s]+):=(.*)', re.DOTALL)


class Intervention(NamedTuple):
    """One ACTION at a time, in the unit of whoever reads it: seconds, or model time."""

    text: str
    at: float
    node: str
    action: Action
    parameter: str = ''
    value: Any = None

    @classmethod
    def read(cls, text: str) -> Intervention:
        """Read T:NODE.PARAM:=VALUE, T:NODE:activate or T:NODE:deactivate. Raises ParameterError."""
        if found := _SWITCH.fullmatch(text):
            at, node, word = found.groups()
            action: Action = 'activate' if word == 'activate' else 'deactivate'
            return cls(text, _time(text, at), node.strip('/'), action)
        if found := _SET.fullmatch(text):
            at, node, parameter, value = found.groups()
            read = typed(value, f'at {text}', parameter)
            return cls(text, _time(text, at), node.strip('/'), 'set', parameter, read)
        raise ParameterError(
            'an intervention must be T:NODE.PARAM:=VALUE, T:NODE:activate or T:NODE:deactivate '
            f'(150:controller:deactivate), got {text!r}'
        )


def _time(text: str, at: str) -> float:
    try:
        value = float(at)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise ParameterError(f'at {text}: the time must be a number >= 0, got {at!r}')
    return value


def read_all(texts: Iterable[str], scenario: Scenario) -> list[Intervention]:
    """Read and check interventions; return them in the order of their times; one text is one.

    Values are in the type of their parameter. Raises ParameterError or ScenarioError.
    """
    texts = [texts] if isinstance(texts, str) else texts
    found = sorted(map(Intervention.read, texts), key=lambda each: each.at)
    return [
        each._replace(value=values[each.parameter]) if each.action == 'set' else each
        for each, values in zip(found, _course(found, scenario), strict=True)
    ]


def need_before(end: float, interventions: Iterable[Intervention], unit: str) -> None:
    """Raise ParameterError when an intervention comes at the ``end``, or later, in ``unit``."""
    for each in interventions:
        if each.at >= end:
            raise ParameterError(
                f'at {each.text}: {each.at:g} is not before the end, the duration is {end:g} '
                f'{unit}; take an earlier time or a longer duration'
            )


def turns(interventions: Sequence[Intervention], scenario: Scenario) -> list[Turn]:
    """Return what a simulation of ``scenario`` does for interventions in model time.

    Raises ScenarioError for what only real nodes can do.
    """
    return [
        _turn(each, scenario, values)
        for each, values in zip(interventions, _course(interventions, scenario), strict=True)
    ]


def _course(interventions: Sequence[Intervention], scenario: Scenario) -> list[Mapping[str, Any]]:
    """Return the parameters of the node concerned after each intervention. Checks them all."""
    now = {node: dict(values) for node, values in scenario.nodes.items()}
    course: list[Mapping[str, Any]] = []
    for each in interventions:
        if each.node not in now:
            raise ScenarioError(
                f'at {each.text}: the scenario has no node {each.node!r}{hint(each.node, now)}'
            )
        if each.action == 'set':
            now[each.node] = _with(each, now[each.node])
        course.append(dict(now[each.node]))
    return course


def _with(each: Intervention, values: dict[str, Any]) -> dict[str, Any]:
    if is_foreign(values):
        return {**values, each.parameter: each.value}  # the node itself accepts or refuses it
    table = parameters_of(each.node, values)
    row = table.get(each.parameter)
    if row is None:
        raise ParameterError(
            f'at {each.text}: {each.node} has no parameter {each.parameter!r}'
            f'{hint(each.parameter, table)}'
        )
    if row.settable != ACTIVE:
        live = ', '.join(name for name, each in table.items() if each.settable == ACTIVE)
        raise ParameterError(
            f'at {each.text}: {each.node}.{each.parameter} cannot be set while the node runs; '
            f'these can: {live}'
        )
    return {**values, each.parameter: row.check(each.node, each.value)}


def _turn(each: Intervention, scenario: Scenario, values: Mapping[str, Any]) -> Turn:
    kind = scenario.name_of(each.node).kind
    if each.action == 'set' and each.parameter == 'time_scale':
        raise ScenarioError(f'at {each.text}: a simulation has one time_scale; set it with -p')
    if kind == 'stimulus' and each.action == 'set':
        signal = scenario.output_of(each.node) or ''
        return Turn(each.at, signal, 'set', stimulus=Stimulus.from_parameters(values))
    if each.node not in scenario.blocks:
        raise ScenarioError(
            f'at {each.text}: a simulation has blocks and stimuli only, and stimuli cannot be '
            f'switched; use eventreg run'
        )

    def spec(learned: Mapping[str, float]) -> BlockSpec:
        kept = {n: v for n, v in learned.items() if each.action != 'set' or n != each.parameter}
        table = parameters_of(each.node, values)
        own = {name: values[name] for name in table}
        return block_spec(each.node, completed(each.node, table, {**own, **kept}))

    if new := sorted(set(spec({}).signals) - set(scenario.blocks[each.node].signals)):
        raise ScenarioError(
            f'at {each.text}: {", ".join(new)} would begin in the midst of a simulation; let it '
            f'be there from the start, with a small value: -p {each.node}.{each.parameter}:=1e-9'
        )
    return Turn(each.at, each.node, each.action, spec)
