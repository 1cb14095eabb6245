# SPDX-License-Identifier: Apache-2.0
"""What the Tab key offers in a shell, by argcomplete: commands, options, scenarios, parameters.

``eval "$(register-python-argcomplete eventreg)"`` switches it on; the shell then calls ``eventreg``
with the line so far in its environment.
"""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Callable, Iterable

from ..errors import EventregError
from ..scenario import Scenario, load, shipped
from ..scenario.names import KINDS
from ..scenario.parameter import ACTIVE, Parameter
from ..scenario.parameters import parameters_of
from .main import VERBS, build_parser

Completer = Callable[..., Iterable[str]]


def offer() -> None:
    """Write what may stand where the cursor is, for the shell, and end the process.

    Without argcomplete nothing is offered.
    """
    try:
        import argcomplete
    except ImportError:
        os._exit(1)
    argcomplete.autocomplete(parser(os.environ.get('COMP_LINE', '')))
    os._exit(1)


def parser(line: str) -> argparse.ArgumentParser:
    """Return the parser for a command line as far as it was typed, each argument with its words."""
    verb = next((word for word in _words(line)[1:] if not word.startswith('-')), None)
    whole = build_parser(verb if verb in VERBS else None)
    for action in _actions(whole, verb):
        completer = COMPLETERS.get((verb, str(action.metavar)), COMPLETERS.get(action.metavar))
        if completer is not None:
            action.completer = completer  # type: ignore[attr-defined]
    return whole


def _words(line: str) -> list[str]:
    try:
        return shlex.split(line)
    except ValueError:  # a quotation mark without its second
        return line.split()


def _actions(whole: argparse.ArgumentParser, verb: str | None) -> list[argparse.Action]:
    verbs = next(a for a in whole._actions if isinstance(a, argparse._SubParsersAction))
    return list(verbs.choices[verb]._actions) if verb in verbs.choices else []


def scenarios(prefix: str, **_: object) -> list[str]:
    """Return the shipped scenarios, and the parameter files and directories that begin so."""
    from argcomplete.completers import FilesCompleter

    return [*shipped(), *FilesCompleter(('yaml', 'yml'))(prefix)]


def runs(prefix: str, **_: object) -> list[str]:
    """Return what may be a bag or a scenario."""
    from argcomplete.completers import FilesCompleter

    return [*shipped(), *FilesCompleter()(prefix)]


def overrides(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """Return NODE.PARAM:= of the scenario on the line; behind := the values where they are few."""
    scenario = _scenario(parsed_args)
    if scenario is None:
        return []
    name, assigned, _rest = prefix.partition(':=')
    if assigned:
        node, _dot, parameter = name.partition('.')
        values = scenario.nodes.get(node, {})
        row = parameters_of(node, values).get(parameter) if values else None
        return [f'{name}:={value}' for value in _values(row)]
    nodes = {node: parameters_of(node, values) for node, values in scenario.nodes.items()}
    return [f'{node}.{row}:=' for node, rows in nodes.items() for row in rows if '*' not in row]


def parameters(prefix: str, **_: object) -> list[str]:
    """Return NODE.PARAM of the usual nodes, as far as they can be set while running."""
    live = [(kind, row) for kind in KINDS for row in parameters_of(kind).values()]
    return [f'{kind}.{row.name}' for kind, row in live if row.settable == ACTIVE]


def signals(prefix: str, parsed_args: argparse.Namespace, **_: object) -> list[str]:
    """Return the signals of the scenario on the line, behind those that stand there already."""
    scenario = _scenario(parsed_args)
    before, comma, _last = prefix.rpartition(',')
    known = scenario.loop.signals if scenario else []
    return [f'{before}{comma}{signal}' for signal in known if signal not in before.split(',')]


def nodes(prefix: str, **_: object) -> list[str]:
    """Return the kinds of nodes."""
    return list(KINDS)


def figures(prefix: str, **_: object) -> list[str]:
    """Return the names of the figures."""
    from ..paper import FIGURES

    return list(FIGURES)


def _scenario(parsed_args: argparse.Namespace) -> Scenario | None:
    try:
        return load(parsed_args.scenario)
    except (EventregError, AttributeError, TypeError):
        return None


def _values(row: Parameter | None) -> list[str]:
    if row is None:
        return []
    return ['true', 'false'] if row.type == 'bool' else list(row.allowed)


COMPLETERS: dict[object, Completer] = {
    'SCENARIO': scenarios,
    ('analyze', 'S'): scenarios,
    ('identify', 'S'): scenarios,
    'RUN': runs,
    'BAG_OR_SCENARIO': runs,
    'NODE.PARAM:=VALUE': overrides,
    'NODE.PARAM': parameters,
    'NODE': nodes,
    'SIGNAL': signals,
    'SIGNAL,...': signals,
    ('figures', 'NAME'): figures,
}
"""What completes an argument, by what its help calls it, for all commands or for one."""
