# SPDX-License-Identifier: Apache-2.0
"""YAML as ROS's own parser reads it, and no other.

In one thing this is stricter than rcl: a parameter that a node is given twice in a file, of which
rcl takes the one or the other, is refused. And it is kinder: where signals are named, an unquoted y
or n is a name, since that is how launch files and ``ros2 param dump`` write it. Nodes do both to
what they are given (nodes/given.py).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ..errors import ScenarioError, shown
from .files import from_file, names_file
from .names import NAMING
from .rcl_parser import Parser, RefusedError, Section, Value
from .rcl_scalar import scalar


def load(text: str, name: str) -> list[Section]:
    """Return what ``text`` says of which nodes. Raises ScenarioError, which names ``name``."""
    parser = _parser()
    sections: list[Section] = _read(name, text, lambda: parser.file(_events(text)))
    _need_once(name, parser)
    if parser.empty:
        raise ScenarioError(
            f'{name}: {shown(parser.empty[0])} must hold ros__parameters: and below it one line '
            'per parameter'
        )
    return sections


def value(text: str, name: str, parameter: str) -> Value:
    """Return the value that ``text`` gives to ``parameter``. Raises ScenarioError."""
    if not text:
        raise ScenarioError(f'{name} has no value; write it behind :=')
    found: Value = _read(name, text, lambda: _parser().value(_events(text), parameter))
    return found


def as_meant(text: str, name: str, known: Callable[[str], bool], base: Path) -> str:
    """Return a file in ``base`` with quotes around signals called y or n, and with full paths.

    What rcl refuses is returned as it is, for rcl to refuse it. Raises ScenarioError where a
    parameter that is ``known`` is given twice.
    """
    import yaml

    text, parser = text.removeprefix('\ufeff'), _parser()
    try:
        parser.file(_events(text))
    except (RefusedError, yaml.YAMLError):
        return text
    _need_once(name, parser, known)
    return _with_quotes(text, parser, base)


def quoted_value(text: str, parameter: str) -> str:
    """Return the value of ``parameter`` with quotes around signals called y or n."""
    import yaml

    parser = _parser()
    try:
        parser.value(_events(text), parameter)
    except (RefusedError, yaml.YAMLError):
        return text
    return _with_quotes(text, parser)


def _with_quotes(text: str, parser: Parser, base: Path | None = None) -> str:
    files = [(held, from_file(held.text, base)) for held in parser.files if base is not None]
    for held, meant in sorted([(held, held.text) for held in parser.names] + files, reverse=True,
                              key=lambda pair: pair[0].start):  # fmt: skip
        word = meant.replace("'", "''")
        text = f"{text[: held.start]}'{word}'{text[held.end :]}"
    return text


def _need_once(name: str, parser: Parser, known: Callable[[str], bool] | None = None) -> None:
    for parameter, line in parser.twice:
        if known is None or known(parameter):
            raise ScenarioError(f'{name}, line {line}: {shown(parameter)} is given twice; keep one')


def dump(data: Any) -> str:
    """Return ``data`` as text that ROS reads as it is meant."""
    import yaml

    class Dumper(yaml.SafeDumper):
        """Quotes every string that rcl would take for something else; writes no aliases."""

        def ignore_aliases(self, data: Any) -> bool:
            return True

        def nothing(self, data: None) -> Any:
            return self.represent_list([])

        def string(self, text: str) -> Any:
            style = None if isinstance(scalar(text), str) else "'"
            return self.represent_scalar('tag:yaml.org,2002:str', text, style)

        def number(self, value: float) -> Any:
            if 0.0 < abs(value) < sys.float_info.min:  # rcl takes no decimals so small
                return self.represent_scalar('tag:yaml.org,2002:str', value.hex())
            return self.represent_float(value)

    Dumper.add_representer(str, Dumper.string)
    Dumper.add_representer(float, Dumper.number)
    Dumper.add_representer(type(None), Dumper.nothing)
    return str(yaml.dump(data, Dumper=Dumper, sort_keys=False, default_flow_style=None))


def _parser() -> Parser:
    return Parser(lambda parameter: parameter in NAMING, names_file)


def _read(name: str, text: str, read: Callable[[], Any]) -> Any:
    import yaml

    try:
        return read()
    except RefusedError as error:
        where = '' if error.line is None else f', line {error.line}'
        raise ScenarioError(
            f'{name}{where}: ROS refuses it: {error}{REMEDIES.get(str(error)[:10], "")}'
        ) from None
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or str(error).splitlines()[0]
        if mark and '\t' in ''.join(text.splitlines()[mark.line : mark.line + 1]):
            problem += ' (indent with spaces, not tabs)'
        raise ScenarioError(f'{name}{where}: not valid YAML: {problem}') from None


REMEDIES = {
    'Sequences ': '; write NODE:, below it ros__parameters:, and below that the parameters',
    'Will not s': '; write the value out where *NAME stands',
    'Sequence s': '; give all entries one type: 1.0 beside 0.5, quotes around words',
    'No value': "; write one, or '' for an empty string",
    'Cannot hav': '; a node must hold ros__parameters: and below it one line per parameter',
}
"""What to do, by the first letters of rcl's reason."""


def _events(text: str) -> Iterator[Any]:
    """Return libyaml's events, which is what rcl reads. Raises RefusedError for what is no text."""
    import yaml

    try:
        text.encode()
    except UnicodeEncodeError:  # bytes of a command line
        raise RefusedError('it is not valid UTF-8') from None
    loader = yaml.CSafeLoader if yaml.__with_libyaml__ else yaml.SafeLoader
    return iter(yaml.parse(text, Loader=loader))
