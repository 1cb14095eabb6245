# SPDX-License-Identifier: Apache-2.0
"""Whether values can be believed: two sources in one signal, and samples far off all others."""

from __future__ import annotations

import numpy as np

from .channel import Index
from .messages import Values

_BLOCK = 2**15
_WINDOW = 32
_TURNS = 12
"""A window of a smooth signal turns once or twice; where two sources alternate, more often."""
_ALIKE = 0.15
_FARTHER = 2.0
_TOGETHER = ((3, 3), (7, 40))
"""One window and so many more within so many: noise makes one now and then, never so many."""
_BACK = 5
_SIZE = 1e-3
_WILD = 1e6
_LONE = 3
"""So many lone samples are an accident, more are the nature of the signal."""


def two_sources(values: Values) -> int | None:
    """Return from which sample on two sources alternate, None where they do not.

    A sample of theirs is farther from the one before than from the one before that, or much closer
    to one of the last few than to the last. In a smooth signal the last one is the closest, and
    noise is as far from any: of five, the nearest is still a quarter as far away as the last.
    """
    count = len(values) // _WINDOW - 1
    if count < 1:
        return None
    with np.errstate(all='ignore'):
        windows = _turning(values[: (count + 1) * _WINDOW])
        found = windows[_alternate(values, windows)]
    starts = [found[:-more][found[more:] - found[:-more] <= within] for more, within in _TOGETHER]
    first = [int(start[0]) for start in starts if len(start)]
    return min(first) * _WINDOW if first else None


def _turning(values: Values) -> Index:
    """Return the windows, except the first, in which the signal turns often."""
    found = []
    for at in range(0, len(values), _BLOCK):
        steps = np.diff(values[at : at + _BLOCK + 2])
        turns = steps[1:] * steps[:-1] < 0
        whole = len(turns) // _WINDOW
        counts = turns[: whole * _WINDOW].reshape(whole, _WINDOW).sum(1)
        found.append(np.flatnonzero(counts >= _TURNS) + at // _WINDOW)
    windows = np.concatenate(found)
    return windows[windows > 0]


def _alternate(values: Values, windows: Index) -> Index:
    """Return which windows hold samples of two sources."""
    scale = _spread(values)
    found = []
    for at in range(0, len(windows), _BLOCK // _WINDOW):
        part = windows[at : at + _BLOCK // _WINDOW, None] * _WINDOW + np.arange(-_BACK, _WINDOW)
        table = values[part]
        apart = [np.abs(table[:, _BACK:] - table[:, _BACK - k : -k]) for k in range(1, _BACK + 1)]
        step, second, nearest = apart[0].mean(1), apart[1].mean(1), np.minimum.reduce(apart)
        levels = (nearest == 0.0).mean(1) > 0.5  # of a few values each is near another
        turns = (nearest == apart[0]).mean(1) < 0.2  # as in a period of a few samples
        alike = (nearest.mean(1) < _ALIKE * step) & ~levels & ~turns
        two = (step > _FARTHER * second) | alike
        found.append(np.flatnonzero(two & (step > _SIZE * scale)) + at)
    return np.concatenate(found) if found else np.empty(0, np.intp)


def _spread(values: Values) -> float:
    """Return the range of most of the values."""
    some = values[:: max(len(values) // 4096, 1)]
    some = some[np.isfinite(some)]
    if not len(some):
        return 0.0
    low, high = np.percentile(some, [2, 98])
    return float(max(high - low, 1e-6 * abs(low)))


def wild_samples(values: Values) -> Index:
    """Return the samples that are larger than all others by so much that no signal can be."""
    if not (values > _WILD).any() and not (values < -_WILD).any():
        return np.empty(0, np.intp)
    wild = np.isfinite(values) & (np.abs(values) > _WILD * max(_spread(values), 1.0))
    return np.flatnonzero(wild)


def lone_samples(values: Values) -> list[int]:
    """Return the few samples that are far off both neighbours, which are close to each other."""
    if len(values) < 16:
        return []
    with np.errstate(all='ignore'):
        places, heights, largest = _peaks(values)
        if largest == np.inf:
            places, heights, largest = _peaks(np.where(np.isfinite(values), values, np.nan))
        highest = heights.max(initial=0.0)
        if not highest > 0.5 * largest or np.count_nonzero(heights > 0.5 * highest) > _LONE:
            return []
        return _judged(values, places, heights)


def _peaks(values: Values) -> tuple[Index, Values, float]:
    """Return where the signal turns, the smaller of the steps to either side, and the largest step.

    Steps from or to what is not finite do not count.
    """
    places, heights, largest = [], [], 0.0
    for at in range(0, len(values) - 2, _BLOCK):
        steps = np.diff(values[at : at + _BLOCK + 2])
        turns = np.flatnonzero(steps[1:] * steps[:-1] < 0)
        places.append(turns + at + 1)
        heights.append(np.minimum(np.abs(steps[turns]), np.abs(steps[turns + 1])))
        largest = max(largest, float(np.nanmax(np.abs(steps), initial=0.0)))
    return np.concatenate(places), np.concatenate(heights), largest


def _judged(values: Values, places: Index, heights: Values) -> list[int]:
    order = np.argsort(heights)[::-1][: _LONE + 1]
    steps = np.abs(np.diff(values))
    steps[~np.isfinite(steps)] = 0.0
    found: list[int] = []
    for k in order.tolist():
        place, height = int(places[k]), float(heights[k])
        near = np.r_[steps[max(place - 6, 0) : place - 1], steps[place + 1 : place + 6]]
        rest = steps.copy()
        for other in (*found, place):
            rest[other - 1 : other + 1] = 0.0
        if height > 3.0 * rest.max() or (height > 0.5 * rest.max() and height > 20.0 * near.max()):
            found.append(place)
    return sorted(found) if len(found) <= _LONE else []
