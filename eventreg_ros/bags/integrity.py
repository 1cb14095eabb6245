# SPDX-License-Identifier: Apache-2.0
"""Whether stamps can be believed: what goes back, stands still, jumps, or makes no sense."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timedelta, timezone
from typing import NamedTuple

import numpy as np

from .channel import Index, Stamps
from .finding import Note, many
from .first_run import first_run
from .messages import Flags, Values
from .times import HOUR

_BLOCK = 2**15
_FEW = 0.25
"""A part of the samples that is smaller than this is a mishap, a larger one another recording."""


class Track(NamedTuple):
    """The samples of one signal, both of shape (n,)."""

    stamps: Stamps
    values: Values

    def only(self, which: Flags | Index) -> Track:
        """Return some of the samples."""
        return Track(self.stamps[which], self.values[which])


class Believed(NamedTuple):
    """Samples whose stamps can be believed, ordered, and what is wrong with the rest.

    ``begins`` is where each signal began, before samples that were left out for their stamps.
    """

    tracks: dict[str, Track]
    begins: dict[str, int]
    notes: list[Note]


def believed(tracks: Mapping[str, Track]) -> Believed:
    """Return what can be believed of tracks, which are in the order of the files."""
    found = Believed({}, {}, [])
    part = main_part([track.stamps for track in tracks.values() if len(track.stamps)])
    for signal, track in tracks.items():
        lead = 0
        if part is not None:
            inside = (track.stamps >= part[0]) & (track.stamps <= part[1])
            lead = int(inside.argmax()) if inside.any() else 0
            track = _within(signal, track, inside, found.notes)
        track = _ordered(signal, track, found.notes)
        found.tracks[signal] = track
        if len(track.stamps):
            usual = int(np.median(np.diff(track.stamps[:100]))) if len(track.stamps) > 1 else 0
            found.begins[signal] = int(track.stamps[0]) - lead * usual
    return found


# Stamps that are far from all others ------------------------------------------------------------


def main_part(found: list[Stamps]) -> tuple[int, int] | None:
    """Return first and last stamp of the largest part without a gap of an hour, None: it is all."""
    if not found:
        return None
    low = min(int(stamps.min()) for stamps in found)
    high = max(int(stamps.max()) for stamps in found)
    if high - low <= HOUR or any(_spans(stamps, low, high) for stamps in found):
        return None
    stamps = np.sort(np.concatenate(found))
    gaps = np.diff(stamps).view(np.uint64) > HOUR
    if not gaps.any():
        return None
    edges = [0, *(np.flatnonzero(gaps) + 1).tolist(), len(stamps)]
    sizes = np.diff(edges)
    largest = int(sizes.argmax())
    return int(stamps[edges[largest]]), int(stamps[edges[largest + 1] - 1])


def _spans(stamps: Stamps, low: int, high: int) -> bool:
    """Whether stamps are ordered, without a gap of an hour, and reach from ``low`` to ``high``."""
    if int(stamps[0]) - low > HOUR or high - int(stamps[-1]) > HOUR:
        return False
    steps = np.diff(stamps)
    return not len(steps) or bool(steps.min() >= 0 and steps.max() <= HOUR)


def _within(signal: str, track: Track, inside: Flags, notes: list[Note]) -> Track:
    out = len(inside) - int(np.count_nonzero(inside))
    if not out:
        return track
    first = int(track.stamps[int(inside.argmin())])
    who = f'{many(out, len(inside))} of {signal} (the first: {_when(first)})'
    if out <= _FEW * len(inside):
        text = f'the stamps of {who} make no sense; they are left out'
        notes.append(Note('nonsense-stamps', signal, None, text))
    else:
        text = (
            f'the stamps of {who} are more than an hour from the rest of the recording; they are '
            'left out'
        )
        notes.append(Note('stamps-jump', signal, None, text))
    return track.only(inside)


def _when(stamp: int) -> str:
    try:
        moment = datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(microseconds=stamp // 1000)
    except OverflowError:
        return f'{stamp} ns'
    return moment.strftime('%Y-%m-%d %H:%M:%S UTC')


# Order ------------------------------------------------------------------------------------------


def _ordered(signal: str, track: Track, notes: list[Note]) -> Track:
    """Return the samples of the first run in the order of their stamps."""
    least, period, regular = _steps(track.stamps)
    if least <= 0:
        first = first_run(signal, track.stamps, notes)
        track = track if first is None else track.only(first)
        if (np.diff(track.stamps) < 0).any():
            track = track.only(np.argsort(track.stamps, kind='stable'))
        track = _moving(signal, track, notes)
        _, period, regular = _steps(track.stamps)
    count = len(track.stamps)
    if count > 100 and 0.99 * (count - 1) <= regular < count - 1:
        _off_grid(signal, track, period, notes)
    return track


def _steps(stamps: Stamps) -> tuple[int, int, int]:
    """Return the least step, the usual one, and how many are exactly that."""
    if len(stamps) < 2:
        return 1, 1, 0
    usual = int(np.median(np.diff(stamps[:100])))
    least, regular = 2**63 - 1, 0
    for at in range(0, len(stamps) - 1, _BLOCK):
        steps = np.diff(stamps[at : at + _BLOCK + 1])
        least = min(least, int(steps.min()))
        regular += int(np.count_nonzero(steps == usual))
    return least, usual, regular


# Stamps that stand still, or leave the grid ------------------------------------------------------


def _moving(signal: str, track: Track, notes: list[Note]) -> Track:
    """Report equal stamps; where two sources wrote two samples under each, keep the first."""
    still = np.flatnonzero(np.diff(track.stamps) == 0)
    if not len(still):
        return track
    start = int(track.stamps[still[0]])
    if _twofold(track.values, still):
        text = (
            f'two sources wrote {signal}: {len(still)} stamps occur twice; the first sample of '
            'each is kept'
        )
        notes.append(Note('second-writer', signal, start, text))
        good = np.ones(len(track.stamps), bool)
        good[still + 1] = False
        return track.only(good)
    text = (
        f'the stamps of {signal} stand still: {len(still)} samples have the stamp of the one before'
    )
    notes.append(Note('stamps-stand-still', signal, start, text))
    return track


def _twofold(values: Values, still: Index) -> bool:
    """Whether two sources wrote: from some sample on, each stamp occurs twice.

    Under a clock that is too slow for its signal, the second of two samples lies halfway to the
    next; of two sources it may lie anywhere else.
    """
    left = len(values) - int(still[0])
    if len(still) < 8 or (np.diff(still) < 2).any() or len(still) < 0.45 * left:
        return False
    with np.errstate(all='ignore'):
        first, second = values[still], values[still + 1]
        within = np.nanmean(np.abs(second - first))
        onwards = np.nanmean(np.abs(np.diff(first)))
    return not 0.25 * onwards < within < 0.75 * onwards


def _off_grid(signal: str, track: Track, period: int, notes: list[Note]) -> None:
    """Report single stamps that are off the grid on which all others lie."""
    phase = (track.stamps - track.stamps[0]) % period
    off = np.flatnonzero(phase != int(np.median(phase)))
    if 0 < len(off) <= len(phase) // 100:
        text = (
            f'the stamps of {many(len(off), len(phase))} of {signal} are off the grid of all '
            'others: they were changed'
        )
        notes.append(Note('stamps-off-grid', signal, int(track.stamps[off[0]]), text))
