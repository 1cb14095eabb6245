# SPDX-License-Identifier: Apache-2.0
"""The event detector, one for live signals and recorded ones.

An event of a signal is a spike: the signal rises through ``threshold`` after having been at or
below ``reset`` (or below ``threshold`` at the start). Its time is interpolated linearly between the
two samples. It lasts until the signal is at or below ``reset`` again, which is interpolated too.

Two more limits help with noise; both are off at 0, and then change no digit:

- ``min_width``: a rise is an event only if it lasts at least this long. The end is the crossing of
  ``reset``, not of ``threshold``: a noisy spike crosses the threshold many times on its way up and
  down, and would be cut into pieces shorter than the noise that is to be kept out.
- ``refractory``: a rise that begins less than this after the beginning of the last event is none.
  A rise that does not count does not prolong the dead time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from ..scenario.criteria import RESET, THRESHOLD, Criteria
from .signal import Signal

Array = npt.NDArray[np.float64]


class Risen(NamedTuple):
    """How a signal has been above, in the unit of its times.

    ``longest`` is how long the longest rise lasted, event or not, one that goes on too; 0: none.
    ``since`` is from when on it has been at or above threshold all the time, None where it has not
    been in the end. ``last`` is its last finite value, None without one.
    """

    longest: float
    since: float | None
    last: float | None = None


class EventDetector:
    """Finds the events of one signal, sample by sample, in any unit of time.

    ``refractory`` and ``min_width`` are in that unit. Raises ParameterError for bad limits.
    """

    def __init__(
        self,
        threshold: float = THRESHOLD,
        reset: float = RESET,
        refractory: float = 0.0,
        min_width: float = 0.0,
    ) -> None:
        Criteria(threshold, reset, refractory=refractory, min_width=min_width)
        self.threshold = threshold
        self.reset = reset
        self.refractory = refractory
        self.min_width = min_width
        self.count = 0
        self._armed = False
        self._t: float | None = None
        self._value = 0.0
        self._rise: float | None = None
        """When a rise began that is not yet known to be an event."""
        self._up: float | None = None
        """When the signal rose that has not been at reset since."""
        self._longest = 0.0
        self._since: float | None = None
        self._ready = -math.inf
        """The end of the dead time."""

    def push(self, t: float, value: float) -> float | None:
        """Take the sample ``value`` at time ``t``; return the time of the event it ends, or None.

        The time is that of the rise; with ``min_width`` it is returned once the signal was up for
        so long. Samples that are not finite are passed over. Times must not decrease.
        """
        if not math.isfinite(value):
            return None
        if self._t is None:
            self._armed = value < self.threshold
        elif self._armed and value >= self.threshold:
            self._armed = False
            self._up = rise = self._crossing(self.threshold, t, value)
            self._rise = rise if rise >= self._ready else None
        event = None if self._rise is None else self._confirmed(self._rise, t, value)
        if value <= self.reset:
            if self._up is not None:
                self._longest = max(self._longest, self._crossing(self.reset, t, value) - self._up)
            self._armed, self._rise, self._up = True, None, None
        if value < self.threshold:
            self._since = None
        elif self._since is None:
            self._since = t
        self._t, self._value = t, value
        return event

    @property
    def risen(self) -> Risen:
        """How the signal has been above so far."""
        lasting = 0.0 if self._up is None or self._t is None else self._t - self._up
        last = None if self._t is None else self._value
        return Risen(max(self._longest, lasting), self._since, last)

    def _confirmed(self, rise: float, t: float, value: float) -> float | None:
        """Return the time of the pending rise, and count it, if it has lasted long enough."""
        if self.min_width:
            end = self._crossing(self.reset, t, value) if value <= self.reset else t
            if not end - rise >= self.min_width:
                return None
        self.count += 1
        self._rise = None
        if self.refractory:
            self._ready = rise + self.refractory
        return rise

    def _crossing(self, level: float, t: float, value: float) -> float:
        """Return when the line from the last sample to this one crosses ``level``."""
        assert self._t is not None
        part = (level - self._value) / (value - self._value)
        return self._t + part * (t - self._t)


@dataclass(frozen=True)
class Rises:
    """Every rise of a signal through the threshold after it was at reset, each of shape (n,).

    In the unit of the samples' times. ``start`` is the crossing of the threshold, ``end`` the next
    one of reset, NaN where the recording ends before; ``width`` is the time from start to end, or
    to the last sample where that is all that was seen.
    """

    start: Array
    end: Array
    width: Array

    def events(self, refractory: float = 0.0, min_width: float = 0.0) -> npt.NDArray[np.intp]:
        """Return the indices of the rises that are events, shape (m,)."""
        wide = np.arange(len(self.start))
        if min_width:
            wide = np.flatnonzero(self.width >= min_width)
        if not refractory:
            return wide
        kept, ready = [], -math.inf
        for i, start in zip(wide.tolist(), self.start[wide].tolist(), strict=True):
            if start >= ready:
                kept.append(i)
                ready = start + refractory
        return np.array(kept, dtype=np.intp)


def rises(
    times: Sequence[float] | Array,
    values: Sequence[float] | Array,
    threshold: float = THRESHOLD,
    reset: float = RESET,
) -> Rises:
    """Return the rises of a recorded signal, samples ``values`` at ``times``, both of shape (n,).

    All floats are those of the live detector. Raises ParameterError for bad limits, EventregError
    when times and values differ in number.
    """
    Criteria(threshold, reset)
    t, x = finite(times, values)
    low, high = x <= reset, x >= threshold
    marks = np.flatnonzero(low | high)
    is_high = high[marks]
    before = np.roll(is_high, 1)
    before[:1] = high[:1]  # the start counts as armed when it is below the threshold
    up = marks[is_high & ~before]
    ends = np.flatnonzero(low)
    place = np.searchsorted(ends, up)
    over = place < len(ends)
    down = ends[place[over]]
    start = _crossings(threshold, t, x, up)
    end = np.full(len(up), np.nan)
    end[over] = _crossings(reset, t, x, down)
    seen = np.full(len(up), t[-1] if len(t) else np.nan)
    seen[over] = end[over]
    return Rises(start, end, seen - start)


def ending(signal: Signal, threshold: float, stop: float) -> tuple[float | None, float | None]:
    """Return ``since`` and ``last`` of a recorded signal at ``stop``, see :class:`Risen`."""
    t, x = finite(*signal)
    end = int(np.searchsorted(t, stop, side='right'))
    low = np.flatnonzero(x[:end] < threshold)
    after = int(low[-1]) + 1 if len(low) else 0
    return float(t[after]) if after < end else None, float(x[end - 1]) if end else None


def detect(
    times: Sequence[float] | Array,
    values: Sequence[float] | Array,
    threshold: float = THRESHOLD,
    reset: float = RESET,
    refractory: float = 0.0,
    min_width: float = 0.0,
) -> list[float]:
    """Return the times of all events of a recorded signal, in the unit of ``times``.

    The same floats as :class:`EventDetector` returns, sample by sample. Raises as :func:`rises`.
    """
    Criteria(threshold, reset, refractory=refractory, min_width=min_width)
    found = rises(times, values, threshold, reset)
    events: list[float] = found.start[found.events(refractory, min_width)].tolist()
    return events


def finite(times: Sequence[float] | Array, values: Sequence[float] | Array) -> tuple[Array, Array]:
    """Return the samples whose value is finite, both of shape (n,); without a copy if all are.

    Raises EventregError when times and values differ in number.
    """
    t, x = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if t.shape != x.shape or t.ndim != 1:
        raise EventregError(
            f'times and values must be one-dimensional and as many, got shapes {t.shape} and '
            f'{x.shape}; give a time for each sample'
        )
    keep = np.isfinite(x)
    return (t, x) if keep.all() else (t[keep], x[keep])


def _crossings(level: float, t: Array, x: Array, at: npt.NDArray[np.intp]) -> Array:
    """Return when the lines that end in the samples ``at`` cross ``level``."""
    before = at - 1
    with np.errstate(over='ignore'):
        part = (level - x[before]) / (x[at] - x[before])
    crossings: Array = t[before] + part * (t[at] - t[before])
    return crossings
