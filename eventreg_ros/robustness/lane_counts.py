# SPDX-License-Identifier: Apache-2.0
"""What happened in lanes: events, matches and residuals, by the formulas of :mod:`..analysis`.

These functions are compiled (:func:`..simulation.jit.compile_entry`); the lane is the last index
of every array, an index by itself. Lanes are independent, and every loop over them is plain, so
that a compiler does several at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..analysis.rejection import match
from ..simulation.lanes_source import LANES
from ..simulation.trajectory import Array

WIDE = 4
"""Steps in a spike beyond which it is not sampled too thinly, see :data:`..evidence.PER_SPIKE`."""

LEAF = 128
"""Numbers that numpy adds up without halving them."""


class Seen(NamedTuple):
    """What is seen of blocks of lanes; the block is the first index.

    ``first`` (blocks, wanted, LANES) are the samples at the start, ``last`` those at the end,
    ``level`` to ``wide`` what :func:`watch` needs per wanted signal; from ``largest`` on per plant,
    shape (blocks, plants, LANES), see :func:`gather` and :func:`mean_squares`.
    """

    first: Array
    level: Array
    times: Array
    counts: Any
    wide: Any
    last: Array
    largest: Array
    peak: Array
    means: Array


class Rules(NamedTuple):
    """How it is judged: the times ``t`` of the samples, from number ``begin`` on of which count.

    ``plants`` has shape (plants, 2): the wanted signals y and y_r, -1 for none. ``lengths`` are of
    the intervals between the samples that count, ``total`` is their sum, and ``leaves`` says how
    numpy adds them up.
    """

    t: Array
    begin: int
    plants: Any
    threshold: float
    reset: float
    lengths: Array
    total: float
    leaves: Any


def take(
    seen: Seen, rules: Rules, out: Array, residual: Array, stack: Array,
    work: Array, ring: Array, tables: Any, lags: Any, motion: Any,
) -> None:  # fmt: skip
    """Take blocks of lanes through all steps, a chunk at a time, and watch what they do.

    ``out`` is room for a chunk of samples, ``residual`` (plants,
    samples that count, LANES) for the residuals of a block, ``stack`` for partial sums; the rest is
    as ``advance`` takes it.
    """
    steps = len(rules.t) - 1
    for b in range(len(work)):
        first = last = 0
        _copy(seen.first[b], out[0])
        while last < steps:
            first, last = last, min(last + len(out) - 1, steps)
            advance(  # type: ignore[name-defined] # noqa: F821
                first, last, out, work[b], ring[b], tables[b], lags[b], *motion
            )
            for j in range(seen.level.shape[1]):
                watch(
                    out, last - first, j, rules.t[first : last + 1], rules.threshold, rules.reset,
                    seen.level[b, j], seen.times[b, j], seen.counts[b, j], seen.wide[b, j],
                )  # fmt: skip
            start = max(first + 1 if first else 0, rules.begin)
            if start <= last:
                for p in range(len(rules.plants)):
                    gather(
                        out, last - first, rules.plants[p, 0], rules.plants[p, 1],
                        residual[p, start - rules.begin :], start - first,
                        seen.largest[b, p], seen.peak[b, p],
                    )  # fmt: skip
            _copy(out[last - first], out[0])
        _copy(out[0], seen.last[b])
        for p in range(len(rules.plants)):
            mean_squares(
                residual[p], rules.lengths, rules.total, rules.leaves, seen.largest[b, p],
                stack, seen.means[b, p],
            )  # fmt: skip


def _copy(samples: Array, to: Array) -> None:
    for j in range(len(to)):
        for a in range(to.shape[1]):
            to[j, a] = samples[j, a]


def watch(
    samples: Array, rows: int, j: int, t: Array,
    threshold: float, reset: float, level: Array, times: Array, counts: Any, wide: Any,
) -> None:  # fmt: skip
    """Note the events of wanted signal ``j`` in samples 1 to ``rows`` of a chunk, at times ``t``.

    As :func:`..analysis.events.detect` finds them. ``level``, ``counts`` and ``wide`` have shape
    (LANES,), ``times`` (room, LANES); ``counts`` goes on beyond the room. ``level`` is what a
    signal must reach for an event: ``threshold``, or infinity until it has been at ``reset``.
    ``wide`` is set to 1 where a spike is seen to last more than :data:`WIDE` steps.
    """
    room = len(times)
    for r in range(1, rows + 1):
        found = 0
        for a in range(LANES):
            x = samples[r, j, a]
            found |= (x >= level[a]) | ((x <= reset) & (level[a] > threshold))
        if not found:
            continue
        for a in range(LANES):
            x, before = samples[r, j, a], samples[r - 1, j, a]
            if x >= level[a]:
                part = (threshold - before) / (x - before)
                if counts[a] < room:
                    times[counts[a], a] = t[r - 1] + part * (t[r] - t[r - 1])
                counts[a] += 1
                level[a] = np.inf
                end = r
                while end <= rows and end < r + WIDE + 2 and samples[end, j, a] > reset:
                    end += 1
                wide[a] = max(wide[a], 1 if end == r + WIDE + 2 else 0)
            if x <= reset:
                level[a] = threshold


def gather(
    samples: Array, rows: int, y: int, y_r: int,
    residual: Array, first: int, largest: Array, peak: Array,
) -> None:  # fmt: skip
    """Store y - y_r of the samples ``first`` to ``rows`` of a chunk, and its extremes.

    ``y`` and ``y_r`` are wanted signals, ``y_r`` -1 without a reference. ``residual`` is what is
    left of the table, one row of lanes per sample; ``largest`` is the magnitude's.
    """
    for r in range(first, rows + 1):
        for a in range(LANES):
            x = samples[r, y, a]
            if y_r >= 0:
                x -= samples[r, y_r, a]
            residual[r - first, a] = x
            largest[a] = max(largest[a], abs(x))
            peak[a] = max(peak[a], x)


def mean_squares(
    residual: Array, lengths: Array, total: float, leaves: Any,
    largest: Array, stack: Array, means: Array,
) -> None:  # fmt: skip
    """Set ``means`` to the time average of (residual / largest)^2, shape (LANES,).

    That is :func:`numpy.average` of the trapezoids, to the last bit: the sum is taken in the order
    of :func:`halves`, whose columns are ``leaves``. ``residual`` is overwritten; ``lengths`` are of
    the intervals, one less than its samples, ``total`` is their sum; ``stack`` is room for partial
    sums.
    """
    lanes, (starts, sizes, joins) = residual.shape[1], (leaves[0], leaves[1], leaves[2])
    for i in range(len(residual)):
        for a in range(lanes):
            part = residual[i, a] / (largest[a] if largest[a] != 0.0 else 1.0)
            residual[i, a] = part * part
    if len(residual) < 2:
        for i in range(len(residual)):
            for a in range(lanes):
                means[a] = residual[i, a]
        return
    top = 0
    for leaf in range(len(starts)):
        _leaf(residual[starts[leaf] :], sizes[leaf], lengths[starts[leaf] :], stack, top)
        top += 1
        for _ in range(joins[leaf]):
            top -= 1
            for a in range(lanes):
                stack[top - 1, a] += stack[top, a]
    for a in range(lanes):
        means[a] = stack[0, a] / total


def _leaf(square: Array, size: int, lengths: Array, stack: Array, to: int) -> None:
    """Add up the first ``size`` trapezoids as numpy adds up to :data:`LEAF` numbers."""
    eighths, lanes = stack[len(stack) - 8 :], stack.shape[1]
    for i in range(size - size % 8 if size >= 8 else 0):
        slot, length = i % 8, lengths[i]
        if i < 8:
            for a in range(lanes):
                eighths[slot, a] = 0.5 * (square[i + 1, a] + square[i, a]) * length
        else:
            for a in range(lanes):
                eighths[slot, a] += 0.5 * (square[i + 1, a] + square[i, a]) * length
    if size >= 8:
        s = eighths
        for a in range(lanes):
            stack[to, a] = ((s[0, a] + s[1, a]) + (s[2, a] + s[3, a])) + (
                (s[4, a] + s[5, a]) + (s[6, a] + s[7, a])
            )
    else:
        for a in range(lanes):
            stack[to, a] = 0.0
    for i in range(size - size % 8 if size >= 8 else 0, size):
        for a in range(lanes):
            stack[to, a] += 0.5 * (square[i + 1, a] + square[i, a]) * lengths[i]


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
    """Set ``found``, shape (blocks, 6, LANES), from the events of one plant in all lanes.

    Its rows: disturbance events, preserved, spurious and missed after ``settle``; when the last
    event came that y and y_r do not share, before ``settle`` or after; the sum of y - y_r over the
    preserved. ``times`` has shape (blocks, signals, room, LANES), ``counts`` (blocks, signals,
    LANES); ``y``, ``y_r`` and each of ``disturbances`` are signals, ``y_r`` -1 for none.
    """
    for b in range(len(times)):
        for a in range(LANES):
            all_y, all_r = _events(times[b], counts[b], y, a), _events(times[b], counts[b], y_r, a)
            late_y, late_r = all_y[_first(all_y, settle) :], all_r[_first(all_r, settle) :]
            pairs = match(late_y, late_r, window)
            latency = 0.0
            for i, j in pairs:
                latency += late_y[i] - late_r[j]
            found[b, 0, a] = 0
            for w in disturbances:
                all_w = _events(times[b], counts[b], w, a)
                found[b, 0, a] += len(all_w) - _first(all_w, settle)
            found[b, 1, a] = len(pairs)
            found[b, 2, a] = len(late_y) - len(pairs)
            found[b, 3, a] = len(late_r) - len(pairs)
            found[b, 4, a] = _last_unmatched(all_y, all_r, match(all_y, all_r, window))
            found[b, 5, a] = latency


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
