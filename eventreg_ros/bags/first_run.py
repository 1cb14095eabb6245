# SPDX-License-Identifier: Apache-2.0
"""Runs under stamps that were recorded before, and single samples where they do not belong.

A recording goes forward. Where its stamps go back in the order of the file, another run, a clock
that was set back, or a stamp that was changed is behind it.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .channel import Stamps
from .finding import Note, many
from .messages import Flags
from .times import SECOND

_STRAYS = 200
"""Of so many samples, one may be a stray; more that belong together are a run."""
_UNORDERED = 20
_MOST = 1000
_PERIODS = 8


class _Segment(NamedTuple):
    """Samples that follow each other in the file without a jump: first, after the last, stamps."""

    first: int
    after: int
    low: int
    high: int

    def overlaps(self, other: _Segment, slack: int) -> bool:
        """Whether it covers time that ``other`` covers."""
        return self.low < other.high - slack and self.high > other.low + slack


def first_run(signal: str, stamps: Stamps, notes: list[Note]) -> Flags | None:
    """Return which samples belong to the first run, None: all; the others are noted.

    ``stamps`` are in the order of the file. A file that is out of order for its own reasons (by
    less than a second, or all over) is left as it is.
    """
    steps = np.diff(stamps)
    back = int(np.count_nonzero(steps < -SECOND))
    if not 0 < back <= max(_UNORDERED, min(len(steps) // _UNORDERED, _MOST)):
        return None
    usual = int(np.median(steps[steps > 0])) if (steps > 0).any() else 0
    slack = max(SECOND, _PERIODS * usual)
    edges = [0, *(np.flatnonzero(np.abs(steps) > slack) + 1).tolist(), len(stamps)]
    if len(edges) > 4 * _MOST:
        return None
    parts = [
        _Segment(a, b, int(stamps[a:b].min()), int(stamps[a:b].max())) for a, b in pairwise(edges)
    ]
    size = max(3, len(stamps) // _STRAYS)
    runs = [part for part in parts if part.after - part.first > size]
    kept = _first_of(runs, slack)
    again = [part for part in runs if part not in kept]
    strays = [part for part in parts if part not in runs and not _fits(part, kept, slack)]
    _say_again(signal, again, len(stamps), notes)
    _say_strays(signal, strays, len(stamps), notes)
    good = np.ones(len(stamps), bool)
    for part in (*again, *strays):
        good[part.first : part.after] = False
    return good


def _first_of(runs: list[_Segment], slack: int) -> list[_Segment]:
    """Return the runs that cover no time twice, and that do not go back.

    Parts of one recording that merely lie in the file in another order leave no holes: they stay.
    """
    kept: list[_Segment] = []
    for part in runs:
        if not any(part.overlaps(other, slack) for other in kept):
            kept.append(part)
    ordered = sorted(kept, key=lambda part: part.low)
    if all(after.low - before.high <= slack for before, after in pairwise(ordered)):
        return kept
    latest = -(2**63)
    forward = []
    for part in kept:
        if part.low > latest - slack:
            forward.append(part)
            latest = part.high
    return forward


def _fits(part: _Segment, kept: list[_Segment], slack: int) -> bool:
    """Whether a few samples lie, by their stamps, between what precedes and what follows them.

    Or, in a file whose parts are in another order, next to one of those.
    """
    before = [other.high for other in kept if other.first < part.first]
    after = [other.low for other in kept if other.first > part.first]
    if (not before or part.low >= max(before) - slack) and (
        not after or part.high <= min(after) + slack
    ):
        return True
    beside = (abs(part.low - o.high) <= slack or abs(part.high - o.low) <= slack for o in kept)
    return any(beside) and not any(part.overlaps(other, slack) for other in kept)


def _say_again(signal: str, again: list[_Segment], total: int, notes: list[Note]) -> None:
    if not again:
        return
    count = sum(part.after - part.first for part in again)
    start = min(part.low for part in again)
    text = (
        f'the stamps of {signal} go back: {many(count, total)} are of a second run, or of a clock '
        'that was set back, and are left out'
    )
    notes.append(Note('second-run', signal, start, text))


def _say_strays(signal: str, strays: list[_Segment], total: int, notes: list[Note]) -> None:
    if not strays:
        return
    count = sum(part.after - part.first for part in strays)
    text = (
        f'the stamps of {many(count, total)} of {signal} do not belong between those of their '
        'neighbours; they are left out'
    )
    notes.append(Note('nonsense-stamps', signal, strays[0].low, text))
