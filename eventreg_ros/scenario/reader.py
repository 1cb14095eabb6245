"""Parameter files to scenarios: keys, wildcards and namespaces, as ROS reads them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from typing import Any, NamedTuple

from ..errors import ParameterError, ScenarioError, shown
from . import ros_yaml
from .files import find, text_of
from .hint import hint
from .names import KINDS, kind_of
from .parameters import all_parameters, has, is_foreign, is_ros_parameter
from .scenario import Given, Scenario

EVERYONE = '/**'


def load(scenario: str, overrides: Iterable[str] = (), implicit: Collection[str] = ()) -> Scenario:
    """Read a scenario by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are strings ``NODE.PARAM:=VALUE``; NODE may be ``/**``, or one of the ``implicit``
    nodes, which the scenario need not name. Raises ScenarioError or ParameterError, one line that
    says what is wrong and how to fix it.
    """
    path = find(scenario)
    return parse(text_of(path), path.stem, overrides, implicit)


def parse(
    text: str, name: str, overrides: Iterable[str] = (), implicit: Collection[str] = ()
) -> Scenario:
    """Read a scenario from the text of a ROS parameter file; see :func:`load`."""
    entries = _entries(text, name)
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


def with_file(scenario: Scenario, text: str, name: str, namespace: str = '') -> Scenario:
    """Return ``scenario`` with what another parameter file, read after it, says of its nodes.

    Other nodes in the file are left alone, as ROS does. Where the scenario is started within
    ``namespace``, the file may name its nodes with it or without.
    """
    given = {node: dict(values) for node, values in scenario.given.items()}
    inside = namespace.strip('/') + '/' if namespace.strip('/') else ''
    entries = [
        entry._replace(node=entry.node.removeprefix(inside))
        for entry in _entries(text, name, strict=False)
    ]
    _fill(given, entries)
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

    @property
    def wild(self) -> bool:
        """Whether the key is a pattern."""
        return '*' in self.node

    def matches(self, node: str) -> bool:
        """Say whether the key holds for the node of that full name: * is one token, ** any."""
        tokens = [{'**': '.*', '*': '[^/]+'}.get(t) or re.escape(t) for t in self.node.split('/')]
        pattern = '/' + '/'.join(tokens)
        return re.fullmatch(pattern.replace('/.*/', '/(?:.*/)?'), f'/{node}') is not None


def _fill(given: dict[str, dict[str, Any]], entries: Iterable[Entry]) -> None:
    """Put what the entries say into ``given``: the patterns first, then the nodes themselves."""
    for entry in sorted(entries, key=lambda e: not e.wild):
        if not entry.wild:
            if entry.node in given:
                given[entry.node].update(entry.values)
            continue
        everyone = '*' in entry.node.rpartition('/')[2]
        for parameter in entry.values if everyone else ():
            _need_known(entry.key, parameter, given)
        for node, values in given.items():
            if entry.matches(node):
                model = {p: v for p, v in entry.values.items() if p == 'model'}
                fits = {
                    p: v
                    for p, v in entry.values.items()
                    if not everyone or has(node, {**model, **values}, p)
                }
                values.update(fits)


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


def _entries(text: str, name: str, strict: bool = True) -> list[Entry]:
    """Return the entries of a parameter file in order. Raises ScenarioError."""
    try:
        data = ros_yaml.load(text, name)
        if not isinstance(data, dict):
            raise ScenarioError(
                f'scenario {name} must be a ROS parameter file (NODE: ros__parameters: ...), '
                f'got {type(data).__name__}'
            )
        return list(_walk(data, '', name, strict))
    except RecursionError:
        raise ScenarioError(f'scenario {name} nests without end; remove the alias') from None


def _walk(data: Mapping[Any, Any], prefix: str, name: str, strict: bool) -> Iterable[Entry]:
    """Yield an entry for every ros__parameters below ``data``; keys on the way are namespaces.

    Unless ``strict``, keys of nodes that are none of ours pass.
    """
    for key, value in data.items():
        node = f'{prefix}/{key}'.strip('/') if prefix else str(key).strip('/')
        if _is_namespace(node, value):
            yield from _walk(value, node, name, strict)
            continue
        alone = isinstance(value, dict) and set(value) == {'ros__parameters'}
        parameters = value['ros__parameters'] if alone else None
        foreign = isinstance(parameters, dict) and is_foreign(parameters)
        if strict and not ('*' in node or kind_of(node) or foreign):
            raise ScenarioError(f'scenario {name}: no node {key!r}{hint(node, KINDS)}')
        if not isinstance(parameters, dict):
            raise ScenarioError(
                f'scenario {name}: {key} must hold ros__parameters: and below it one line per '
                f'parameter, got {shown(value)}'
            )
        yield Entry(str(key), node, flat(parameters))


def _is_namespace(node: str, value: Any) -> bool:
    """Say whether a key holds further keys: rcl reads nested keys as namespaces."""
    if not (isinstance(value, dict) and value) or 'ros__parameters' in value:
        return False
    pattern_or_name = '*' in node or kind_of(node) is None
    return pattern_or_name and all(isinstance(inner, dict) for inner in value.values())


def flat(parameters: Mapping[Any, Any], prefix: str = '') -> dict[str, Any]:
    """Return nested parameters with dotted names, as ROS declares them."""
    found: dict[str, Any] = {}
    for name, value in parameters.items():
        if isinstance(value, dict):
            found.update(flat(value, f'{prefix}{name}.'))
        else:
            found[f'{prefix}{name}'] = value
    return found


def typed(text: str, where: str) -> Any:
    """Return a value given on a command line: as in a parameter file, or a fraction like 1/16.

    Raises ScenarioError that names ``where``.
    """
    if found := re.fullmatch(r'\s*([-+]?[0-9.]+)/([0-9.]+)\s*', text):
        try:
            return float(found[1]) / float(found[2])
        except (ValueError, ZeroDivisionError):
            pass
    return ros_yaml.load(text, where)


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
            raise ParameterError(f'-p must be NODE.PARAM:=VALUE (plant.k:=2), got {shown(text)}')
        node, parameter, value = match.groups()
        node = node if node == EVERYONE else node.strip('/')
        return cls(text, node, parameter, typed(value, f'-p {text}'))

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
                f'-p {self.text}: the scenario has no node {self.node!r}; it has '
                + ', '.join(given)
            )
        given.setdefault(self.node, {})[self.parameter] = self.value
