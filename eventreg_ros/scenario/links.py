"""Links on signals: a scenario in which delay, loss and jitter come between its blocks."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any

from ..errors import EventregError, ParameterError, ScenarioError
from ..models.roles import ROLES
from . import Scenario
from .parameter import Parameter
from .parameters import NODES, hint, kind_of, resolve

OPTIONS = {p.name: p for p in NODES['link'] if p.name not in ('input', 'output', 'autostart')}
"""The parameters of the link node that --link may set."""


def add_link(parser: argparse.ArgumentParser) -> None:
    """Add --link."""
    parser.add_argument(
        '--link', action='append', default=[], dest='links', metavar='SIGNAL:NAME=VALUE,...',
        help='put a link on a signal, before all blocks that listen to it; of '
        + ', '.join(OPTIONS) + ' (seconds, probabilities); may be repeated',
    )  # fmt: skip


def with_links(scenario: Scenario, links: Sequence[str]) -> Scenario:
    """Return ``scenario`` with a link node for each of ``links``, SIGNAL:NAME=VALUE,...

    The link on u is called link_u and publishes u_link, which all blocks then listen to instead of
    u; recorder and spike monitor stay with u. Raises ScenarioError or ParameterError.
    """
    for link in links:
        signal, options = parse(link)
        scenario = _with_link(scenario, signal, options, f'--link {link}')
    return scenario


def parse(link: str) -> tuple[str, dict[str, Any]]:
    """Return signal and options of SIGNAL:NAME=VALUE,NAME=VALUE. Raises ParameterError."""
    signal, _, rest = link.partition(':')
    if not signal:
        raise ParameterError(f'--link must be SIGNAL:NAME=VALUE,... (u:delay=0.02), got {link!r}')
    options: dict[str, Any] = {}
    for option in filter(None, rest.split(',')):
        name, equals, text = option.partition('=')
        if not equals or name in options:
            raise ParameterError(
                f'--link {link}: give each option once as NAME=VALUE, got {option!r}'
            )
        if name not in OPTIONS:
            raise ParameterError(f'--link {link}: no option {name!r}{hint(name, OPTIONS)}')
        options[name] = OPTIONS[name].check(f'--link {signal}', _value(OPTIONS[name], text))
    return signal, options


def _value(parameter: Parameter, text: str) -> Any:
    """Return ``text`` as a number where one is meant; what is none is left for the check."""
    try:
        return {'double': float, 'int': int}.get(parameter.type, str)(text)
    except ValueError:
        return text


def _with_link(scenario: Scenario, signal: str, options: dict[str, Any], where: str) -> Scenario:
    if signal not in scenario.publishers:
        raise ScenarioError(
            f'{where}: nobody publishes {signal!r}{hint(signal, scenario.publishers)}'
        )
    name = 'link_' + re.sub(r'\W', '_', signal.strip('/'))
    output = f'{signal}_link'
    if name in scenario.nodes or output in scenario.publishers:
        raise ScenarioError(
            f'{where}: the scenario {scenario.name} has a {name} already; '
            f'set it with -p {name}.NAME:=VALUE'
        )
    given = {node: dict(values) for node, values in scenario.given.items()}
    rewired = 0
    for node in ROLES.keys() & given.keys():
        for key in ('excitatory', 'inhibitory'):
            inputs = scenario.nodes[node][key]
            if signal in inputs:
                given[node][key] = [output if s == signal else s for s in inputs]
                rewired += 1
    if not rewired:
        raise ScenarioError(f'{where}: no block listens to {signal!r}; leave the link out')
    given[name] = {'input': signal, 'output': output, **options}
    nodes = {node: resolve(node, values) for node, values in given.items()}
    return Scenario(scenario.name, nodes, given)


def need_real_time(scenario: Scenario) -> None:
    """Raise EventregError when ``scenario`` has links, whose delays lockstep knows nothing of."""
    links = [node for node in scenario.nodes if kind_of(node) == 'link']
    if links:
        raise EventregError(
            f'lockstep waits for every sample, so that {", ".join(links)} could delay nothing; '
            f'leave out --lockstep'
        )
