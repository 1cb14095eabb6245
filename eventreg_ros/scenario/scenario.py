# SPDX-License-Identifier: Apache-2.0
"""The scenario: which nodes there are, with all their parameters, and what may be made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ScenarioError
from ..models.roles import ROLES
from ..simulation.block import BlockSpec
from ..simulation.loop import Loop
from ..simulation.stimulus import Stimulus
from . import derived, ros_yaml
from .blocks import block_spec
from .criteria import Criteria
from .derived import Given
from .files import from_file, names_file
from .inputs import signs_of
from .names import NodeName, full_name, split
from .parameters import is_foreign, resolve
from .qos import Endpoint, check_key, keys_of, moved, need_topic

Values = Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Scenario:
    """What a parameter file says: which nodes there are and all their parameters, checked.

    ``nodes`` maps each node's name, with its namespace (r1/plant), to its resolved parameters;
    ``given`` holds, in the same shape, only what the file and the overrides said, which is what a
    node is started with. Make one with :meth:`of`.
    """

    name: str
    nodes: Mapping[str, Values]
    given: Mapping[str, Values]

    def __repr__(self) -> str:
        return f'<Scenario {self.name}: {", ".join(self.nodes)}>'

    @classmethod
    def of(cls, name: str, given: Mapping[str, Values]) -> Scenario:
        """Return the scenario that gives its nodes these parameters, checked.

        Files are looked for from here. Raises ParameterError or ScenarioError.
        """
        given = {node: _in_full(node, values) for node, values in given.items()}
        nodes = {node: resolve(node, values) for node, values in given.items()}
        checked = {
            node: {p: nodes[node].get(p, v) for p, v in values.items()}
            for node, values in given.items()
        }
        return cls(name, nodes, checked).check()

    def check(self) -> Scenario:
        """Return the scenario. Raises ScenarioError when two nodes publish the same signal."""
        seen: dict[str, str] = {}
        for node in self.nodes:
            for signal in self.published_by(node):
                if signal in seen:
                    raise ScenarioError(
                        f'scenario {self.name}: {seen[signal]} and {node} both publish {signal!r}; '
                        f'set {node}.output to another signal'
                    )
                seen[signal] = node
        self._check_qos()
        return self

    def _check_qos(self) -> None:
        """Raise ParameterError for a QoS override that acts on nothing."""
        keys: dict[str, list[str]] = {}
        for node, values in self.given.items():
            for key in () if is_foreign(values) else keys_of(values):
                check_key(node, key, self._endpoints_of(node))
                keys.setdefault(key, []).append(node)
        for key, nodes in keys.items():
            have = [each for node in nodes for each in self._endpoints_of(node)]
            need_topic(f'scenario {self.name}: {nodes[0]}', key, have)

    def _endpoints_of(self, node: str) -> list[Endpoint]:
        """Return the publishers and subscriptions of a node whose QoS parameters can override."""
        signals = {'publisher': self.published_by(node), 'subscription': self.inputs_of(node)}
        for name, kind in (('spike_monitor', 'publisher'), ('recorder', 'subscription')):
            if self.name_of(node).kind == name:
                heard, home = self.nodes[node]['signals'], self.name_of(node).namespace
                spikes = [f'spikes/{s}/{what}' for s in heard for what in ('count', 'event')]
                signals[kind] += [full_name(home, each) for each in [*spikes, 'verdict']]
        home = self.name_of(node).namespace + '/'
        return [
            Endpoint(signal.removeprefix(home), f'/{signal}', kind)
            for kind, found in signals.items()
            for signal in found
        ]

    # What there is

    def of_kind(self, *kinds: str) -> list[str]:
        """Return the names of the nodes of these kinds, in order."""
        return [node for node in self.nodes if self.name_of(node).kind in kinds]

    def name_of(self, node: str) -> NodeName:
        """Return the parts of a node's name."""
        return split(node, is_foreign(self.nodes[node]))

    def signal(self, node: str, name: str) -> str:
        """Return what a signal that ``node`` calls ``name`` is called in the scenario."""
        return full_name(self.name_of(node).namespace, name)

    def output_of(self, node: str) -> str | None:
        """Return the signal that ``node`` publishes, None when it publishes none."""
        output = self.nodes[node].get('output')
        return None if output is None else self.signal(node, output)

    def published_by(self, node: str) -> list[str]:
        """Return all signals that ``node`` publishes: its output, and what a block adds to it."""
        output = self.output_of(node)
        if output is None:
            return []
        ours = self.name_of(node).kind in ROLES and not is_foreign(self.nodes[node])
        return block_spec(node, self.nodes[node]).signals if ours else [output]

    def heard_by(self, node: str) -> list[str]:
        """Return what ``node`` listens to, by the names that its parameters give."""
        values = self.nodes[node]
        names = [name for name, _ in signs_of(values)] + list(values.get('signals', ()))
        return names + ([values['input']] if 'input' in values else [])

    def inputs_of(self, node: str) -> list[str]:
        """Return the signals that ``node`` listens to."""
        return [self.signal(node, name) for name in self.heard_by(node)]

    @property
    def publishers(self) -> dict[str, str]:
        """The signals that somebody publishes, and who."""
        return {signal: node for node in self.nodes for signal in self.published_by(node)}

    @property
    def outputs(self) -> list[str]:
        """The signals that have events: the output of every node that has one."""
        return [output for node in self.nodes if (output := self.output_of(node)) is not None]

    @property
    def blocks(self) -> dict[str, BlockSpec]:
        """The blocks of ours among the nodes, by the roles' order, then the file's."""
        nodes = self.with_codings().nodes
        return {
            node: block_spec(node, nodes[node])
            for role in ROLES
            for node in self.of_kind(role)
            if not is_foreign(self.nodes[node])
        }

    @property
    def stimuli(self) -> dict[str, Stimulus]:
        """The open inputs, by the signal that each publishes."""
        return {
            str(self.output_of(node)): Stimulus.from_parameters(self.nodes[node])
            for node in self.of_kind('stimulus')
        }

    @property
    def loop(self) -> Loop:
        """The loop for offline tools.

        Raises ScenarioError when there are links in it, or nodes of other packages.
        """
        if links := self.of_kind('link'):
            raise ScenarioError(
                f'scenario {self.name} has {", ".join(links)}, and links are for real nodes only; '
                f'take it without them and impair all signals with eventreg simulate --sampled '
                f'--delay D --jitter J --loss P'
            )
        if foreign := self.foreign:
            node = foreign[0]
            raise ScenarioError(
                f'scenario {self.name}: {node} is run by package {self.nodes[node]["package"]}, '
                'whose code offline tools do not know; use eventreg run'
            )
        return Loop(self.blocks, self.stimuli)

    @property
    def foreign(self) -> list[str]:
        """The nodes that are run by other packages."""
        return [node for node, values in self.nodes.items() if is_foreign(values)]

    @property
    def time_scale(self) -> float:
        """Model time units per second. Raises ScenarioError when the nodes disagree."""
        return self._common('time_scale')

    @property
    def rate(self) -> float:
        """Steps per second. Raises ScenarioError when the nodes disagree."""
        return self._common('rate')

    @property
    def criteria(self) -> Criteria:
        """What the verdict rests on, by the first spike monitor; else the defaults."""
        found = self.of_kind('spike_monitor')
        return Criteria.of(self.nodes[found[0]]) if found else Criteria()

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

    def to_yaml(self, anywhere: bool = False, namespace: str = '') -> str:
        """Return the scenario as the text of a ROS parameter file, overrides included.

        With ``anywhere`` it holds for the nodes within any further namespace; what names topics in
        full is as within ``namespace``.
        """
        prefix = '/**/' if anywhere else ''
        data = {}
        for node, values in self.given.items():
            key = f'{prefix}{node}' if anywhere or '/' not in node else f'/{node}'
            values = {moved(name, namespace): value for name, value in values.items()}
            data[key] = {'ros__parameters': values}
        return ros_yaml.dump(data)

    # What may be made of it

    def with_given(self, extra: Mapping[str, Values]) -> Scenario:
        """Return the scenario with further parameters, of its nodes or of new ones."""
        given = {node: dict(values) for node, values in self.given.items()}
        for node, values in extra.items():
            given[node] = {**given.get(node, {}), **values}
        return Scenario.of(self.name, given)

    def within(self, namespace: str) -> Scenario:
        """Return the part of the scenario within ``namespace``, its nodes and signals without it.

        The whole scenario where none of its nodes is there, as when it was itself started in that
        namespace.
        """
        home = namespace.strip('/') + '/'
        inside = {n.removeprefix(home): v for n, v in self.given.items() if n.startswith(home)}
        return Scenario.of(self.name, inside) if inside else self

    def with_criteria(self, **given: float | None) -> Scenario:
        """Return the scenario judged by those of ``given`` that are not None, else by its own."""
        wanted = {name: x for name, x in given.items() if x is not None}
        monitor = next(iter(self.of_kind('spike_monitor')), 'spike_monitor')
        return self.with_given({monitor: wanted}) if wanted else self

    def with_recorder(self, path: str, text: str, *, monitor: bool = True) -> Scenario:
        """Return the scenario with a recorder of every signal and, so asked, a spike monitor.

        ``path`` is the bag's, ``text`` the file whose text the bag shall hold, and by which the
        spike monitor judges. What else the scenario says of the two nodes stays.
        """
        signals = list(self.publishers)
        recorder = self.given.get('recorder', {})
        wanted = [s for s in recorder.get('signals', ()) if s not in signals]
        extra: Given = {}
        usual = {'signals': self.outputs, 'time_scale': self.time_scale} if monitor else {}
        if monitor or 'spike_monitor' in self.given:
            own = self.given.get('spike_monitor', {})
            usual = {n: x for n, x in usual.items() if n not in own}
            extra['spike_monitor'] = {'scenario': text, **usual}
        extra['recorder'] = {
            'signals': signals + wanted,
            'path': path,
            'scenario': text,
            'scenario_name': self.name,
        }
        return self.with_given(extra)

    def with_links(self, links: Sequence[str]) -> Scenario:
        """Return the scenario with a link node for each of ``links``, SIGNAL:NAME=VALUE,...

        The link on u is called link_u and publishes u_link, which all blocks then listen to instead
        of u; recorder and spike monitor stay with u. Raises ScenarioError or ParameterError.
        """
        return derived.with_links(self, links)

    def with_codings(self) -> Scenario:
        """Return the scenario in which every block knows how the signals that it hears are coded.

        Behind a link a signal is coded as before it.
        """
        return derived.with_codings(self)

    def in_lockstep(self, seconds: float, pauses: Sequence[float] = ()) -> Scenario:
        """Return the scenario with a clock, all nodes in lockstep, for simulated ``seconds``.

        The clock waits at each of ``pauses``, simulated seconds. An input that nobody publishes is
        left out, since nobody would send the sample to wait for. Links are left out too: the blocks
        behind them take every sample as late as the link would make it. Raises EventregError when
        there is not one step in ``seconds``, a second clock, or a link that does more than delay.
        """
        return derived.in_lockstep(self, seconds, pauses)

    def with_stated_delays(self) -> Scenario:
        """Return the scenario without its links, their delays stated by the blocks behind them.

        Raises ScenarioError when a link does more than delay.
        """
        return derived.with_stated_delays(self)


def _in_full(node: str, given: Values) -> Values:
    """Return parameters with the files of our own nodes by their full paths."""
    return {
        name: from_file(value, Path()) if _is_file(node, name, value, given) else value
        for name, value in given.items()
    }


def _is_file(node: str, name: str, value: object, given: Values) -> bool:
    return isinstance(value, str) and names_file(node, name) and not is_foreign(given)
