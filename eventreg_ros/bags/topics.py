# SPDX-License-Identifier: Apache-2.0
"""Which topics are read, and what the signals are called."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple

from ..errors import BagError
from ..models.roles import SIGNALS
from .channel import FLOAT64, Channel, absolute
from .definitions import Named, Path, Types, is_number, kind_at, numbers, parse_path, types_of
from .messages import Decoder, FieldDecoder, float64

_SHOWN = 6


class Wanted(NamedTuple):
    """A signal that was asked for by topic: ``y:=/robot1/joint_states:velocity[2]``."""

    signal: str
    topic: str
    field: str


def parse(text: str) -> Wanted:
    """Return what SIGNAL:=TOPIC[:FIELD] asks for. Raises BagError."""
    signal, assigned, rest = text.partition(':=')
    topic, _, field = rest.partition(':')
    if not assigned or not signal.strip('/') or not topic.strip('/'):
        raise BagError(
            f'a topic must be SIGNAL:=TOPIC or SIGNAL:=TOPIC:FIELD, got {text!r}; write for '
            'example y:=/robot1/joint_states:velocity[2]'
        )
    if field and parse_path(field) is None:
        raise BagError(
            f'the FIELD of --topic must be like velocity[2] or twist.linear.x, got {field!r}'
        )
    return Wanted(signal.strip('/'), absolute(topic), field)


class Source(NamedTuple):
    """Where a signal comes from: a topic, and a field of its messages, '' for a Float64."""

    topic: str
    field: str


class Choice:
    """The topics that are read of a bag."""

    def __init__(
        self,
        bag: str,
        namespace: str | None,
        topics: Sequence[str],
        signals: Collection[str] | None,
    ) -> None:
        """Raise BagError where one of ``topics`` is not SIGNAL:=TOPIC[:FIELD]."""
        self.bag = bag
        self.wanted = [parse(text) for text in topics]
        twice = [
            w.signal for w in self.wanted if sum(w.signal == v.signal for v in self.wanted) > 1
        ]
        if twice:
            raise BagError(f'topics name {twice[0]} twice; name each signal once')
        self.namespace = None if namespace is None else namespace.strip('/')
        self.signals = signals
        self.seen: dict[str, Channel] = {}
        self._prefix = '/'

    def sources(self, channel: Channel) -> list[Source]:
        """Return what is read from a channel; whatever is not needed is left out at the end."""
        topic = channel.topic
        self.seen.setdefault(topic, channel)
        named = [Source(topic, w.field) for w in self.wanted if w.topic == topic]
        if named:
            return list(dict.fromkeys(named))
        return [Source(topic, '')] if self._may_be_read(topic, channel) else []

    def _may_be_read(self, topic: str, channel: Channel) -> bool:
        if channel.encoding not in ('cdr', '') or channel.type not in (FLOAT64, ''):
            return False
        if self.namespace is not None and not topic.startswith(_prefix(self.namespace)):
            return False
        last = topic.rpartition('/')[2]
        if not channel.type:  # a guess, which is made for nothing but the signals of the loop
            return last in (self.signals or SIGNALS)
        return self.signals is None or any(last == s.rpartition('/')[2] for s in self.signals)

    def decoder(self, channel: Channel, field: str) -> tuple[Decoder, Types]:
        """Return what reads the field of a channel. Raises BagError where there is none."""
        if not field and channel.type in (FLOAT64, ''):
            return float64, {}
        topic = channel.topic
        if channel.encoding not in ('cdr', ''):
            raise BagError(
                f'{topic} is encoded as {channel.encoding}, and only cdr, the encoding of ROS 2, '
                'can be read; record it from ROS 2'
            )
        types = types_of(channel)
        return FieldDecoder(
            types, channel.type, self._path(topic, types, channel.type, field)
        ), types

    def _path(self, topic: str, types: Types, name: str, field: str) -> Path:
        ways = list(numbers(types, name))
        if not field and len(ways) == 1 and '[' not in ways[0]:
            field = ways[0]
        path = parse_path(field)
        if path is not None and is_number(kind_at(types, Named(name), path)):
            return path
        known = ', '.join(ways[:_SHOWN]) + (', ...' if len(ways) > _SHOWN else '')
        what = f'has no number {field}' if field else 'needs a field'
        raise BagError(f'{topic} ({name}) {what}; it has {known or "no numbers at all"}')

    def recorded_as(self, text: str) -> None:
        """Take over what the recorder says of remapped signals; who asks otherwise is obeyed.

        Where a namespace is asked for, its signals lose it, and those of others are left out.
        """
        home = f'{self.namespace}/' if self.namespace else ''
        for part in text.split():
            with suppress(BagError):
                want = parse(part)
                if home and '/' in want.signal:
                    if not want.signal.startswith(home):
                        continue
                    want = want._replace(signal=want.signal.removeprefix(home))
                named = {name for w in self.wanted for name in (w.signal, w.topic)}
                if not want.field and not {want.signal, want.topic} & named:
                    self.wanted.append(want)

    # Once all is read ---------------------------------------------------------------------------

    def lacks(self, read: Collection[Source]) -> bool:
        """Whether a topic that is there was not read since nobody knew that it is wanted."""
        wanted = [Source(w.topic, w.field) for w in self.wanted if w.topic in self.seen]
        return any(source not in read for source in wanted)

    def named(self, read: Iterable[Source]) -> dict[str, Source]:
        """Return the sources by signal. Raises BagError where it is not clear which are meant."""
        found = {}
        for want in self.wanted:
            if want.topic not in self.seen:
                raise BagError(
                    f'bag {self.bag} has no topic {want.topic}; {self._hint(want.topic)}'
                )
            found[want.signal] = Source(want.topic, want.field)
        others = [s for s in read if not any(w.topic == s.topic for w in self.wanted)]
        self._prefix = _prefix(self._home([source.topic for source in others]))
        for source in others:
            signal = source.topic.removeprefix(self._prefix)
            asked = self.signals is None or signal in self.signals
            if asked and signal not in found and source.topic.startswith(self._prefix):
                found[signal] = source
        return found

    def _home(self, topics: list[str]) -> str:
        """Return the namespace: the one given, that of the topic named for y, or the only y's."""
        if self.namespace is not None:
            return self.namespace
        if self.wanted and not topics:
            return ''  # every topic has a name already
        for want in self.wanted:
            home = want.topic.rpartition('/')[0].strip('/')
            if want.signal == 'y':
                return home if any(t.startswith(_prefix(home)) for t in topics) else ''
        homes = _homes(topics) or _homes(self.seen)
        if len(homes) > 1:
            raise BagError(
                f'bag {self.bag} holds several namespaces with a y: '
                f'{", ".join(home or "/" for home in homes)}; choose one with --namespace'
            )
        return homes[0].strip('/') if homes else ''

    def others(self, found: Collection[str]) -> dict[str, Channel]:
        """Return the signals that are there, but not as Float64, with their channels."""
        names = [name for name in self.signals or SIGNALS if name not in found]
        there = {name: self.seen.get(self._prefix + name) for name in names}
        return {name: c for name, c in there.items() if c is not None and c.type != FLOAT64}

    def nothing(self) -> str:
        """Return what to say where no topic could be read."""
        floats = sorted(topic for topic, c in self.seen.items() if c.type == FLOAT64)
        foreign = [self.seen[topic] for topic in floats if self.seen[topic].encoding != 'cdr']
        if foreign:
            return (
                f'bag {self.bag} holds {foreign[0].topic} encoded as {foreign[0].encoding!r}, not '
                'as cdr, the encoding of ROS 2; convert it (for ROS 1: rosbags-convert)'
            )
        if floats:
            where = f' in namespace {self._prefix.rstrip("/")}' if self.namespace else ''
            return f'bag {self.bag} holds no {FLOAT64} topic{where}; it has {", ".join(floats)}'
        there = sorted(f'{topic} ({c.type})' for topic, c in self.seen.items())
        shown = ', '.join(there[:_SHOWN]) + (', ...' if len(there) > _SHOWN else '')
        return (
            f'bag {self.bag} holds no {FLOAT64} topic (it has {shown or "none"}); record w, v, y, '
            'y_r and u'
        )

    def _hint(self, topic: str) -> str:
        close = difflib.get_close_matches(topic, self.seen, 3, 0.5)
        return f'it has {", ".join(close or sorted(self.seen)[:_SHOWN]) or "none"}'


def _homes(topics: Iterable[str]) -> list[str]:
    """Return the namespaces that hold a y."""
    return sorted({t.rpartition('/')[0] for t in topics if t.rpartition('/')[2] == 'y'})


def _prefix(namespace: str) -> str:
    return f'/{namespace}/' if namespace else '/'
