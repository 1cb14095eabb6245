# SPDX-License-Identifier: Apache-2.0
"""Bags to signals: what was recorded, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from ..errors import BagError, one_line
from . import counts
from .channel import Account, Channel, Messages, Select, Taker, UnreadableError, absolute, each
from .files import BagFiles, bag_files, sidecar
from .finding import Finding, Note
from .integrity import Track, believed
from .metadata import NAME_KEY, SCENARIO_KEY, TOPICS_KEY
from .reading import Reading
from .recording import Recording, Stamped, beginning
from .storages import read_file
from .times import choose, differing, stamps_of
from .topics import Choice
from .values import lone_samples, two_sources, wild_samples


def read_bag(
    path: str | Path,
    namespace: str | None = None,
    *,
    topics: Sequence[str] = (),
    time: str | None = None,
    signals: Collection[str] | None = None,
) -> Recording:
    """Read the Float64 signals of a rosbag2: a directory, or a .mcap or .db3 file, packed or not.

    Topics lose their namespace; ``namespace`` says which one to read where several hold a y. Each
    of ``topics``, SIGNAL:=TOPIC[:FIELD], names a signal's source: any number in messages of any
    type. ``time`` is log, publish or header; by default the publish time where it is plausible.
    ``signals``: only these. Damage costs what it hit, and is among the findings. Raises BagError,
    one line, where there is nothing to read.
    """
    try:
        return _read(Path(path), Choice(str(path), namespace, topics, signals), time)
    except BagError as error:
        raise BagError(one_line(error)) from None


def _read(path: Path, choice: Choice, time: str | None) -> Recording:
    reading = Reading(choice, time == 'header')
    files = bag_files(path)
    choice.recorded_as(files.metadata.custom.get(TOPICS_KEY, '') if files.metadata else '')
    accounts, notes = _read_files(files, reading.select)
    for account in accounts:
        choice.recorded_as(account.custom.get(TOPICS_KEY, ''))
    if choice.lacks(reading.series):  # what the file says at its end, it says too late
        reading = Reading(choice, time == 'header')
        accounts, notes = _read_files(files, reading.select)
    for channel in (channel for account in accounts for channel in account.channels):
        reading.select(channel)  # those without a message, too
    sources = reading.choice.named(reading.series)
    reading.need_samples(sources, accounts)
    samples = {signal: reading.series[source].samples() for signal, source in sources.items()}
    chosen = choose(str(path), samples, time)
    notes += [
        note for signal, found in samples.items() for note in differing(signal, found, chosen)
    ]
    tracks = {
        signal: Track(stamps_of(found, chosen), found.values) for signal, found in samples.items()
    }
    del samples
    good = believed(tracks)
    notes += [*good.notes, *_of_values(good.tracks), *reading.notes(sources)]
    by_signal = {signal: source.topic for signal, source in sources.items()}
    notes += counts.of_signals(by_signal, files, accounts)
    signals = {signal: Stamped(*track) for signal, track in good.tracks.items()}
    first = {name: int(s.stamps[0]) for name, s in signals.items() if len(s.stamps)}
    start = beginning(first, good.begins)
    findings = _findings(notes, start, by_signal)
    scenario, name = _scenario(path, files, accounts)
    recording = Recording(signals, findings, scenario, name, chosen, by_signal)
    return replace(recording, lead=recording.start - start, changes=reading.changes)


def read_messages(path: str | Path, topics: Collection[str]) -> dict[str, list[Message]]:
    """Return the messages of some topics, whatever their type, in the order of the files.

    Raises BagError where there is nothing to read.
    """
    keepers = {absolute(topic): _Keeper() for topic in topics}

    def select(channel: Channel) -> Taker | None:
        keeper = keepers.get(channel.topic)
        if keeper is not None:
            keeper.type = channel.type
        return keeper

    _read_files(bag_files(Path(path)), select)
    return {topic: keepers[absolute(topic)].messages for topic in topics}


class Message(NamedTuple):
    """A message as it is stored; stamps in nanoseconds, ``publish`` None where there is none."""

    log: int
    publish: int | None
    type: str
    data: bytes


class _Keeper:
    """Keeps messages as they are."""

    def __init__(self) -> None:
        self.type = ''
        self.messages: list[Message] = []

    def expect(self, count: int) -> None:
        """Make no room: a list grows by itself."""

    def take(self, messages: Messages) -> None:
        """Keep messages."""
        found = sorted((i, data) for group in messages.groups for i, data in each(group))
        for i, data in found:
            publish = None if messages.publish is None else int(messages.publish[i])
            self.messages.append(Message(int(messages.log[i]), publish, self.type, data))


def _read_files(files: BagFiles, select: Select) -> tuple[list[Account], list[Note]]:
    """Read the files of a bag in order. Raises BagError where none of them can be read."""
    accounts, notes = [], counts.of_files(files)
    for file in files.files:
        try:
            accounts.append(read_file(file, select))
        except UnreadableError as error:
            if len(files.files) == 1:
                raise
            code = 'missing-file' if file.stat().st_size else 'no-end'  # killed at its beginning
            notes.append(Note(code, None, None, str(error)))
    if not accounts:
        raise BagError(f'none of the files of bag {files.files[0].parent} can be read')
    return accounts, notes + [note for account in accounts for note in account.notes]


def _of_values(tracks: Mapping[str, Track]) -> list[Note]:
    """Return what is odd about the values themselves."""
    notes = []
    for signal, (stamps, values) in tracks.items():
        first = two_sources(values)
        if first is not None:
            text = f'two sources wrote {signal}: its values alternate between two runs'
            notes.append(Note('second-writer', signal, int(stamps[first]), text))
            continue
        wild, lone = wild_samples(values), lone_samples(values)
        if len(wild) > len(lone):
            text = (
                f'{len(wild)} of {len(values)} samples of {signal} are larger than all others by '
                f'orders of magnitude, the first {values[wild[0]]:g}'
            )
            notes.append(Note('wild-samples', signal, int(stamps[wild[0]]), text))
            continue
        for place in lone:
            text = f'a single sample of {signal} is far off its neighbours: {values[place]:g}'
            notes.append(Note('lone-sample', signal, int(stamps[place]), text))
    return notes


def _findings(notes: Sequence[Note], start: int, topics: Mapping[str, str]) -> tuple[Finding, ...]:
    """Return notes as findings: by signal, and in seconds since ``start``."""
    signals = {topic: signal for signal, topic in topics.items()}
    findings = []
    for code, topic, stamp, text in notes:
        signal = signals.get(topic, topic) if topic is not None else None
        at = None if stamp is None else (stamp - start) * 1e-9
        findings.append(Finding(code, signal, at, one_line(text)))
    return tuple(dict.fromkeys(findings))


def _scenario(
    path: Path, files: BagFiles, accounts: Sequence[Account]
) -> tuple[str | None, str | None]:
    """Return text and name of the scenario: in metadata.yaml, in the files, or beside them."""
    custom: dict[str, str] = {}
    for account in reversed(accounts):
        custom.update(account.custom)
    custom.update(files.metadata.custom if files.metadata else {})
    if SCENARIO_KEY in custom:
        return custom[SCENARIO_KEY], custom.get(NAME_KEY)
    return sidecar(path) or (None, None)
