# SPDX-License-Identifier: Apache-2.0
"""What differs in the parameters of several runs."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

Value = object

PRESENT = 'present'
"""The value of a node that is there, where it is not in other runs."""


@dataclass(frozen=True)
class Difference:
    """A parameter that is not the same in all runs whose parameters are known.

    None in the runs that do not have it, and in those that are not known. A node that some runs do
    not have is one difference, :data:`PRESENT` where it is.
    """

    parameter: str
    values: tuple[Value | None, ...]


def differences(parameters: Sequence[Mapping[str, Value] | None]) -> tuple[Difference, ...]:
    """Return what is not the same in all runs whose parameters are known, in order of name."""
    nodes = [{_node(name) for name in values} for values in parameters if values is not None]
    everywhere = set[str].intersection(*nodes) if nodes else set()
    tables = [None if p is None else _folded(p, everywhere) for p in parameters]
    known = [table for table in tables if table is not None]
    return tuple(
        Difference(name, tuple((table or {}).get(name) for table in tables))
        for name in sorted({name for table in known for name in table})
        if any(table.get(name) != known[0].get(name) for table in known[1:])
    )


def _folded(values: Mapping[str, Value], nodes: Collection[str]) -> dict[str, Value]:
    """Return the parameters of ``nodes``, and for every other node just that it is there."""
    kept = {name: value for name, value in values.items() if _node(name) in nodes}
    return {**kept, **{_node(name): PRESENT for name in values if _node(name) not in nodes}}


def _node(name: str) -> str:
    return name.partition('.')[0]
