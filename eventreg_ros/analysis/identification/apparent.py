# SPDX-License-Identifier: Apache-2.0
"""Whether a recording shows a periodic spike train at all, and what its period is.

Everything here looks at the apparent disturbance: w itself where it was recorded, else the w that
the plant's equation asks for, given its y (and u, v). It is smoothed over one unit of model time.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...errors import EventregError
from ..events import detect
from .layout import Array, Plant
from .recorded import Recorded

SMOOTH = 1.0
"""Model time over which is averaged before spikes are looked for."""

HEIGHT = 1.9
"""How high a generator's spikes are: 1.95 at tau 1/25, 1.78 at 1/6."""

LEAST = 0.6
"""A generator's signal reaches higher than this, whatever its tau."""

PART = 0.3
"""A spike rises through this part of the height after having been below minus that."""

BEGINNING = 4
"""Intervals from which on the first one, up and down, is left out, for it may be transient, and the
others must be even. With fewer, the fit shows whether it is a generator."""

PER_PERIOD = 8
"""Samples a period, at least."""

UNEVEN = 1.25
"""Intervals between spikes that differ by more than this factor are not those of a period."""

UNSEEN = 0.25
"""An interval between spikes of which a larger part was not sampled does not count."""


@dataclass(frozen=True)
class Apparent:
    """The apparent disturbance, smoothed: ``t`` and ``w`` of shape (n,); a sensor's gain, offset.

    ``period`` is what its spikes repeat after, in model time; with several generators about.
    """

    t: Array
    w: Array
    gain: float
    offset: float
    period: float


def apparent(recorded: Recorded, generators: int = 1) -> Apparent:
    """Return the apparent disturbance.

    Raises EventregError, with the reason, if it has no spikes or too few, or, of one generator, if
    they are not periodic.
    """
    name = recorded.signal
    if np.ptp(recorded.x) == 0.0 and recorded.given is None:
        raise EventregError(
            f'{name} is constant ({recorded.x[0]:g}): no spikes, nothing to identify; record it '
            f'while the generator runs'
        )
    t, x, given = _smoothed(recorded)
    gain, offset = 1.0, 0.0
    if recorded.affine:
        low, high = np.quantile(x, [0.02, 0.98])
        gain, offset = float(high - low) / (2.0 * HEIGHT), float(high + low) / 2.0
    w = (x - offset) / gain
    if recorded.plant is not None:
        w = _undone(t, w, recorded.plant) - given
    every = float(np.median(np.diff(recorded.t)))
    return Apparent(t, w, gain, offset, _period(name, t, w, every, generators))


def _smoothed(recorded: Recorded) -> tuple[Array, Array, Array]:
    """Return means over cells of :data:`SMOOTH`: of the times, the samples, what is given."""
    cells = np.unique(np.floor(recorded.t / SMOOTH), return_inverse=True)[1]
    counts = np.bincount(cells)
    given = np.zeros_like(recorded.t) if recorded.given is None else recorded.given
    t, x, v = (np.bincount(cells, a) / counts for a in (recorded.t, recorded.x, given))
    return t, x, v


def _undone(t: Array, y: Array, plant: Plant) -> Array:
    """Return the drive that the plant's equation (eq. fhn) asks for, from smoothed samples of y."""
    recovery = np.zeros_like(y)
    for n, dt in enumerate(np.diff(t)):
        fade = np.exp(-plant.tau * dt)
        recovery[n + 1] = fade * recovery[n] + (1.0 - fade) * 0.5 * (y[n] + y[n + 1])
    slope = np.gradient(y, t)
    return (slope - y + y * y * y / 3.0 + recovery) / plant.k + y


def _period(name: str, t: Array, w: Array, every: float, generators: int) -> float:
    high = float(np.quantile(np.abs(w), 0.98))
    if high < LEAST:
        raise EventregError(
            f'{name} shows no spikes: what drives it stays within {high:.2g}, and a generator '
            f'reaches {HEIGHT:g}; record a generator that runs; a running loop needs its u, and a '
            f'sensor with a gain affine'
        )
    spikes = [np.array(detect(t, sign * w, PART * high, -PART * high)) for sign in (1.0, -1.0)]
    up, down = (len(times) for times in spikes)
    if up + down < 3 or max(up, down) < 2:
        raise EventregError(
            f'{name} has {up} spike{"s" * (up != 1)} up and {down} down in {t[-1]:.4g} of model '
            f'time: too few periods; two of the one and one of the other are needed, record longer'
        )
    _check_samples(name, every, float(np.median(np.concatenate([np.diff(s) for s in spikes]))))
    intervals = np.concatenate([_without_gaps(times, t) for times in spikes])
    if not len(intervals):
        raise EventregError(f'{name} has no two spikes without a gap between; record it whole')
    if len(intervals) < BEGINNING:  # what is made up at the beginning makes them shorter
        return float(intervals.max())
    later = np.concatenate([_without_gaps(times[1:], t) for times in spikes])
    intervals = later if len(later) else intervals
    if generators == 1:
        _check_even(name, intervals)
    return float(np.median(intervals))


def _check_samples(name: str, every: float, period: float) -> None:
    if PER_PERIOD * every > period:
        raise EventregError(
            f'{name} is sampled too thinly: every {every:.3g} of model time, where its spikes '
            f'repeat after {period:.3g}; at least {PER_PERIOD} samples a period are needed'
        )


def _without_gaps(spikes: Array, t: Array) -> Array:
    """Return the intervals between spikes, but for those that were not seen whole."""
    gaps = np.diff(t)
    kept = []
    for start, end in pairwise(spikes):
        if gaps[(t[1:] > start) & (t[:-1] < end)].max() <= UNSEEN * (end - start):
            kept.append(end - start)
    return np.array(kept)


def _check_even(name: str, intervals: Array) -> None:
    low, high = float(intervals.min()), float(intervals.max())
    if high > UNEVEN * low:
        raise EventregError(
            f'{name} is not periodic: the intervals between its spikes vary from {low:.3g} to '
            f'{high:.3g} of model time; take a part where the generator is steady, or ask for '
            f'2 generators'
        )
