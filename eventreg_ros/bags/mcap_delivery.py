# SPDX-License-Identifier: Apache-2.0
"""Messages of an MCAP file to those who want them; channels as data and summary declare them."""

from __future__ import annotations

from collections import Counter

from . import mcap_records as mcap
from .channel import Account, Channel, Select, Spans, Taker, absolute, by_taker, full_type
from .mcap_messages import Run
from .mcap_records import DamagedError, McapChannel, Record, Schema
from .mcap_summary import Summary
from .metadata import custom_data

METADATA_NAME, METADATA_KEY = 'rosbag2', 'serialized_metadata'


class Delivery:
    """Knows the channels of one file, and hands each run of messages on."""

    def __init__(self, select: Select, summary: Summary, account: Account, most: int) -> None:
        """``most``: no file of this size holds more messages."""
        self.account = account
        self.latest: int | None = None
        """The log time of the message that was read last."""
        self.indexed: Counter[int] = Counter()
        self._select = select
        self._most = most
        self._summary = summary
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, McapChannel] = {}
        self._read: Counter[int] = Counter()
        self._takers: dict[int, Taker | None] = {}
        self._spans = Spans()

    def declare(self, record: Record, sound: bool) -> None:
        """Take note of a record that is no message; not ``sound``: its checksum is wrong."""
        try:
            if record.opcode == mcap.SCHEMA:
                schema = mcap.schema(record.body)
                if sound or schema.id not in self._summary.schemas:
                    self._schemas.setdefault(schema.id, schema)
            elif record.opcode == mcap.CHANNEL:
                channel = mcap.channel(record.body)
                if sound or channel.id not in self._summary.channels:
                    self._channels.setdefault(channel.id, channel)
            elif record.opcode == mcap.MESSAGE_INDEX:
                number, count = mcap.index_entries(record.body)
                self.indexed[number] += count
            elif record.opcode == mcap.METADATA:
                name, content = mcap.metadata(record.body)
                if name == METADATA_NAME:
                    self.account.custom.update(custom_data(content.get(METADATA_KEY, '')))
        except DamagedError:
            self.account.note('damaged', f'a record of opcode {record.opcode} cannot be read')

    def deliver(self, run: Run) -> None:
        """Hand a run of messages on, channel by channel."""
        found = run.counts()
        for number, count in found.items():
            self._read[number] += count
            if number not in self._takers:
                self._takers[number] = self._taker(number)
        for taker, numbers in by_taker((number, self._takers[number]) for number in found):
            messages = run.of(numbers)
            taker.take(messages)
            self.latest = int(messages.log[-1])
            for number in numbers:
                alone = messages if len(numbers) == 1 else run.of([number])
                self._spans.add(number, alone.log)

    def _taker(self, number: int) -> Taker | None:
        channel = self._channel(number)
        taker = None if channel is None else self._select(channel)
        expected = (self._summary.counts or {}).get(number, 0)
        if taker is not None and expected <= self._most:
            taker.expect(expected)
        return taker

    def _channel(self, number: int) -> Channel | None:
        found = self._channels.get(number) or self._summary.channels.get(number)
        if found is None:
            return None
        schema = self._schemas.get(found.schema) or self._summary.schemas.get(found.schema)
        return _described(found, schema)

    def finish(self) -> None:
        """Complete the account: channels, counts, and where data and summary disagree."""
        account, summary = self.account, self._summary
        numbers = sorted({*self._channels, *summary.channels})
        channels = {n: c for n in numbers if (c := self._channel(n)) is not None}
        account.channels = list(channels.values())
        for number, channel in channels.items():
            account.read[channel.topic] += self._read[number]
            for who, counts in (('statistics', summary.counts or {}), ('index', self.indexed)):
                if counts.get(number):
                    account.promised.setdefault(who, Counter())[channel.topic] += counts[number]
        self._spans.judge(channels, account)
        strays = sum(n for number, n in self._read.items() if number not in channels)
        if strays:
            account.note('damaged', f'{strays} messages are of channels that nothing declares')
        for number, stated in summary.channels.items():
            there = _described(stated, summary.schemas.get(stated.schema))
            if number in self._channels and _differ(channels[number], there):
                text = (
                    f'channel {number} is {channels[number].topic} ({channels[number].type}) in '
                    f'the data, and {there.topic} ({there.type}) in the summary'
                )
                account.note('topic-disagrees', text, topic=there.topic)


def _described(channel: McapChannel, schema: Schema | None) -> Channel:
    topic, encoding = absolute(channel.topic), channel.encoding
    if schema is None:
        return Channel(topic, '', encoding, '', '')
    return Channel(topic, full_type(schema.name), encoding, schema.text, schema.encoding)


def _differ(one: Channel, other: Channel) -> bool:
    """Whether two descriptions of a channel contradict each other; none contradicts nothing."""
    types = one.type and other.type and one.type != other.type
    return bool(one.topic != other.topic or one.encoding != other.encoding or types)
