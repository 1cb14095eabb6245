# SPDX-License-Identifier: Apache-2.0
"""What is kept while the files of a bag are read: a series for each source of a signal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..errors import BagError
from .changes import Changed, ChangeTaker
from .channel import Account, Channel, Messages, Taker
from .definitions import Named, Types, is_number, kind_at, numbers, types_of
from .finding import IMPAIRING, Note
from .messages import FieldDecoder
from .series import Series
from .topics import Choice, Source


class Fan:
    """Hands messages to several takers: two signals may come from one topic."""

    def __init__(self, takers: Sequence[Taker]) -> None:
        self.takers = takers

    def expect(self, count: int) -> None:
        """Pass the hint on."""
        for taker in self.takers:
            taker.expect(count)

    def take(self, messages: Messages) -> None:
        """Hand the messages on."""
        for taker in self.takers:
            taker.take(messages)


class Reading:
    """The series of a bag, as its channels turn up."""

    def __init__(self, choice: Choice, headers: bool) -> None:
        """``headers``: keep the stamps in the messages' headers too."""
        self.choice = choice
        self.series: dict[Source, Series] = {}
        self._headers = headers
        self._fans: dict[tuple[Source, ...], Fan] = {}
        self._changes: dict[str, ChangeTaker] = {}

    def select(self, channel: Channel) -> Taker | None:
        """Return who takes the messages of a channel. Raises BagError for a field it has not."""
        sources = tuple(self.choice.sources(channel))
        for source in sources:
            if source not in self.series:
                self.series[source] = self._new(channel, source)
        if not sources and ChangeTaker.wants(channel):
            return self._changes.setdefault(channel.topic, ChangeTaker(channel))
        if len(sources) < 2:
            return self.series[sources[0]] if sources else None
        return self._fans.setdefault(sources, Fan([self.series[s] for s in sources]))

    def _new(self, channel: Channel, source: Source) -> Series:
        decoder, types = self.choice.decoder(channel, source.field)
        way = _stamp_of(types, channel.type) if self._headers else None
        if way is None:
            return Series(decoder)
        seconds, nanoseconds = (
            FieldDecoder(types, channel.type, (*way, part)) for part in ('sec', 'nanosec')
        )
        return Series(decoder, (seconds, nanoseconds))

    @property
    def changes(self) -> tuple[Changed, ...]:
        """What was changed while the bag was recorded, in order."""
        return tuple(sorted(c for taker in self._changes.values() for c in taker.changes()))

    # Once all is read ---------------------------------------------------------------------------

    def need_samples(self, sources: Mapping[str, Source], accounts: list[Account]) -> None:
        """Raise BagError where no signal has a sample, or y was recorded as another type."""
        others = self.choice.others(sources)
        if 'y' in others or (others and not sources):
            name = 'y' if 'y' in others else next(iter(others))
            raise BagError(f'bag {self.choice.bag}: {by_name(name, others[name])}')
        if not sources:
            raise BagError(self.choice.nothing())
        if any(self.series[source].count for source in sources.values() if source in self.series):
            return
        raise BagError(self._empty(sources, accounts))

    def _empty(self, sources: Mapping[str, Source], accounts: list[Account]) -> str:
        bag = self.choice.bag
        for signal, source in sources.items():
            if source in self.series and self.series[source].wrong:
                kind = self.choice.seen[source.topic].type if source.field else 'Float64'
                return f'bag {bag}: a message on {signal} is not a {kind}; record it again'
        damage = [n.text for a in accounts for n in a.notes if n.code in (*IMPAIRING, 'no-end')]
        if damage:
            return (
                f'bag {bag} holds no sample that can be read: {damage[0]}; take another copy of '
                'it, or record it again'
            )
        return f'bag {bag} is empty: no sample in it; record while the nodes run'

    def notes(self, sources: Mapping[str, Source]) -> list[Note]:
        """Return what is wrong with the messages that were taken, and which were not."""
        notes = [
            Note('other-type', signal, None, by_name(signal, channel))
            for signal, channel in self.choice.others(sources).items()
        ]
        for signal, source in sources.items():
            series, channel = self.series[source], self.choice.seen[source.topic]
            if series.wrong:
                total = series.wrong + series.count
                text = (
                    f'{series.wrong} of {total} messages on {signal} are not what their type '
                    f'{channel.type or "std_msgs/msg/Float64"} says, and are left out'
                )
                notes.append(Note('not-decoded', signal, series.wrong_at, text))
            if not channel.type and series.count:
                text = f'{source.topic} has no type in the file; it was taken for Float64'
                notes.append(Note('assumed-type', signal, None, text))
        return notes


def by_name(signal: str, channel: Channel) -> str:
    """Return how a signal of another type than Float64 is read."""
    try:
        ways = list(numbers(types_of(channel), channel.type))
    except BagError:
        ways = []
    way = f':{ways[0]}' if ways else ':FIELD'
    return (
        f'{channel.topic} is {channel.type}, which is read when it is named only: add '
        f'--topic {signal}:={channel.topic}{way}'
    )


def _stamp_of(types: Types, name: str) -> tuple[str, ...] | None:
    """Return the way to the stamp of a message's header, None where it has none."""
    for way in (('header', 'stamp'), ('stamp',)):
        if is_number(kind_at(types, Named(name), (*way, 'nanosec'))):
            return way
    return None
