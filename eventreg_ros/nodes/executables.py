# SPDX-License-Identifier: Apache-2.0
"""What an executable does before there is a node: --help, wrong arguments, no ROS."""

from __future__ import annotations

import ast
import importlib
import os
import sys
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

from ..errors import EventregError, complain, ros_is_missing
from ..scenario.parameter import Parameter
from ..scenario.parameters import parameters_of
from . import environment

HELP = ('-h', '--help')


def run(node: str, arguments: Sequence[str]) -> int:
    """Run ``node`` with command-line ``arguments`` until SIGINT or SIGTERM; return its exit code.

    0 after --help, 2 and one line after a wrong argument, or where there is no ROS.
    """
    if words := own_words(arguments):
        source = Path(__file__).with_name(f'{node}.py').read_text(encoding='utf-8')
        rows = parameters_of(node).values()
        return answer(words[0], node, ast.get_docstring(ast.parse(source)), rows)
    try:
        environment.check(os.environ)
        module = importlib.import_module(f'.{node}', __package__)
    except EventregError as error:
        return complain('eventreg_ros', error)
    except ImportError as error:
        return complain('eventreg_ros', ros_is_missing(node, error))
    sys.argv = [node, *arguments]
    return int(module.main())


def own_words(arguments: Sequence[str]) -> list[str]:
    """Return the arguments that are not ROS's: outside of ``--ros-args ... [--]``, and help."""
    words: list[str] = []
    ros = False
    for word in arguments:
        if word == '--ros-args':
            ros = True
        elif not ros or word in HELP:
            words.append(word)
        elif word == '--':
            ros = False
    return words


def answer(word: str, name: str, what: str | None, rows: Iterable[Parameter] = ()) -> int:
    """Answer ``word``, which is not ROS's: --help, or a mistake; return the exit code.

    ``what`` says in words what the node called ``name`` is, ``rows`` are its parameters.
    """
    if word in HELP:
        print(_help(name, what or name, rows))
        return 0
    return complain(
        'eventreg_ros',
        f'{name}: unknown argument {word!r}; parameters go behind --ros-args, as in '
        f'--ros-args -p NAME:=VALUE; see {name} --help',
    )


def _help(name: str, what: str, rows: Iterable[Parameter]) -> str:
    lines = [
        f'usage: {name} [--ros-args [-p NAME:=VALUE]... [--params-file FILE] [-r FROM:=TO]...]',
        f'\n{what}\n',
    ]
    if listed := [_described(row) for row in rows]:
        lines += ['Parameters, with their defaults:', *listed, '']
    lines.append(f'While it runs: ros2 node info /{name}, ros2 param describe /{name} NAME.')
    return '\n'.join(lines)


def _described(parameter: Parameter) -> str:
    line = f'{parameter.name} = {shown(parameter.default)}: {parameter.doc} ({parameter.rule})'
    return textwrap.fill(line, 100, initial_indent='  ', subsequent_indent='      ')


def shown(value: object) -> str:
    """Return a default as ROS writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f'[{", ".join(map(shown, value))}]'
    return f'{value:g}' if isinstance(value, float) else str(value) or "''"
