# SPDX-License-Identifier: Apache-2.0
"""What a node was given, as it is meant: its arguments and parameter files before rcl reads them.

rcl takes an unquoted y for true, which launch files and ``ros2 param dump`` write for the signal y,
and fails on a list that holds it. So signals are quoted here. A file that a parameter file names is
looked for beside it. What is no readable file is refused rather than waited for.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ..errors import EventregError, ScenarioError
from ..files import UnreadableError, read_text, scratch_directory
from ..scenario import ros_yaml
from ..scenario.names import NAMING
from ..scenario.parameters import all_parameters, is_ros_parameter

FILE, PARAMETER = ('--params-file',), ('-p', '--param')


@contextmanager
def as_meant(arguments: Sequence[str]) -> Iterator[list[str]]:
    """Yield command-line arguments for rcl; files that it needs are there until the block ends.

    Raises EventregError for a parameter file that cannot be read or gives a parameter twice.
    """
    with ExitStack() as stack:
        result = list(arguments)
        for i, word in _ros_values(arguments):
            if arguments[i - 1] in PARAMETER:
                result[i] = _quoted(word)
            elif arguments[i - 1] in FILE:
                result[i] = _file(word, stack)
        yield result


def check_values(arguments: Sequence[str]) -> None:
    """Raise ScenarioError for a value behind -p that rcl refuses, which logs a line of its own."""
    for i, word in _ros_values(arguments):
        found = re.fullmatch(r'(?:[^:]+:(?!=))?([^:]+):=(.*)', word, re.DOTALL)
        if arguments[i - 1] in PARAMETER and found is not None:
            ros_yaml.value(found[2], f'-p {word}', found[1])


def refusal(arguments: Sequence[str]) -> str | None:
    """Return why a parameter file among ``arguments`` is refused, in our words; None: it is not."""
    try:
        for i, word in _ros_values(arguments):
            if arguments[i - 1] in FILE:
                ros_yaml.load(_text(word), f'--params-file {word}')
    except ScenarioError as error:
        return str(error)
    return None


def _ros_values(arguments: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Yield place and text of every argument behind --ros-args but the first."""
    ros = False
    for i, word in enumerate(arguments):
        if ros and i and word != '--':
            yield i, word
        ros = (ros and word != '--') or word == '--ros-args'


def _quoted(rule: str) -> str:
    """Return [NODE:]NAME:=VALUE with quotes around signals called y or n."""
    found = re.fullmatch(r'((?:[^:]+:(?!=))?([^:]+)):=(.+)', rule, re.DOTALL)
    if found is None or found[2] not in NAMING:
        return rule
    return f'{found[1]}:={ros_yaml.quoted_value(found[3], found[2])}'


def _file(path: str, stack: ExitStack) -> str:
    """Return ``path``, or the path of a copy that says what is meant."""
    text = _text(path)
    meant = ros_yaml.as_meant(text, f'--params-file {path}', _known, Path(path).parent)
    if meant == text:
        return path
    directory = stack.enter_context(scratch_directory())
    copy = directory / (Path(path).name or 'parameters.yaml')
    copy.write_text(meant, encoding='utf-8')
    return str(copy)


def _known(parameter: str) -> bool:
    return is_ros_parameter(parameter) or parameter in all_parameters()


def _text(path: str) -> str:
    try:
        return read_text(path)
    except UnreadableError as error:
        raise EventregError(f'--params-file {path}: {error}') from None
