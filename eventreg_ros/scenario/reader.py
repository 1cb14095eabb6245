# SPDX-License-Identifier: Apache-2.0
"""Parameter files to scenarios: keys, wildcards and namespaces, as ROS reads them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ParameterError, ScenarioError, shown
from . import ros_yaml
from .derived import Given
from .files import find, from_file, names_file, text_of
from .hint import hint
from .names import KINDS, kind_of
from .parameters import all_parameters, has, is_foreign, is_ros_parameter
from .scenario import Scenario

EVERYONE = '/**'


def load(scenario: str, overrides: Iterable[str] = (), implicit: Collection[str] = ()) -> Scenario:
    """Read a scenario by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are strings ``NODE.PARAM:=VALUE``; NODE may be ``/**``, or one of the ``implicit``
    nodes, which the scenario need not name. Raises ScenarioError or ParameterError, one line that
    says what is wrong and how to fix it.
    """
    path = find(scenario)
    return parse(text_of(path), path.stem, overrides, implicit, path.parent)


def parse(
    text: str,
    name: str,
    overrides: Iterable[str] = (),
    implicit: Collection[str] = (),
    base: Path | None = None,
) -> Scenario:
    """Read a scenario from the text of a ROS parameter file; see :func:`load`.

    The files that it names are looked for in ``base``, its directory; without one, here.
    """
    entries = _entries(text, name, base)
    given: dict[str, dict[str, Any]] = {entry.node: {} for entry in entries if not entry.wild}
    for entry in entries:
        last = entry.node.rpartition('/')[2]
        if entry.wild and '*' not in last and not any(map(entry.matches, given)):
            given[last] = {}
    if not given:
        raise ScenarioError(
            f'scenario {name} names no node; name at least one of {", ".join(KINDS)}'
        )
    _fill(given, entries)
    for override in map(Override.read, overrides):
        override.apply(given, implicit)
    return Scenario.of(name, given)


def with_file(
    scenario: Scenario, text: str, name: str, namespace: str = '', base: Path | None = None
) -> Scenario:
    """Return ``scenario`` with what another parameter file, read after it, says of its nodes.

    Other nodes in the file are left alone, as ROS does. Where the scenario is started within
    ``namespace``, the file may name its nodes with it or without. The files that it names are
    looked for in ``base``, its directory; without one, here.
    """
    given = {node: dict(values) for node, values in scenario.given.items()}
    inside = namespace.strip('/') + '/' if namespace.strip('/') else ''
    _fill(given, _entries(text, name, base, strict=False), inside)
    return Scenario.of(scenario.name, given)


def with_overrides(
    scenario: Scenario, overrides: Iterable[str | Override], implicit: Collection[str] = ()
) -> Scenario:
    """Return ``scenario`` with overrides applied in order, and then checked; see :func:`load`."""
    given = {node: dict(values) for node, values in scenario.given.items()}
    for override in overrides:
        read = Override.read(override) if isinstance(override, str) else override
        read.apply(given, implicit)
    return Scenario.of(scenario.name, given)


class Entry(NamedTuple):
    """One key of a parameter file and the parameters below it; ``node`` without a leading slash."""

    key: str
    node: str
    values: dict[str, Any]

    def locate(self, base: Path) -> None:
        """Give the files that the parameters of our nodes name, from ``base``, in full."""
        for parameter, value in self.values.items() if not is_foreign(self.values) else ():
            if names_file(self.node, parameter) and isinstance(value, str):
                self.values[parameter] = from_file(value, base)

    @property
    def wild(self) -> bool:
        """Whether the key is a pattern."""
        return '*' in self.node

    @property
    def everyone(self) -> bool:
        """Whether the key leaves the node's own name open."""
        return '*' in self.node.rpartition('/')[2]

    def matches(self, node: str) -> bool:
        """Say whether the key holds for the node of that full name: * is one token, ** any."""
        pattern = f'/{self.node}'.replace('/**', '(/\\w+)*').replace('/*', '(/\\w+)')
        return re.fullmatch(pattern, f'/{node}') is not None


def _fill(given: dict[str, dict[str, Any]], entries: Sequence[Entry], namespace: str = '') -> None:
    """Put what the entries say into ``given``, in their order: what comes later wins, as in ROS.

    Within a ``namespace`` the entries may name the nodes with it or without.
    """
    for entry in entries:
        for parameter in entry.values if entry.everyone else ():
            _need_known(entry.key, parameter, given)
    for node, values in given.items():
        fitting = [e for e in entries if e.matches(node) or e.matches(f'{namespace}{node}')]
        kind = dict(values)
        for entry in fitting:
            kind |= {p: v for p, v in entry.values.items() if p in ('model', 'package')}
        for entry in fitting:
            for parameter, value in entry.values.items():
                if not entry.everyone or has(node, kind, parameter):
                    values[parameter] = value


def _need_known(key: str, parameter: str, given: Mapping[str, Mapping[str, Any]]) -> None:
    if is_ros_parameter(parameter) or parameter in all_parameters():
        return
    if any(is_foreign(values) or _takes(n, values, parameter) for n, values in given.items()):
        return
    raise ParameterError(
        f'{key}.{parameter}: no node has the parameter {parameter!r}'
        f'{hint(parameter, all_parameters())}'
    )


def _takes(node: str, values: Mapping[str, Any], parameter: str) -> bool:
    try:
        return has(node, values, parameter)
    except (ParameterError, ScenarioError, LookupError):
        return False


# Keys ---------------------------------------------------------------------------------------------


def _entries(text: str, name: str, base: Path | None, strict: bool = True) -> list[Entry]:
    """Return the entries of a parameter file in order. Raises ScenarioError.

    Unless ``strict``, keys of nodes that are none of ours pass.
    """
    entries = [
        Entry(section.name, section.name.strip('/'), section.values)
        for section in ros_yaml.load(text, f'scenario {name}')
    ]
    for entry in entries:
        entry.locate(base or Path())
    for entry in entries if strict else ():
        if not (entry.wild or kind_of(entry.node) or is_foreign(entry.values)):
            raise ScenarioError(
                f'scenario {name}: no node {shown(entry.key)}{hint(entry.node, KINDS)}'
            )
    return entries


def typed(text: str, where: str, parameter: str = '') -> Any:
    """Return what a command line gives to ``parameter``: as for ROS, or a fraction like 1/16.

    Raises ScenarioError that names ``where``.
    """
    if found := re.fullmatch(r'\s*([-+]?[0-9.]+)/([0-9.]+)\s*', text):
        try:
            return float(found[1]) / float(found[2])
        except (ValueError, ZeroDivisionError):
            pass
    return ros_yaml.value(text, where, parameter)


class Override(NamedTuple):
    """One NODE.PARAM:=VALUE."""

    text: str
    node: str
    parameter: str
    value: Any

    @classmethod
    def read(cls, text: str) -> Override:
        """Read the text behind a -p. Raises ParameterError."""
        match = re.fullmatch(r'(/\*\*|[^.:\s]+)\.([^:\s]+):=(.*)', text, re.DOTALL)
        if not match:
            raise ParameterError(
                f'an override must be NODE.PARAM:=VALUE (plant.k:=2), got {shown(text)}'
            )
        node, parameter, value = match.groups()
        node = node if node == EVERYONE else node.strip('/')
        return cls(text, node, parameter, typed(value, text, parameter))

    @classmethod
    def of(cls, name: str, value: object) -> Override:
        """Return the override of NODE.PARAM by a value of Python. Raises ParameterError."""
        node, dot, parameter = name.partition('.')
        if not dot:
            raise ParameterError(f'a parameter must be named NODE.PARAM (plant.k), got {name!r}')
        node = node if node == EVERYONE else node.strip('/')
        return cls(f'{name}:={shown(value)}', node, parameter, value)

    def apply(self, given: Given, implicit: Collection[str]) -> None:
        """Set the parameter in ``given``: of the node, or of every node that has it."""
        if self.node == EVERYONE:
            _need_known(EVERYONE, self.parameter, given)
            for node, values in given.items():
                if is_foreign(values) or has(node, values, self.parameter):
                    values[self.parameter] = self.value
            return
        if self.node not in given and self.node not in implicit:
            raise ParameterError(
                f'{self.text}: the scenario has no node {self.node!r}; it has ' + ', '.join(given)
            )
        given.setdefault(self.node, {})[self.parameter] = self.value
