"""Whether stamps can be believed: what goes back, stands still, jumps, or makes no sense."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timedelta, timezone
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .channel import Index, Stamps
from .finding import Note
from .messages import Flags, Values
from .times import HOUR, SECOND
from .values import two_sources

_BLOCK = 2**15
_FEW = 0.25
"""A part of the samples that is smaller than this is a mishap, a larger one another recording."""
_STRAYS = 200
"""Of so many samples, one may be a stray; more that belong together are a run."""
_UNORDERED = 20
_PERIODS = 8


class Track(NamedTuple):
    """The samples of one signal, both of shape (n,)."""

    stamps: Stamps
    values: Values

    def only(self, which: Flags | Index) -> Track:
        """Return some of the samples."""
        return Track(self.stamps[which], self.values[which])


def believed(tracks: Mapping[str, Track]) -> tuple[dict[str, Track], list[Note]]:
    """Return the samples whose stamps can be believed, ordered, and what is wrong with the rest.

    ``tracks`` are in the order of the files.
    """
    notes: list[Note] = []
    part = main_part([track.stamps for track in tracks.values() if len(track.stamps)])
    found = {}
    for signal, track in tracks.items():
        if part is not None:
            track = _within(signal, track, part, notes)
        found[signal] = _ordered(signal, track, notes)
    return found, notes


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


def _within(signal: str, track: Track, part: tuple[int, int], notes: list[Note]) -> Track:
    inside = (track.stamps >= part[0]) & (track.stamps <= part[1])
    out = len(inside) - int(np.count_nonzero(inside))
    if not out:
        return track
    first = int(track.stamps[int(inside.argmin())])
    if out <= _FEW * len(inside):
        text = (
            f'{_many(out, len(inside))} of {signal} bear stamps that make no sense (the first: '
            f'{_when(first)}), and are left out'
        )
        notes.append(Note('nonsense-stamps', signal, None, text))
    else:
        text = (
            f'the stamps of {signal} jump by more than an hour: {_many(out, len(inside))} (the '
            f'first: {_when(first)}) are far from the rest of the recording, and are left out'
        )
        notes.append(Note('stamps-jump', signal, None, text))
    return track.only(inside)


def _many(count: int, of: int) -> str:
    return f'{count} of {of} samples'


def _when(stamp: int) -> str:
    try:
        moment = datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(microseconds=stamp // 1000)
    except OverflowError:
        return f'{stamp} ns'
    return moment.strftime('%Y-%m-%d %H:%M:%S UTC')


# Runs under stamps that were there already -------------------------------------------------------


def _ordered(signal: str, track: Track, notes: list[Note]) -> Track:
    """Return the samples of the first run in the order of their stamps."""
    least, period, regular = _steps(track.stamps)
    if least <= 0:
        track = _first_run(signal, track, notes)
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


class _Segment(NamedTuple):
    """Samples that follow each other in the file without a jump: first, after the last, stamps."""

    first: int
    after: int
    low: int
    high: int

    def overlaps(self, other: _Segment, slack: int) -> bool:
        """Whether it covers time that ``other`` covers."""
        return self.low < other.high - slack and self.high > other.low + slack


def _first_run(signal: str, track: Track, notes: list[Note]) -> Track:
    """Leave out what was recorded under stamps that were recorded before, and single strays.

    A file that is out of order for its own reasons (by less than a second, or all over) is left
    as it is.
    """
    stamps = track.stamps
    steps = np.diff(stamps)
    back = int(np.count_nonzero(steps < -SECOND))
    if not back or back > max(_UNORDERED, len(steps) // _UNORDERED):
        return track
    usual = int(np.median(steps[steps > 0])) if (steps > 0).any() else 0
    slack = max(SECOND, _PERIODS * usual)
    edges = [0, *(np.flatnonzero(np.abs(steps) > slack) + 1).tolist(), len(stamps)]
    parts = [
        _Segment(a, b, int(stamps[a:b].min()), int(stamps[a:b].max())) for a, b in pairwise(edges)
    ]
    size = max(3, len(stamps) // _STRAYS)
    runs = [part for part in parts if part.after - part.first > size]
    kept: list[_Segment] = []
    for part in runs:
        if not any(part.overlaps(other, slack) for other in kept):
            kept.append(part)
    again = [part for part in runs if part not in kept]
    strays = [part for part in parts if part not in runs and not _fits(part, kept, slack)]
    _say_again(signal, again, len(stamps), notes)
    _say_strays(signal, strays, len(stamps), notes)
    good = np.ones(len(stamps), bool)
    for part in (*again, *strays):
        good[part.first : part.after] = False
    return track.only(good)


def _fits(part: _Segment, kept: list[_Segment], slack: int) -> bool:
    """Whether a few samples lie, by their stamps, between what precedes and what follows them."""
    before = [other.high for other in kept if other.first < part.first]
    after = [other.low for other in kept if other.first > part.first]
    return (not before or part.low >= max(before) - slack) and (
        not after or part.high <= min(after) + slack
    )


def _say_again(signal: str, again: list[_Segment], total: int, notes: list[Note]) -> None:
    if not again:
        return
    count = sum(part.after - part.first for part in again)
    start = min(part.low for part in again)
    text = (
        f'the stamps of {signal} go back: {_many(count, total)} are of a second run under stamps '
        'that were recorded before, and are left out'
    )
    notes.append(Note('second-run', signal, start, text))


def _say_strays(signal: str, strays: list[_Segment], total: int, notes: list[Note]) -> None:
    if not strays:
        return
    count = sum(part.after - part.first for part in strays)
    text = (
        f'{_many(count, total)} of {signal} bear stamps that do not belong between those of their '
        'neighbours, and are left out'
    )
    notes.append(Note('nonsense-stamps', signal, strays[0].low, text))


# Stamps that stand still, or leave the grid ------------------------------------------------------


def _moving(signal: str, track: Track, notes: list[Note]) -> Track:
    """Report equal stamps; where two sources wrote two samples under each, keep the first."""
    still = np.flatnonzero(np.diff(track.stamps) == 0)
    if not len(still):
        return track
    start = int(track.stamps[still[0]])
    pairs = len(still) < 2 or bool((np.diff(still) > 1).all())
    share = len(still) / max(len(track.stamps) - int(still[0]), 1)
    source = two_sources(track.values[still[0] :]) if pairs and share > 0.4 else None
    if source is not None:
        text = (
            f'two sources wrote {signal}: {len(still)} stamps occur twice, with values that belong '
            'to two runs; the first of each is kept'
        )
        notes.append(Note('second-writer', signal, start, text))
        good = np.ones(len(track.stamps), bool)
        good[still + 1] = False
        return track.only(good)
    text = (
        f'the stamps of {signal} stand still: {len(still)} samples bear the stamp of the one before'
    )
    notes.append(Note('stamps-stand-still', signal, start, text))
    return track


def _off_grid(signal: str, track: Track, period: int, notes: list[Note]) -> None:
    """Report single stamps that are off the grid on which all others lie."""
    phase = (track.stamps - track.stamps[len(track.stamps) // 2]) % period
    off = np.flatnonzero(phase)
    if 0 < len(off) <= len(phase) // 100:
        text = (
            f'{_many(len(off), len(phase))} of {signal} bear a stamp off the grid of all others: '
            'it was changed'
        )
        notes.append(Note('stamps-off-grid', signal, int(track.stamps[off[0]]), text))
