# SPDX-License-Identifier: Apache-2.0
"""What was read against what metadata, statistics and indices promise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from .channel import Account
from .files import METADATA, BagFiles
from .finding import IMPAIRING, Note

_WHO = {'statistics': "the file's statistics promise", 'index': "the file's index promises"}


def of_files(files: BagFiles) -> list[Note]:
    """Return what is wrong with the files that make a bag."""
    notes = [
        Note('missing-file', None, None, f'{name} is named in {METADATA}, but is not there')
        for name in files.missing
    ]
    if files.extra:
        names = ', '.join(files.extra[:3]) + (', ...' if len(files.extra) > 3 else '')
        text = f'{METADATA} is stale: it does not name {names}; all files were read'
        notes.append(Note('metadata-disagrees', None, None, text))
    if files.broken:
        text = f'{METADATA} cannot be understood; the files were read without it'
        notes.append(Note('metadata-disagrees', None, None, text))
    return notes


def of_signals(
    topics: Mapping[str, str], files: BagFiles, accounts: Sequence[Account]
) -> list[Note]:
    """Return where more or fewer messages were read than something promises.

    ``topics`` gives the topic of each signal.
    """
    notes = []
    stale = []
    stamp = _first_damage(accounts)
    for signal, topic in topics.items():
        count = sum(account.read[topic] for account in accounts)
        promised = _promised(topic, files, accounts)
        most, who = max(((n, who) for who, n in promised.items()), default=(0, ''))
        if most > count:
            text = f'{count} of {most} samples of {signal} were read: {who} {most}'
            notes.append(Note('lost-samples', signal, stamp, text))
        elif 0 < promised.get(_METADATA, count) < count:
            stale.append(f'{promised[_METADATA]} of {count} samples of {signal}')
        elif 0 < promised[_WHO['statistics']] < count:
            text = f'{count} samples of {signal} were read: {_WHO["statistics"]} fewer'
            notes.append(Note('summary-disagrees', signal, None, text))
    if stale:
        text = f'{METADATA} is stale: it knows {", ".join(stale)}; all were read'
        notes.append(Note('metadata-disagrees', None, None, text))
    return notes


_METADATA = f'{METADATA} promises'


def _promised(topic: str, files: BagFiles, accounts: Sequence[Account]) -> dict[str, int]:
    found = {
        text: sum(account.promised.get(who, Counter())[topic] for account in accounts)
        for who, text in _WHO.items()
    }
    if files.metadata:
        found[_METADATA] = files.metadata.counts[topic]
    return found


def _first_damage(accounts: Sequence[Account]) -> int | None:
    stamps = [
        note.stamp
        for account in accounts
        for note in account.notes
        if note.stamp is not None and (note.code in IMPAIRING or note.code == 'no-end')
    ]
    return min(stamps, default=None)
