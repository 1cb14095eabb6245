# SPDX-License-Identifier: Apache-2.0
"""What happened in lanes: events, matches and residuals, by the formulas of :mod:`..analysis`.

These functions are compiled (:func:`..simulation.jit.compile_entry`); arrays are flat, with the
lane as the last index. Lanes are independent, and every loop over them is plain, so that a compiler
does several at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..analysis.rejection import match
from ..simulation.lanes_source import LANES
from ..simulation.trajectory import Array

LEAF = 128
"""Numbers that numpy adds up without halving them."""


def watch(
    samples: Array, rows: int, width: int, j: int, t: Array,
    threshold: float, reset: float, level: Array, times: Array, counts: Any,
) -> None:  # fmt: skip
    """Note the events of wanted signal ``j`` in samples 1 to ``rows`` of a chunk, at times ``t``.

    As :func:`..analysis.events.detect` finds them. ``level`` and ``counts`` have shape (LANES,),
    ``times`` (room * LANES,); ``counts`` goes on beyond the room. ``level`` is what a signal must
    reach for an event: ``threshold``, or infinity until it has been at ``reset``.
    """
    room = len(times) // LANES
    for r in range(1, rows + 1):
        found = 0
        now = (r * width + j) * LANES
        for a in range(LANES):
            found += 1 if samples[now + a] >= level[a] else 0
        if found:
            for a in range(LANES):
                if samples[now + a] >= level[a]:
                    x, before = samples[now + a], samples[now - width * LANES + a]
                    part = (threshold - before) / (x - before)
                    if counts[a] < room:
                        times[counts[a] * LANES + a] = t[r - 1] + part * (t[r] - t[r - 1])
                    counts[a] += 1
                    level[a] = np.inf
        for a in range(LANES):
            level[a] = threshold if samples[now + a] <= reset else level[a]


def gather(
    samples: Array, rows: int, width: int, y: int, y_r: int,
    residual: Array, first: int, largest: Array, peak: Array,
) -> None:  # fmt: skip
    """Store y - y_r of the samples ``first`` to ``rows`` of a chunk, and its extremes.

    ``y`` and ``y_r`` are wanted signals, ``y_r`` -1 without a reference. ``residual`` is what is
    left of the table, one row of lanes per sample; ``largest`` is the magnitude's.
    """
    for r in range(first, rows + 1):
        at, to = r * width * LANES, (r - first) * LANES
        for a in range(LANES):
            x = samples[at + y * LANES + a]
            if y_r >= 0:
                x = x - samples[at + y_r * LANES + a]
            residual[to + a] = x
            largest[a] = max(largest[a], abs(x))
            peak[a] = max(peak[a], x)


def mean_squares(
    residual: Array, n: int, lengths: Array, total: float, starts: Any, sizes: Any, joins: Any,
    largest: Array, stack: Array, means: Array,
) -> None:  # fmt: skip
    """Set ``means`` to the time average of (residual / largest)^2, shape (LANES,).

    That is :func:`numpy.average` of the trapezoids, to the last bit: the sum is taken in the order
    of :func:`halves`. ``residual`` holds ``n`` samples and is overwritten; ``lengths`` (n - 1,) are
    of the intervals, ``total`` is their sum.
    """
    for i in range(n):
        for a in range(LANES):
            part = residual[i * LANES + a] / (largest[a] if largest[a] != 0.0 else 1.0)
            residual[i * LANES + a] = part * part
    top = 0
    for leaf in range(len(starts)):
        _leaf(residual, starts[leaf], sizes[leaf], lengths, stack, top * LANES)
        top += 1
        for _ in range(joins[leaf]):
            top -= 1
            for a in range(LANES):
                stack[(top - 1) * LANES + a] += stack[top * LANES + a]
    for a in range(LANES):
        means[a] = stack[a] / total


def _leaf(square: Array, start: int, size: int, lengths: Array, stack: Array, to: int) -> None:
    """Add up ``size`` trapezoids from ``start`` on, as numpy adds up to :data:`LEAF` numbers."""
    eighths = stack.shape[0] - 8 * LANES
    for i in range(size - size % 8 if size >= 8 else 0):
        at, slot, length = (start + i) * LANES, eighths + i % 8 * LANES, lengths[start + i]
        if i < 8:
            for a in range(LANES):
                stack[slot + a] = 0.5 * (square[at + LANES + a] + square[at + a]) * length
        else:
            for a in range(LANES):
                stack[slot + a] += 0.5 * (square[at + LANES + a] + square[at + a]) * length
    if size >= 8:
        s = eighths
        for a in range(LANES):
            stack[to + a] = (
                (stack[s + a] + stack[s + LANES + a])
                + (stack[s + 2 * LANES + a] + stack[s + 3 * LANES + a])
            ) + (
                (stack[s + 4 * LANES + a] + stack[s + 5 * LANES + a])
                + (stack[s + 6 * LANES + a] + stack[s + 7 * LANES + a])
            )
    else:
        for a in range(LANES):
            stack[to + a] = 0.0
    for i in range(size - size % 8 if size >= 8 else 0, size):
        at, length = (start + i) * LANES, lengths[start + i]
        for a in range(LANES):
            stack[to + a] += 0.5 * (square[at + LANES + a] + square[at + a]) * length


def halves(start: int, size: int) -> list[tuple[int, int, int]]:
    """Return the leaves of numpy's pairwise sum: (start, size, partial sums to join after it)."""
    if size <= LEAF:
        return [(start, size, 0)]
    half = size // 2
    half -= half % 8
    left, right = halves(start, half), halves(start + half, size - half)
    (at, last, joins) = right[-1]
    return [*left, *right[:-1], (at, last, joins + 1)]


def tally(
    times: Array,
    counts: Any,
    y: int,
    y_r: int,
    disturbances: Any,
    settle: float,
    window: float,
    found: Array,
) -> None:
    """Set ``found``, shape (6, LANES), from the events of one plant in all lanes.

    Its rows: disturbance events, preserved, spurious and missed after ``settle``; when the last
    event came that y and y_r do not share, before ``settle`` or after; the sum of y - y_r over the
    preserved. ``times`` has shape (signals, room, LANES), ``counts`` (signals, LANES); ``y``,
    ``y_r`` and each of ``disturbances`` are signals, ``y_r`` -1 for none.
    """
    for a in range(LANES):
        all_y, all_r = _events(times, counts, y, a), _events(times, counts, y_r, a)
        late_y, late_r = all_y[_first(all_y, settle) :], all_r[_first(all_r, settle) :]
        pairs = match(late_y, late_r, window)
        latency = 0.0
        for i, j in pairs:
            latency += late_y[i] - late_r[j]
        found[0, a] = 0
        for w in disturbances:
            all_w = _events(times, counts, w, a)
            found[0, a] += len(all_w) - _first(all_w, settle)
        found[1, a] = len(pairs)
        found[2, a] = len(late_y) - len(pairs)
        found[3, a] = len(late_r) - len(pairs)
        found[4, a] = _last_unmatched(all_y, all_r, match(all_y, all_r, window))
        found[5, a] = latency


def _events(times: Array, counts: Any, signal: int, lane: int) -> Any:
    """Return the times of the events of one signal in one lane; none for signal -1."""
    count = min(counts[signal, lane], times.shape[1]) if signal >= 0 else 0
    return times[max(signal, 0), :count, lane].copy()


def _first(times: Array, settle: float) -> int:
    """Return the place of the first of increasing ``times`` at or after ``settle``."""
    i = 0
    while i < len(times) and times[i] < settle:
        i += 1
    return i


def _last_unmatched(y: Array, y_r: Array, pairs: Any) -> float:
    """Return the time of the last event of either that is in no pair; 0 where there is none."""
    i, j, k = len(y) - 1, len(y_r) - 1, len(pairs) - 1
    while k >= 0 and pairs[k][0] == i and pairs[k][1] == j:
        i, j, k = i - 1, j - 1, k - 1
    last = 0.0
    if i >= 0 and (k < 0 or pairs[k][0] != i):
        last = max(last, y[i])
    if j >= 0 and (k < 0 or pairs[k][1] != j):
        last = max(last, y_r[j])
    return last
