"""The event detector, one for live signals and recorded ones.

An event of a signal is a spike: the signal rises through ``threshold`` after having been at or
below ``reset`` (or below ``threshold`` at the start). Its time is interpolated linearly between the
two samples.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..models.neuron import FOLD

THRESHOLD = FOLD
RESET = 0.0


class EventDetector:
    """Finds the events of one signal, sample by sample, in any unit of time."""

    def __init__(self, threshold: float = THRESHOLD, reset: float = RESET) -> None:
        if not reset < threshold:
            raise ValueError(f'reset must be < threshold ({threshold}), got {reset}')
        self.threshold = threshold
        self.reset = reset
        self.count = 0
        self._armed = False
        self._t: float | None = None
        self._value = 0.0

    def push(self, t: float, value: float) -> float | None:
        """Take the sample ``value`` at time ``t``; return the time of the event it ends, or None.

        Samples that are not finite are passed over. Times must not decrease.
        """
        if not math.isfinite(value):
            return None
        event = None
        if self._t is None:
            self._armed = value < self.threshold
        elif self._armed and value >= self.threshold:
            part = (self.threshold - self._value) / (value - self._value)
            event = self._t + part * (t - self._t)
            self._armed = False
            self.count += 1
        if value <= self.reset:
            self._armed = True
        self._t, self._value = t, value
        return event


def detect(
    times: Iterable[float],
    values: Iterable[float],
    threshold: float = THRESHOLD,
    reset: float = RESET,
) -> list[float]:
    """Return the times of all events of a recorded signal, in the unit of ``times``."""
    push = EventDetector(threshold, reset).push
    found = (push(t, value) for t, value in zip(times, values, strict=True))
    return [t for t in found if t is not None]
