# SPDX-License-Identifier: Apache-2.0
"""Which of its three times a sample is taken at: logged, published, or that of its header."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from ..errors import BagError
from .channel import Index, Stamps
from .finding import Note
from .series import Samples

Time = Literal['log', 'publish', 'header']

SECOND = 1_000_000_000
HOUR = 3600 * SECOND
_MOST = 0.5
_FAR = 2**61


def choose(bag: str, series: Mapping[str, Samples], time: str | None) -> Time:
    """Return the time that is used: the one that was asked for, else the plausible one.

    The publish time is plausible where it exists, is not constant, and runs with the log time.
    Raises BagError where the bag lacks what was asked for.
    """
    if time == 'log':
        return 'log'
    if time == 'publish':
        if not all(samples.published for samples in series.values()):
            raise BagError(f'bag {bag} holds no publish times, as sqlite3 has none; use --time log')
        return 'publish'
    if time == 'header':
        for signal, samples in series.items():
            if samples.header is None:
                raise BagError(
                    f'time header needs messages with a header, and those of {signal} have none; '
                    'use log or publish'
                )
        return 'header'
    if time is not None:
        raise BagError(f'time must be log, publish or header, got {time!r}')
    return 'publish' if _plausible(series) else 'log'


def stamps_of(samples: Samples, time: Time) -> Stamps:
    """Return the stamps of samples by one of their times."""
    if time == 'header' and samples.header is not None:
        return samples.header
    if time == 'publish' and samples.publish is not None:
        return samples.publish
    return samples.log


def delays(samples: Samples) -> Stamps:
    """Return publish time minus log time in nanoseconds, which no stamp can make overflow."""
    log, publish = samples.log, samples.publish
    if publish is None:
        return np.zeros(len(log), np.int64)
    if not len(log) or all(int(t.min()) >= 0 and int(t.max()) < _FAR for t in (log, publish)):
        return publish - log
    return np.clip(publish, -_FAR, _FAR) - np.clip(log, -_FAR, _FAR)


def differing(signal: str, samples: Samples, time: Time) -> list[Note]:
    """Return what is wrong where the log time and the publish time of samples disagree."""
    if samples.publish is None or time == 'header':
        return []
    late = delays(samples)
    notes = []
    far = np.flatnonzero(np.abs(late) >= HOUR)
    if time == 'publish' and len(far):
        text = (
            f'the log times of {len(far)} of {len(late)} samples of {signal} make no sense; the '
            'publish times were used'
        )
        notes.append(Note('log-stamps', signal, int(samples.publish[far[0]]), text))
    odd = _odd(late)
    if len(odd):
        text = (
            f'{len(odd)} of {len(late)} samples of {signal} were logged before they were '
            'published, or at another time while all others were not: a stamp was changed'
        )
        notes.append(Note('stamps-disagree', signal, int(samples.log[odd[0]]), text))
    return notes


def _odd(late: Stamps) -> Index:
    """Return the few samples that were published long after they were logged, or are not like all.

    Where the clocks of two hosts differ, all are; a recorder that hangs logs late, never early.
    """
    count = int(np.count_nonzero(late)) - int(np.count_nonzero(np.abs(late) >= HOUR))
    if 0 < count <= len(late) // 100:
        return np.flatnonzero((late != 0) & (np.abs(late) < HOUR))
    early = np.flatnonzero((late > SECOND) & (late < HOUR))
    return early if len(early) <= len(late) // 100 else np.empty(0, np.intp)


def _plausible(series: Mapping[str, Samples]) -> bool:
    """Whether the publish times of all signals run with the log times, except a few of either."""
    if not all(samples.published for samples in series.values()):
        return False
    for samples in series.values():
        if samples.publish is None or len(samples.log) < 2:
            continue
        close = np.count_nonzero(np.abs(delays(samples)) < SECOND)
        if not _alive(samples.publish) or (
            _alive(samples.log) and close < _MOST * len(samples.log)
        ):
            return False
        more = _strays(samples.publish) - _strays(samples.log)
        if more > len(samples.log) // 100:
            return False
    return True


def _alive(stamps: Stamps) -> bool:
    """Whether stamps are not all the same."""
    return int(stamps.min()) != int(stamps.max())


def _strays(stamps: Stamps) -> int:
    """Return how many stamps are more than a day off the middle one."""
    if int(stamps.max()) - int(stamps.min()) < 24 * HOUR:
        return 0
    middle = int(np.median(stamps))
    off = (stamps < middle - 24 * HOUR) | (stamps > middle + 24 * HOUR)
    return int(np.count_nonzero(off))
