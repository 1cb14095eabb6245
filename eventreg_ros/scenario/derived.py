# SPDX-License-Identifier: Apache-2.0
"""How one scenario becomes another: with links, with coded signals, in lockstep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..errors import EventregError, ScenarioError
from ..simulation.model_time import count_steps
from .inputs import signs_of
from .links import LinkSpec, link_name, need_pure_delay
from .names import full_name

if TYPE_CHECKING:
    from .scenario import Scenario

Given = dict[str, dict[str, Any]]
"""Parameters by node, as somebody gave them."""

HEARD = ('excitatory', 'inhibitory', 'plant_inputs')
INPUTS = (*HEARD, 'signals')
"""Parameters that list signals to listen to."""


def with_links(scenario: Scenario, links: Sequence[str]) -> Scenario:
    """See :meth:`.Scenario.with_links`."""
    for link in map(LinkSpec.read, links):
        scenario = _with_link(scenario, link)
    return scenario


def _with_link(scenario: Scenario, link: LinkSpec) -> Scenario:
    link.need_publisher(scenario.publishers)
    name, output = link_name(link.signal), f'{link.signal}_link'
    if name in scenario.nodes or output in scenario.publishers:
        raise ScenarioError(
            f'{link.where}: the scenario {scenario.name} has a {name} already; '
            f'set it with -p {name}.NAME:=VALUE'
        )
    extra: Given = {}
    for node in scenario.nodes:
        home = scenario.name_of(node).namespace
        for key in HEARD:
            inputs = scenario.nodes[node].get(key, [])
            if link.signal in (full_name(home, s) for s in inputs):
                extra.setdefault(node, {})[key] = [
                    f'{s}_link' if full_name(home, s) == link.signal else s for s in inputs
                ]
    if not extra:
        raise ScenarioError(
            f'{link.where}: no block listens to {link.signal!r}; leave the link out'
        )
    extra[name] = {'input': link.signal, 'output': output, **link.options}
    return scenario.with_given(extra)


def with_codings(scenario: Scenario) -> Scenario:
    """See :meth:`.Scenario.with_codings`."""
    coded: dict[str, tuple[str, str]] = {}
    for node, values in scenario.nodes.items():
        signal = scenario.output_of(node)
        if signal is not None and values.get('coding') == 'spikes':
            coded[signal] = ('spike_inputs', f':{values["tau"]!r}')
        elif signal is not None and values.get('send_on_delta'):
            coded[signal] = ('held_inputs', '')
    for link in scenario.of_kind('link') if coded else ():
        source, output = (
            scenario.signal(link, scenario.nodes[link][k]) for k in ('input', 'output')
        )
        coded |= {output: coded[source]} if source in coded else {}
    extra: Given = {}
    for node in scenario.nodes if coded else ():
        for name, _ in signs_of(scenario.nodes[node]):
            key, suffix = coded.get(scenario.signal(node, name), ('', ''))
            known: list[str] = list(scenario.nodes[node].get(key, ()))
            if key and not any(name in (each, each.rpartition(':')[0]) for each in known):
                mine = extra.setdefault(node, {})
                mine[key] = [*list(mine.get(key, known)), name + suffix]
    return scenario.with_given(extra) if extra else scenario


def in_lockstep(scenario: Scenario, seconds: float, pauses: Sequence[float] = ()) -> Scenario:
    """See :meth:`.Scenario.in_lockstep`."""
    for node in scenario.of_kind('clock'):
        if node != 'clock':
            raise ScenarioError(
                f'{node}: a run in lockstep has one clock, called clock; '
                f'name the node clock, or leave it out'
            )
    if scenario.of_kind('link'):
        return in_lockstep(with_stated_delays(scenario), seconds, pauses)
    steps = count_steps(seconds * scenario.time_scale, scenario.time_scale / scenario.rate, 0)
    if not steps:
        raise EventregError(
            f'{seconds:g} s hold not one step of 1 / {scenario.rate:g} s; take a longer --duration'
        )
    others = [node for node in scenario.nodes if scenario.name_of(node).kind != 'clock']
    extra = {node: _lockstep_values(scenario, node) for node in others}
    patience = max(scenario.nodes[node].get('lockstep_timeout', 0.0) for node in others)
    extra['clock'] = {
        # a monitor of no signal has no step to make
        'participants': [node for node in others if extra[node].get('signals') != []],
        'steps': steps,
        'rate': scenario.rate,
        'pause_at': [at for at in pauses if at < seconds],
        'lockstep_timeout': scenario.given.get('clock', {}).get('lockstep_timeout', patience),
    }
    return scenario.with_given(extra)


def with_stated_delays(scenario: Scenario) -> Scenario:
    """See :meth:`.Scenario.with_stated_delays`."""
    behind: dict[str, tuple[str, float]] = {}
    for link in scenario.of_kind('link'):
        values = scenario.nodes[link]
        need_pure_delay(link, values)
        source = scenario.signal(link, values['input'])
        before, earlier = behind.get(source, (source, 0.0))
        delay = earlier + values['delay'] * scenario.time_scale
        behind[scenario.signal(link, values['output'])] = (before, delay)
    given = {n: dict(v) for n, v in scenario.given.items() if scenario.name_of(n).kind != 'link'}
    for node, values in given.items():
        home = scenario.name_of(node).namespace
        for key in (k for k in (*HEARD, 'held_inputs') if k in scenario.nodes[node]):
            found = [behind.get(full_name(home, s), (s, 0.0)) for s in scenario.nodes[node][key]]
            values[key] = [signal.removeprefix(f'{home}/') for signal, _ in found]
            late = [f'{s.removeprefix(f"{home}/")}:{delay!r}' for s, delay in found if delay]
            if key in HEARD:
                values['lockstep_delays'] = values.get('lockstep_delays', []) + late
    return type(scenario).of(scenario.name, given)


def _lockstep_values(scenario: Scenario, node: str) -> dict[str, Any]:
    values: dict[str, Any] = {'lockstep': True, 'use_sim_time': True, 'rate': scenario.rate}
    for key in INPUTS:
        if key in scenario.nodes[node]:
            values[key] = [
                name
                for name in scenario.nodes[node][key]
                if scenario.signal(node, name) in scenario.publishers
            ]
    return values
