# SPDX-License-Identifier: Apache-2.0
"""Trains of events: how regular one is, how well two agree, and from when on a loop is settled.

A train is an increasing sequence of times in model time, shape (n,). A figure that too few events
define is None.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..scenario.criteria import WINDOW
from .rejection import ENOUGH, match

Array = npt.NDArray[np.float64]
Times = Sequence[float] | Array

BURST = 0.25
"""Events closer than this part of the mean interval may be one burst."""

LEAST = 3
"""Events that make a burst."""


@dataclass(frozen=True)
class Burst:
    """Events in quick succession: the times of the first and the last, and how many."""

    start: float
    stop: float
    count: int


@dataclass(frozen=True)
class Train:
    """The figures of one train over its span; intervals and widths in model time.

    ``rate`` is in events per model time. ``cv`` is the coefficient of variation of the intervals:
    0 for a clock, 1 for a Poisson process. ``cv2`` (Holt et al. 1996) and ``lv`` (Shinomoto et al.
    2003) compare neighbouring intervals only, so that a slow change of the rate leaves them alone.
    """

    count: int
    rate: float | None
    interval_mean: float | None
    interval_min: float | None
    interval_max: float | None
    cv: float | None
    cv2: float | None
    lv: float | None
    width_median: float | None
    bursts: tuple[Burst, ...]


def describe(times: Times, start: float, stop: float, widths: Times = ()) -> Train:
    """Return the figures of the events from ``start`` to ``stop``, both included.

    ``widths``, if any, are how long each event of ``times`` lasts; see :class:`.events.Rises`.
    """
    t = np.asarray(times, dtype=np.float64)
    inside = (t >= start) & (t <= stop)
    t = t[inside]
    wide = np.asarray(widths, dtype=np.float64)[inside] if len(widths) else np.empty(0)
    intervals = np.diff(t)
    some = len(intervals) > 0
    return Train(
        count=len(t),
        rate=len(t) / (stop - start) if stop > start else None,
        interval_mean=float(intervals.mean()) if some else None,
        interval_min=float(intervals.min()) if some else None,
        interval_max=float(intervals.max()) if some else None,
        cv=_cv(intervals),
        cv2=cv2(intervals),
        lv=lv(intervals),
        width_median=float(np.median(wide)) if len(wide) else None,
        bursts=bursts(t),
    )


def _cv(intervals: Array) -> float | None:
    mean = float(intervals.mean()) if len(intervals) > 1 else 0.0
    return float(intervals.std()) / mean if mean > 0.0 else None


def cv2(intervals: Array) -> float | None:
    """Return the mean of 2 |I' - I| / (I' + I) over neighbouring ``intervals``, shape (n,)."""
    contrast = _contrast(intervals)
    return float(2.0 * np.abs(contrast).mean()) if len(contrast) else None


def lv(intervals: Array) -> float | None:
    """Return the mean of 3 ((I' - I) / (I' + I))^2 over neighbouring ``intervals``, shape (n,)."""
    contrast = _contrast(intervals)
    return float(3.0 * (contrast**2).mean()) if len(contrast) else None


def _contrast(intervals: Array) -> Array:
    """Return (I' - I) / (I' + I) of neighbouring intervals; two intervals of 0 have none."""
    total = intervals[1:] + intervals[:-1]
    contrast: Array = np.diff(intervals)[total > 0.0] / total[total > 0.0]
    return contrast


def bursts(times: Times, limit: float | None = None, least: int = LEAST) -> tuple[Burst, ...]:
    """Return the runs of at least ``least`` events with intervals of at most ``limit``.

    Without a limit, a quarter of the train's mean interval: a regular train then has no burst.
    """
    t = np.asarray(times, dtype=np.float64)
    intervals = np.diff(t)
    if len(intervals) == 0:
        return ()
    close = intervals <= (BURST * float(intervals.mean()) if limit is None else limit)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], close, [False]]).astype(np.int8)))
    runs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return tuple(
        Burst(float(t[first]), float(t[last]), last - first + 1)
        for first, last in runs
        if last - first + 1 >= least
    )


@dataclass(frozen=True)
class Coincidence:
    """How well the events of a train answer those of a reference, one to one within a window.

    ``precision`` is the part of the train's events that have a partner, ``recall`` that of the
    reference's. ``latency`` holds, per pair, how much later the train's event is.
    """

    matched: int
    precision: float | None
    recall: float | None
    latency: tuple[float, ...]

    @property
    def latency_median(self) -> float | None:
        """The median latency in model time; None without a pair."""
        return float(np.median(self.latency)) if self.latency else None


def coincidence(train: Times, reference: Times, window: float = WINDOW) -> Coincidence:
    """Match the events of ``train`` with those of ``reference``, as the verdict does."""
    one, other = _plain(train), _plain(reference)
    pairs = match(one, other, window)
    return Coincidence(
        matched=len(pairs),
        precision=len(pairs) / len(one) if one else None,
        recall=len(pairs) / len(other) if other else None,
        latency=tuple(one[i] - other[j] for i, j in pairs),
    )


@dataclass(frozen=True)
class Phase:
    """The phase of a train against another, at each event ``t`` that lies between two of it.

    ``cycles`` is from -0.5 (exclusive) to 0.5: 0 means at the same time, 0.25 a quarter of the
    interval late. ``locking`` is the length of the mean unit vector: 1 where the phase stands
    still, near 0 where it drifts; ``mean`` is that vector's phase. Both None without events.
    """

    t: Array
    cycles: Array
    locking: float | None
    mean: float | None


def phase(train: Times, clock: Times) -> Phase:
    """Return the phase of the events of ``train`` between the two of ``clock`` around each."""
    t, beats = np.asarray(train, dtype=np.float64), np.asarray(clock, dtype=np.float64)
    after = np.searchsorted(beats, t, side='right')
    inside = (after > 0) & (after < len(beats))
    t, after = t[inside], after[inside]
    turned = (t - beats[after - 1]) / (beats[after] - beats[after - 1])
    cycles = np.where(turned > 0.5, turned - 1.0, turned)
    if len(t) == 0:
        return Phase(t, cycles, None, None)
    vector = complex(np.exp(2j * np.pi * cycles).mean())
    return Phase(t, cycles, abs(vector), float(np.angle(vector) / (2.0 * np.pi)))


def settling_time(unwanted: Times, disturbance: Times, enough: int = ENOUGH) -> float | None:
    """Return from when on there is no unwanted event: the time of the last one, 0 without any.

    None where fewer than ``enough`` events of the disturbance came after it: then nobody knows.
    """
    last = max(_plain(unwanted), default=0.0)
    return last if sum(t > last for t in _plain(disturbance)) >= enough else None


def _plain(times: Times) -> list[float]:
    return [float(t) for t in times]
