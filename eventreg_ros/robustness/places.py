# SPDX-License-Identifier: Apache-2.0
"""Where the values of an axis go that are nothing but numbers of blocks, without a new scenario."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import EventregError
from ..models import Model
from ..scenario import Scenario
from ..scenario.parameters import parameters_of
from ..scenario.reader import Override
from ..simulation.block import BlockSpec
from .axes import Array, Axis
from .setting import nodes_of


def plain(value: Any) -> Any:
    """Return a number or a word as a parameter file holds it."""
    return value.item() if isinstance(value, np.generic) else value


class Place:
    """Where a value goes that is nothing but a number of one block, and its rule."""

    def __init__(self, scenario: Scenario, node: str, axis: Axis, block: int, slot: int) -> None:
        values = scenario.nodes[node]
        self.block, self.slot = block, slot
        order = list(scenario.given), list(parameters_of(node, values))
        self.rank = order[0].index(node), order[1].index(axis.parameter)
        """The higher, the later a scenario is checked for it."""
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
        given: Any = plain(value)
        if self._axis.index is not None:
            given = list(self._values[self._axis.parameter])
            given[self._axis.index] = plain(value)
        try:
            self._row.check(self._node, given)
        except EventregError as error:
            return str(error)
        return f'{self._axis.name} must be {self._row.rule}, got {value!r}'


def places_of(
    scenario: Scenario, axis: Axis, fixed_after: Sequence[Override]
) -> list[Place] | None:
    """Return where the values of an axis go, None when they are more than numbers of blocks."""
    blocks = list(scenario.blocks.items())
    numbers = axis.is_law or all(isinstance(value, float) for value in axis.values)
    found, kept = [], [each.node for each in fixed_after if each.parameter == axis.parameter]
    for node in nodes_of(scenario, axis):
        if node in kept:
            continue
        b = next((i for i, (name, _) in enumerate(blocks) if name == node), None)
        if b is None or not numbers:
            return None
        slot = _slot(axis, blocks[b][1])
        if slot is None:
            return None
        found.append(Place(scenario, node, axis, b, slot))
    return found or None


def in_force(places: Sequence[list[Place] | None]) -> list[list[Place]] | None:
    """Return the places of axes without those that a later axis sets; None if one has none."""
    last: dict[tuple[int, int, bool], Place] = {}
    for of_axis in places:
        if of_axis is None:
            return None
        last |= {(each.block, each.slot, each.of_state): each for each in of_axis}
    kept = set(map(id, last.values()))
    return [[each for each in of_axis or () if id(each) in kept] for of_axis in places]


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
