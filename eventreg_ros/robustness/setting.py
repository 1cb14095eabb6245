# SPDX-License-Identifier: Apache-2.0
"""One value of an axis, put into what a scenario gives its nodes."""

from __future__ import annotations

from typing import Any

from ..errors import EventregError
from ..scenario import Scenario
from ..scenario.parameters import has, is_foreign
from ..scenario.reader import Override
from .axes import Axis


def set_value(scenario: Scenario, given: dict[str, dict[str, Any]], axis: Axis, value: Any) -> None:
    """Set the value of an axis in ``given``. Raises EventregError where there is no such thing."""
    if axis.index is None:
        Override(f'{axis.name}:={value}', axis.node, axis.parameter, value).apply(given, ())
        return
    for node in nodes_of(scenario, axis):
        now = given[node].get(axis.parameter) or scenario.nodes[node].get(axis.parameter, ())
        whole = list(now) if isinstance(now, list | tuple) else None
        if whole is None:
            raise EventregError(
                f'{axis.name}: {node}.{axis.parameter} is no list; leave out [{axis.index}]'
            )
        if axis.index >= len(whole):
            raise EventregError(
                f'{axis.name}: {node}.{axis.parameter} has {len(whole)} entries; count from 0'
            )
        whole[axis.index] = value
        given[node][axis.parameter] = whole


def nodes_of(scenario: Scenario, axis: Axis) -> list[str]:
    """Return the nodes whose parameter an axis sets. Raises EventregError without such a node."""
    if axis.node != '/**':
        if axis.node not in scenario.nodes:
            raise EventregError(
                f'{axis.name}: the scenario has no node {axis.node!r}; it has '
                + ', '.join(scenario.nodes)
            )
        return [axis.node]
    return [
        node
        for node, values in scenario.given.items()
        if not is_foreign(values) and has(node, values, axis.parameter)
    ]
