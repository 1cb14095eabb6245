# SPDX-License-Identifier: Apache-2.0
"""A parameter file as rcl reads it: event by event, with the same state and the same refusals.

After parse_file_events, parse_key and parse_value in rcl_yaml_param_parser/src/parse.c of Jazzy,
and its namespace.c. What rcl does with odd files (a mapping within a list, an empty one, two
documents) follows from its few variables, and so it does here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..errors import shown
from .rcl_scalar import Scalar, scalar

PARAMETERS = 'ros__parameters'

MOST, MOST_ENTRIES = 1000, 10_000
"""Of nodes, and parameters of a node; and of entries of a list: beyond, rcl takes for ever."""

_NAME = re.compile(r'/?((\*\*?|[A-Za-z_][A-Za-z0-9_]*)/)*(\*\*?|[A-Za-z_][A-Za-z0-9_]*)')

_TYPES = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}
_ORDER = (bool, int, float, str)
"""Of several values that rcl holds of one parameter it hands over the first type's."""

Value = bool | int | float | str | list[bool] | list[int] | list[float] | list[str] | None


class RefusedError(Exception):
    """rcl refuses the file: its reason, and the line."""

    def __init__(self, reason: str, line: int | None = None) -> None:
        super().__init__(reason)
        self.line = line


class Held(NamedTuple):
    """A scalar that stands where a name is meant, with its place in the text."""

    text: str
    start: int
    end: int


@dataclass
class Parameter:
    """A parameter of a section as rcl holds it: a value or a list of each type."""

    name: str
    single: dict[type, Scalar] = field(default_factory=dict)
    several: dict[type, list[Any]] = field(default_factory=dict)

    @property
    def given(self) -> bool:
        """Whether there is a value."""
        return bool(self.single or self.several)

    @property
    def value(self) -> Value:
        """What a node is given; None for a parameter that is there without any value."""
        for held in (self.single, self.several):
            for kind in _ORDER:
                if kind in held:
                    return held[kind]
        return None


class Section(NamedTuple):
    """What a file says of the nodes called ``name``, which may hold wildcards."""

    name: str
    parameters: list[Parameter]

    @property
    def values(self) -> dict[str, Value]:
        """The parameters as a node is given them."""
        return {parameter.name: parameter.value for parameter in self.parameters}


class Parser:
    """Reads the events of one file, or of the value of one -p.

    ``is_name`` says of a parameter whether it names signals: there an unquoted y, Y, n or N is
    meant as written. rcl takes it for true or false; a node's own arguments are quoted before rcl
    sees them, at the places in ``names``. ``is_file`` says of a section and a parameter whether it
    names a file to read; those are in ``files``. ``empty`` are the nodes without any
    ros__parameters, ``twice`` the parameters that were given a second time, and the lines.
    """

    def __init__(
        self, is_name: Callable[[str], bool], is_file: Callable[[str, str], bool] | None = None
    ) -> None:
        self._is_name, self._is_file = is_name, is_file or (lambda section, parameter: False)
        self.sections: list[Section] = []
        self.names: list[Held] = []
        self.files: list[Held] = []
        self.empty: list[str] = []
        self.twice: list[tuple[str, int]] = []
        self._named: str | None = None
        self._spaces: list[str] = []
        self._node = _Namespace('/')
        self._prefix = _Namespace('.')
        self._in_parameters = self._is_sequence = self._is_new_map = False
        self._is_key = True
        self._depth = 0
        self._section: Section | None = None
        self._index = 0  # of the parameter, within whatever section it is by now
        self._sequence_type: type | None = None

    def file(self, events: Iterator[Any]) -> list[Section]:
        """Return the sections of a file. Raises RefusedError."""
        for event in events:
            line = event.start_mark.line + 1
            handler = getattr(self, '_on_' + type(event).__name__, None)
            if handler is not None:
                handler(event, line)
        return self.sections

    def value(self, events: Iterator[Any], parameter: str) -> Value:
        """Return the value of one parameter. Raises RefusedError."""
        self._section = Section('', [Parameter(parameter)])
        for event in events:
            kind = type(event).__name__
            if kind in ('MappingStartEvent', 'MappingEndEvent', 'AliasEvent'):
                raise RefusedError('a value must be a scalar or a list of them')
            if kind == 'ScalarEvent':
                self._take_value(event, 1)
            elif kind in ('SequenceStartEvent', 'SequenceEndEvent'):
                self._is_sequence = kind == 'SequenceStartEvent'
                self._sequence_type = None
        return self._section.parameters[0].value

    # Events

    def _on_ScalarEvent(self, event: Any, line: int) -> None:  # noqa: N802
        if self._is_key:
            self._take_key(event.value, line)
            self._is_key = False
            return
        if not self._in_parameters or self._section is None or not self._section.parameters:
            raise RefusedError(f'Cannot have a value before {PARAMETERS}', line)
        self._take_value(event, line)
        if not self._is_sequence:
            self._is_key = True

    def _on_SequenceStartEvent(self, event: Any, line: int) -> None:  # noqa: N802
        if self._is_key:
            raise RefusedError('Sequences cannot be key', line)
        if not self._in_parameters:
            raise RefusedError('Sequences can only be values and not keys in params', line)
        self._is_sequence, self._sequence_type = True, None

    def _on_SequenceEndEvent(self, event: Any, line: int) -> None:  # noqa: N802
        self._is_sequence, self._is_key = False, True

    def _on_MappingStartEvent(self, event: Any, line: int) -> None:  # noqa: N802
        self._depth += 1
        self._is_key = True
        # The map of ros__parameters itself gives no prefix.
        self._is_new_map = not (self._in_parameters and self._depth - self._node.count - 1 == 2)

    def _on_MappingEndEvent(self, event: Any, line: int) -> None:  # noqa: N802
        if self._in_parameters:
            if self._prefix.count:
                self._prefix.remove()
            else:
                self._in_parameters = False
        elif self._depth == self._node.count + 1:
            self._node.remove()
            self.empty += [self._named] if self._named else []
            self._named = None
        self._depth -= 1

    def _on_AliasEvent(self, event: Any, line: int) -> None:  # noqa: N802
        raise RefusedError('Will not support aliasing', line)

    # Keys and values

    def _take_key(self, key: str, line: int) -> None:
        if not key:
            raise RefusedError('No key', line)
        if self._in_parameters:
            self._take_parameter(key, line)
        elif not key.startswith(PARAMETERS):
            self._node.add(key)
            self._named = self._node.text
        elif not self._node.count:
            raise RefusedError(f'There are no node names before {PARAMETERS}', line)
        else:
            self._section = self._section_of(self._node.text, line)
            self._node.remove()
            self._in_parameters, self._named = True, None

    def _section_of(self, name: str, line: int) -> Section:
        if not _NAME.fullmatch(name):
            raise RefusedError(f'{shown(name)} is no name of a node', line)
        for section in self.sections:
            if section.name == name:
                return section
        if len(self.sections) == MOST:
            raise RefusedError(f'more than {MOST} nodes', line)
        self.sections.append(Section(name, []))
        return self.sections[-1]

    def _take_parameter(self, key: str, line: int) -> None:
        assert self._section is not None
        if self._is_new_map:
            if not self._parameter.name:
                raise RefusedError('Internal error creating param namespace', line)
            self._prefix.replace(self._parameter.name)
            self._is_new_map = False
        prefix = self._prefix.text
        self._find(prefix or key)
        if prefix:
            self._parameter.name = f'{prefix}.{key}'
        names = [parameter.name for parameter in self._section.parameters]
        if self._parameter.given or names.count(self._parameter.name) > 1:
            self.twice.append((self._parameter.name, line))

    def _find(self, name: str) -> None:
        assert self._section is not None
        names = [parameter.name for parameter in self._section.parameters]
        self._index = names.index(name) if name in names else len(names)
        if self._index == len(names):
            if len(names) == MOST:
                raise RefusedError(f'more than {MOST} parameters of one node')
            self._section.parameters.append(Parameter(name))

    @property
    def _parameter(self) -> Parameter:
        """The parameter that a value is for; a nameless one where there is none."""
        assert self._section is not None
        known = self._section.parameters
        return known[self._index] if self._index < len(known) else Parameter('')

    def _take_value(self, event: Any, line: int) -> None:
        parameter = self._parameter
        quoted = event.style in ("'", '"')
        if not (event.value or quoted):
            raise RefusedError('No value', line)
        value = event.value if quoted or event.tag == 'tag:yaml.org,2002:str' else None
        if value is None:
            value = self._plain(event)
        kind = type(value)
        where = self._section.name if self._section else ''
        if isinstance(value, str) and self._is_file(where, parameter.name):
            self.files.append(Held(value, event.start_mark.index, event.end_mark.index))
        if not self._is_sequence:
            parameter.single[kind] = value
            return
        if self._sequence_type is None:
            self._sequence_type = kind
            parameter.several[kind] = []
        elif self._sequence_type is not kind:
            raise RefusedError(
                f"Sequence should be of same type. Value type '{_TYPES[kind]}' do not belong", line
            )
        if len(parameter.several[kind]) == MOST_ENTRIES:
            raise RefusedError(f'a list of more than {MOST_ENTRIES} entries', line)
        parameter.several[kind].append(value)

    def _plain(self, event: Any) -> Scalar:
        """Return a scalar that is not quoted, and note it where a signal has such a name."""
        if event.value in ('y', 'Y', 'n', 'N') and self._is_name(self._parameter.name):
            self.names.append(Held(event.value, event.start_mark.index, event.end_mark.index))
            return str(event.value)
        return scalar(event.value)


class _Namespace:
    """Names joined by a separator, with rcl's own count of them."""

    def __init__(self, separator: str) -> None:
        self._separator, self.text, self.count = separator, '', 0

    def add(self, name: str) -> None:
        separator = '' if not self.count or self.text.endswith(self._separator) else self._separator
        self.text = self.text + separator + name if self.count else name
        self.count += 1

    def remove(self) -> None:
        if self.count > 1:
            head, found, _ = self.text.rpartition(self._separator)
            self.text = head if found else self.text
        elif self.count:
            self.text = ''
        self.count = max(self.count - 1, 0)

    def replace(self, text: str) -> None:
        self.text, self.count = text, self.count + 1
