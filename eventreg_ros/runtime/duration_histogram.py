# SPDX-License-Identifier: Apache-2.0
"""Percentiles of durations, kept in constant memory while they come in."""

from __future__ import annotations

import math

from .figures import Percentiles

_FINEST = 1e-7
_RATIO = 1.05
_BINS = 500
_LOG = math.log(_RATIO)


class DurationHistogram:
    """A histogram of durations in seconds whose bins grow by 5 %, from 0.1 us to more than an hour.

    Percentiles are right to 5 %, the largest is exact. Durations below 0.1 us, negative ones too,
    count as 0.1 us.
    """

    def __init__(self) -> None:
        self.count = 0
        self.largest = 0.0
        self._bins = [0] * _BINS
        self._recent = 0.0

    def add(self, duration: float) -> None:
        """Take one duration in seconds."""
        self.count += 1
        if duration > self.largest:
            self.largest = duration
        if duration > self._recent:
            self._recent = duration
        if duration <= _FINEST:
            self._bins[0] += 1
        else:
            self._bins[min(int(math.log(duration / _FINEST) / _LOG), _BINS - 1)] += 1

    def percentile(self, percent: float) -> float:
        """Return the duration in seconds below which ``percent`` of all lie; 0 without any."""
        wanted, seen = self.count * percent / 100.0, 0
        for i, n in enumerate(self._bins):
            seen += n
            if n and seen >= wanted:
                return min(_FINEST * _RATIO ** (i + 0.5), self.largest) if i else 0.0
        return 0.0

    def take_recent(self) -> float:
        """Return the largest duration since this was last asked, in seconds."""
        recent, self._recent = self._recent, 0.0
        return recent

    @property
    def percentiles(self) -> Percentiles:
        """The 50th and the 99th percentile and the largest, in seconds."""
        return Percentiles(self.percentile(50), self.percentile(99), self.largest)
