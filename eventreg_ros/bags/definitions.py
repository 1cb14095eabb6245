# SPDX-License-Identifier: Apache-2.0
"""Message types: what fields they have, from the definition in the bag or from ROS's own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ..errors import BagError
from .channel import Channel

SIZES = {
    'bool': 1, 'byte': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2, 'int32': 4,
    'uint32': 4, 'float32': 4, 'int64': 8, 'uint64': 8, 'float64': 8,
}  # fmt: skip
"""Bytes of each type of number."""

_LONGEST = 2**18
_DEEPEST = 16
_PART = r'[A-Za-z_]\w*(\[[0-9]{1,9}\])*'
_STEP = re.compile(r'([A-Za-z_]\w*)|\[([0-9]{1,9})\]', re.ASCII)
_WAY = re.compile(rf'{_PART}(\.{_PART})*', re.ASCII)
_ASIDE = ('header', 'layout')


class Base(NamedTuple):
    """A number, a string, or another type without parts."""

    name: str


class Named(NamedTuple):
    """A message within a message."""

    name: str


class Many(NamedTuple):
    """An array of ``size`` items, or a sequence of any number where that is None."""

    of: Base | Named
    size: int | None


Kind = Base | Named | Many
Types = Mapping[str, tuple[tuple[str, Kind], ...]]
"""Fields, name and kind, by type."""

Step = str | int
Path = tuple[Step, ...]
"""The way to a number: 'velocity[2]' is ('velocity', 2)."""


def text_of_type(name: str) -> str:
    """Return the definition of a type of ROS 2 Jazzy, with those that it is made of."""
    from rosbags.typesys import Stores, get_typestore

    return str(get_typestore(Stores.ROS2_JAZZY).generate_msgdef(name, ros_version=2)[0])


def types_of(channel: Channel) -> Types:
    """Return the type of a channel and those within it. Raises BagError where nobody knows it."""
    try:
        found = _parsed(channel)
    except Exception:  # the parser raises whatever a broken text makes it meet
        found = {}
    if channel.type in found:
        return found
    from rosbags.typesys import Stores, get_typestore

    known = get_typestore(Stores.ROS2_JAZZY).fielddefs
    if channel.type in known:
        return {name: _fields(fields) for name, (_, fields) in known.items()}
    raise BagError(
        f'{channel.topic} is {channel.type or "of no type"}, whose definition is neither readable '
        'in the bag nor part of ROS; record it with its definition (mcap, or Iron and later)'
    )


def _parsed(channel: Channel) -> dict[str, tuple[tuple[str, Kind], ...]]:
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    text, line = channel.definition, '=' * 80 + '\n'
    if not text or len(text) > _LONGEST:
        return {}
    if channel.format == 'ros2msg':
        found = dict(get_types_from_msg(text, channel.type))
    else:
        found = {}
        for part in text.split(f'{line}IDL: ')[1:] if line in text else [f'\n{text}']:
            found.update(get_types_from_idl(part.split('\n', 1)[1]))
    return {name: _fields(fields) for name, (_, fields) in found.items()}


def _fields(fields: list[tuple[str, Any]]) -> tuple[tuple[str, Kind], ...]:
    return tuple((name, _kind(kind)) for name, kind in fields)


def _kind(kind: Any) -> Kind:
    """Return a kind as rosbags describes it in ours."""
    node, what = int(kind[0]), kind[1]
    if node == 1:
        return Base(str(what[0]))
    if node == 2:
        return Named(str(what))
    of = _kind(what[0])
    if isinstance(of, Many):
        raise ValueError('an array of arrays')
    return Many(of, int(what[1]) if node == 3 else None)


# The way to a number ------------------------------------------------------------------------------


def parse_path(text: str) -> Path | None:
    """Return the steps of 'twist.linear.x' or 'velocity[2]', None where the text is no such way."""
    if not _WAY.fullmatch(text):
        return None
    return tuple(int(index) if index else name for name, index in _STEP.findall(text))


def kind_at(types: Types, kind: Kind, path: Path) -> Kind | None:
    """Return what a way leads to, None where it leads nowhere."""
    for step in path:
        if isinstance(kind, Named) and isinstance(step, str):
            found = dict(types.get(kind.name, ())).get(step)
        elif isinstance(kind, Many) and isinstance(step, int):
            found = kind.of if kind.size is None or step < kind.size else None
        else:
            found = None
        if found is None:
            return None
        kind = found
    return kind


def is_number(kind: Kind | None) -> bool:
    """Whether a kind is a number."""
    return isinstance(kind, Base) and kind.name in SIZES


def numbers(types: Types, name: str, before: str = '', depth: int = 0) -> Iterator[str]:
    """Yield the ways to the numbers of a type, without those of headers; of many, to the first."""
    for field, kind in types.get(name, ()) if depth < _DEEPEST else ():
        if field in _ASIDE:
            continue
        way, of = before + field, kind
        if isinstance(kind, Many):
            way, of = f'{way}[0]', kind.of
        if is_number(of):
            yield way
        elif isinstance(of, Named):
            yield from numbers(types, of.name, way + '.', depth + 1)
