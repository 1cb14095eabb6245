"""The scenario: an ordinary ROS parameter file, read and checked once, for everyone."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ParameterError, ScenarioError
from ..models.roles import ROLES, STIMULUS_OUTPUT, model_of
from ..simulation.block import BlockSpec
from ..simulation.stimulus import Stimulus
from . import ros_yaml
from .parameters import NODES, hint, is_ros_parameter, kind_of, resolve

WILDCARD = '/**'


class Loop(NamedTuple):
    """What of a scenario is simulated: its blocks by role, the open input, and the input's name."""

    blocks: dict[str, BlockSpec]
    stimulus: Stimulus | None
    stimulus_output: str


@dataclass(frozen=True)
class Scenario:
    """What a parameter file says: which nodes there are and all their parameters, checked.

    ``nodes`` maps each node's name to its resolved parameters; ``given`` holds, in the same shape,
    only what the file and the overrides said, which is what a node is started with.
    """

    name: str
    nodes: Mapping[str, Mapping[str, Any]]
    given: Mapping[str, Mapping[str, Any]] = field(repr=False)

    @property
    def blocks(self) -> dict[str, BlockSpec]:
        """The blocks among the nodes, by role."""
        return {role: block_spec(role, self.nodes[role]) for role in ROLES if role in self.nodes}

    @property
    def stimulus(self) -> Stimulus | None:
        """The open input v, or None when the scenario has no stimulus node."""
        values = self.nodes.get('stimulus')
        return None if values is None else Stimulus.from_parameters(values)

    @property
    def loop(self) -> Loop:
        """The loop for offline tools. Raises ScenarioError when there are links in it."""
        links = [name for name in self.nodes if kind_of(name) == 'link']
        if links:
            raise ScenarioError(
                f'scenario {self.name} has {", ".join(links)}, and links are for real nodes only; '
                f'take it without them and impair all signals with eventreg simulate --sampled '
                f'--delay D --jitter J --loss P'
            )
        v = self.nodes.get('stimulus', {}).get('output', STIMULUS_OUTPUT)
        return Loop(self.blocks, self.stimulus, v)

    @property
    def publishers(self) -> dict[str, str]:
        """The signals that somebody publishes, and who."""
        return {values['output']: name for name, values in self.nodes.items() if 'output' in values}

    @property
    def time_scale(self) -> float:
        """Model time units per second. Raises ScenarioError when the nodes disagree."""
        return self._common('time_scale')

    @property
    def rate(self) -> float:
        """Steps per second. Raises ScenarioError when the nodes disagree."""
        return self._common('rate')

    @property
    def monitor(self) -> tuple[float, float]:
        """Threshold and reset of the events, the spike monitor's or its defaults."""
        values = self.nodes.get('spike_monitor')
        return monitor_defaults() if values is None else (values['threshold'], values['reset'])

    def _common(self, name: str) -> float:
        found = {
            node: values[name]
            for node, values in self.nodes.items()
            if name in values and 'output' in values
        }
        if not found:
            raise ScenarioError(
                f'scenario {self.name} has no {name}: it names no block; name the plant at least'
            )
        if len(set(found.values())) > 1:
            raise ScenarioError(
                f'scenario {self.name}: all nodes must have the same {name}, got '
                + ', '.join(f'{node} {value:g}' for node, value in found.items())
                + f'; set it once with -p /**.{name}:=VALUE'
            )
        return float(next(iter(found.values())))

    def to_yaml(self, anywhere: bool = False) -> str:
        """Return the scenario as the text of a ROS parameter file, overrides included.

        With ``anywhere`` it holds for the nodes in any namespace.
        """
        prefix = f'{WILDCARD}/' if anywhere else ''
        data = {f'{prefix}{n}': {'ros__parameters': dict(v)} for n, v in self.given.items()}
        return ros_yaml.dump(data)


def monitor_defaults() -> tuple[float, float]:
    """Return threshold and reset where no spike monitor says otherwise."""
    values = resolve('spike_monitor', {})
    return values['threshold'], values['reset']


def block_spec(role: str, values: Mapping[str, Any]) -> BlockSpec:
    """Build the block of ``role`` from its resolved parameters."""
    gain = values['gain']
    return BlockSpec(
        name=role,
        model=model_of(role, values['model']),
        params=(values['k'], values['tau'], values['k_y'], gain[0], gain[1]),
        x0=tuple(values['x0']),
        inputs=(
            *((signal, 1.0) for signal in values['excitatory']),
            *((signal, -1.0) for signal in values['inhibitory']),
        ),
        output=values['output'],
        rate=values['rate'],
        time_scale=values['time_scale'],
        hold=values['hold'],
    )


def config_directory() -> Path:
    """Return the directory of the shipped scenarios, in a source tree or in an installation.

    Raises ScenarioError when the package was installed without them.
    """
    package = Path(__file__).resolve().parent
    for root in package.parents:
        for found in (root / 'config', root / 'share' / 'eventreg_ros' / 'config'):
            if (found / 'exact.yaml').is_file():
                return found
    raise ScenarioError(
        f'the shipped scenarios are missing beside {package}; install the package again'
    )


def shipped() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(path.stem for path in config_directory().glob('*.yaml'))


def load(scenario: str, overrides: Iterable[str] = (), implicit: Collection[str] = ()) -> Scenario:
    """Read a scenario by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are strings ``NODE.PARAM:=VALUE``; NODE may be ``/**``, or one of the ``implicit``
    nodes, which the scenario need not name. Raises ScenarioError or ParameterError, one line that
    says what is wrong and how to mend it.
    """
    path = find(scenario)
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f'scenario {path} must be a readable text file: {error}') from None
    return parse(text, path.stem, overrides, implicit)


def find(scenario: str) -> Path:
    """Return the file of a scenario given by name or path. Raises ScenarioError."""
    path = Path(scenario)
    if path.suffix in ('.yaml', '.yml') or '/' in scenario:
        if path.is_file():
            return path
        raise ScenarioError(f'scenario file {scenario!r} does not exist; check the path')
    if scenario not in shipped():
        raise ScenarioError(
            f'no scenario {scenario!r}; shipped are {", ".join(shipped())}, '
            f'or give the path of a .yaml file'
        )
    return config_directory() / f'{scenario}.yaml'


def parse(
    text: str, name: str, overrides: Iterable[str] = (), implicit: Collection[str] = ()
) -> Scenario:
    """Read a scenario from the text of a ROS parameter file; see :func:`load`."""
    try:
        given = _nodes(ros_yaml.load(text, name), name)
    except RecursionError:
        raise ScenarioError(f'scenario {name} nests without end; remove the alias') from None
    for override in overrides:
        _apply(override, given, implicit)
    everyone = given.pop(WILDCARD, {})
    for parameter in everyone:
        if not is_ros_parameter(parameter) and not any(_has(n, parameter) for n in NODES):
            known = {p.name: None for table in NODES.values() for p in table}
            raise ParameterError(
                f'{WILDCARD}.{parameter}: no node has the parameter {parameter!r}'
                f'{hint(parameter, known)}'
            )
    if not given:
        raise ScenarioError(
            f'scenario {name} names no node; name at least one of {", ".join(NODES)}'
        )
    merged = {
        node: {**{p: v for p, v in everyone.items() if _has(node, p)}, **values}
        for node, values in given.items()
    }
    nodes = {node: resolve(node, values) for node, values in merged.items()}
    checked = {
        node: {p: nodes[node].get(p, v) for p, v in values.items()}
        for node, values in merged.items()
    }
    return _distinct(Scenario(name, nodes, checked))


def _distinct(scenario: Scenario) -> Scenario:
    seen: dict[str, str] = {}
    for node, values in scenario.nodes.items():
        if (signal := values.get('output')) is None:
            continue
        if signal in seen:
            raise ScenarioError(
                f'scenario {scenario.name}: {seen[signal]} and {node} both publish {signal!r}; '
                f'set {node}.output to another signal'
            )
        seen[signal] = node
    return scenario


def _has(node: str, parameter: str) -> bool:
    return is_ros_parameter(parameter) or any(p.name == parameter for p in NODES[kind_of(node)])


def _nodes(data: Any, name: str) -> dict[str, dict[str, Any]]:
    """Bring the keys of a parameter file to plain node names; keep the order."""
    if not isinstance(data, dict):
        raise ScenarioError(
            f'scenario {name} must be a ROS parameter file (NODE: ros__parameters: ...), '
            f'got {type(data).__name__}'
        )
    nodes: dict[str, dict[str, Any]] = {}
    for key, value in data.items():
        node = WILDCARD if key == WILDCARD else str(key).removeprefix(WILDCARD).strip('/')
        if node != WILDCARD and kind_of(node) not in NODES:
            raise ScenarioError(f'scenario {name}: no node {key!r}{hint(node, NODES)}')
        parameters = value.get('ros__parameters') if isinstance(value, dict) else None
        if not isinstance(parameters, dict) or set(value) != {'ros__parameters'}:
            raise ScenarioError(
                f'scenario {name}: {key} must hold ros__parameters: and below it one line per '
                f'parameter, got {value!r}'
            )
        nodes.setdefault(node, {}).update(_flat(parameters))
    return nodes


def _flat(parameters: Mapping[Any, Any], prefix: str = '') -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in parameters.items():
        if isinstance(value, dict):
            flat.update(_flat(value, f'{prefix}{name}.'))
        else:
            flat[f'{prefix}{name}'] = value
    return flat


def _apply(override: str, given: dict[str, dict[str, Any]], implicit: Collection[str]) -> None:
    match = re.fullmatch(r'(/\*\*|[^.:\s]+)\.([^:\s]+):=(.*)', override, re.DOTALL)
    if not match:
        raise ParameterError(f'-p must be NODE.PARAM:=VALUE (plant.k:=2), got {override!r}')
    node, parameter, text = match.groups()
    node = node if node == WILDCARD else node.strip('/')
    if node != WILDCARD and node not in given and node not in implicit:
        raise ParameterError(
            f'-p {override}: the scenario has no node {node!r}; it has '
            + ', '.join(n for n in given if n != WILDCARD)
        )
    given.setdefault(node, {})[parameter] = ros_yaml.load(text, f'-p {override}')
    if node == WILDCARD:
        for name, values in given.items():
            if name != WILDCARD and _has(name, parameter):
                values.pop(parameter, None)
