# SPDX-License-Identifier: Apache-2.0
"""Distances between two trains of events: how different they are, as one number.

A train is an increasing array of times, shape (n,), in model time. Four measures that the field
uses, since none serves for everything: Victor-Purpura and van Rossum have a time scale and grow
with the number of events; SPIKE and ISI have none, and lie between 0 (equal) and 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import EventregError

Array = npt.NDArray[np.float64]
Times = Sequence[float] | Array


def victor_purpura(a: Times, b: Times, cost: float) -> float:
    """Return the least total cost of turning train ``a`` into ``b`` (Victor and Purpura 1996).

    An event is added or removed at cost 1, or moved at ``cost`` per model time, which never pays
    over more than 2 / ``cost``. Row by row of the table of costs, of which only those columns are
    kept: in time proportional to the events times those within that reach. Raises EventregError
    for any other cost than 0 or more.
    """
    _need(0.0 <= cost < np.inf, 'cost', 'finite and >= 0', cost)
    one, other = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    reach = 2.0 / cost if cost else np.inf
    lows = np.searchsorted(other, one - reach).tolist()
    highs = np.searchsorted(other, one + reach, side='right').tolist()
    row, first = np.zeros(1), 0  # the costs of having used up first, first + 1, ... of other
    for t, low, high in zip(one.tolist(), lows, highs, strict=True):
        row = _extended_to(row, high - first + 1)[low - first :]
        best = row + 1.0
        np.minimum(best[1:], row[:-1] + cost * np.abs(other[low:high] - t), out=best[1:])
        added = np.arange(len(best), dtype=np.float64)
        row, first = added + np.minimum.accumulate(best - added), low
    return float(_extended_to(row, len(other) - first + 1)[-1])


def _extended_to(row: Array, size: int) -> Array:
    """Return ``row`` with so many columns; in each more, one more event is added."""
    more = np.arange(1.0, size - len(row) + 1.0)
    return np.concatenate([row, row[-1] + more]) if len(more) else row


def van_rossum(a: Times, b: Times, time_constant: float) -> float:
    """Return the distance of the trains filtered by a decaying exponential (van Rossum 2001).

    Normalised so that one event more makes 1. In time proportional to the number of events, by the
    running sum of Houghton and Kreuz (2012). Raises EventregError for time_constant <= 0.
    """
    _need(time_constant > 0.0, 'time_constant', '> 0', time_constant)
    times = np.concatenate([a, b]) / time_constant
    order = np.argsort(times, kind='stable')
    signs = np.repeat([1.0, -1.0], [len(a), len(b)])[order].tolist()
    decays = np.exp(-np.diff(times[order], prepend=-np.inf)).tolist()
    total = trace = 0.0
    for sign, decay in zip(signs, decays, strict=True):
        trace *= decay
        total += 1.0 + 2.0 * sign * trace
        trace += sign
    return math.sqrt(max(total, 0.0))


def spike_distance(a: Times, b: Times, start: float, stop: float) -> float:
    """Return the SPIKE-distance over ``start`` to ``stop`` (Kreuz et al. 2013).

    The mean of how far away, for the events around each instant, the nearest event of the other
    train is, relative to the intervals. A train without events counts as one with events at both
    edges. Raises EventregError when stop <= start or an event lies outside.
    """
    pieces = _pieces(a, b, start, stop)
    near_a, near_b = _nearest(pieces.a, pieces.b), _nearest(pieces.b, pieces.a)
    mean = 0.5 * (pieces.interval_a + pieces.interval_b)
    ends = []
    for t in (pieces.left, pieces.right):
        s_a = _between(t, pieces.a, pieces.of_a, near_a)
        s_b = _between(t, pieces.b, pieces.of_b, near_b)
        ends.append(0.5 * (s_a * pieces.interval_b + s_b * pieces.interval_a) / mean**2)
    return pieces.average(0.5 * (ends[0] + ends[1]))  # it is a line in each piece


def isi_distance(a: Times, b: Times, start: float, stop: float) -> float:
    """Return the ISI-distance over ``start`` to ``stop`` (Kreuz et al. 2007).

    The mean of the relative difference of the intervals around each instant. Edges, trains without
    events and errors as in :func:`spike_distance`.
    """
    pieces = _pieces(a, b, start, stop)
    larger = np.maximum(pieces.interval_a, pieces.interval_b)
    return pieces.average(np.abs(pieces.interval_a - pieces.interval_b) / larger)


@dataclass(frozen=True)
class _Pieces:
    """The span cut at every event of both trains; ``of_a`` is the interval of a that it is in.

    ``a`` and ``b`` are the trains with one more event at each end, outside the span: as far away as
    the next interval is long, or at the edge if that is further.
    """

    a: Array
    b: Array
    left: Array
    right: Array
    of_a: npt.NDArray[np.intp]
    of_b: npt.NDArray[np.intp]

    @property
    def interval_a(self) -> Array:
        """The length of the interval of a around each piece."""
        return self.a[self.of_a + 1] - self.a[self.of_a]

    @property
    def interval_b(self) -> Array:
        """The length of the interval of b around each piece."""
        return self.b[self.of_b + 1] - self.b[self.of_b]

    def average(self, values: Array) -> float:
        """Return the mean over time of what has one value per piece."""
        return float(np.average(values, weights=self.right - self.left))


def _pieces(a: Times, b: Times, start: float, stop: float) -> _Pieces:
    _need(stop > start, 'stop', f'> start ({start:g})', stop)
    one, other = _extended(a, start, stop), _extended(b, start, stop)
    edges = np.unique(np.concatenate([[start, stop], one[1:-1], other[1:-1]]))
    left, right = edges[:-1], edges[1:]
    of_a, of_b = (np.searchsorted(train, left, side='right') - 1 for train in (one, other))
    return _Pieces(one, other, left, right, of_a, of_b)


def _extended(times: Times, start: float, stop: float) -> Array:
    t = np.asarray(times if len(times) else [start, stop], dtype=np.float64)
    if t[0] < start or t[-1] > stop:
        raise EventregError(
            f'events must lie between start {start:g} and stop {stop:g}, got {t[0]:g} to '
            f'{t[-1]:g}; give a span that holds them'
        )
    first, last = (t[1] - t[0], t[-1] - t[-2]) if len(t) > 1 else (0.0, 0.0)
    return np.concatenate([[min(start, t[0] - first)], t, [max(stop, t[-1] + last)]])


def _nearest(train: Array, other: Array) -> Array:
    """Return how far each event is from the nearest of ``other``; at the ends as the next one."""
    t = train[1:-1]
    after = np.searchsorted(other, t).clip(1, len(other) - 1)
    near = np.minimum(np.abs(t - other[after - 1]), np.abs(other[after] - t))
    return np.concatenate([near[:1], near, near[-1:]])


def _between(t: Array, train: Array, of: npt.NDArray[np.intp], values: Array) -> Array:
    """Return ``values``, given at the events of ``train``, on the line between two of them."""
    part = (t - train[of]) / (train[of + 1] - train[of])
    between: Array = values[of] + part * (values[of + 1] - values[of])
    return between


def _need(holds: bool, name: str, rule: str, value: float) -> None:
    if not holds:
        raise EventregError(f'{name} must be {rule}, got {value:g}; give another value')
