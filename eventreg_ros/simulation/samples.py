"""What has arrived of one input: its last samples, and its line over a given step."""

from __future__ import annotations

import math
from collections import deque

from .hold import line

KEPT = 256
"""Samples kept, enough for the steps that a late block catches up on."""

SNAP = 0.25
"""A stamp that is late by less than this part of a step belongs to the instant before it."""

GUARD = 0.125
"""Samples stamped within this part of a step before its end belong to the next one."""


class Samples:
    """The samples of one input, by time stamp in nanoseconds."""

    def __init__(self) -> None:
        self._kept: deque[tuple[int, float]] = deque(maxlen=KEPT)
        self.received = 0
        self.not_finite = 0
        self.out_of_order = 0

    @property
    def last_stamp(self) -> int | None:
        """The stamp of the newest sample, or None when nothing has arrived."""
        return self._kept[-1][0] if self._kept else None

    def push(self, stamp: int, value: float) -> bool:
        """Take a sample. Returns False, and counts it, when it is not finite or comes too late."""
        if not math.isfinite(value):
            self.not_finite += 1
            return False
        if self._kept and stamp <= self._kept[-1][0]:
            self.out_of_order += 1
            return False
        self.received += 1
        self._kept.append((stamp, value))
        return True

    def over(
        self, start: int, period: float, timeout: float, horizon: float
    ) -> tuple[float, float] | None:
        """Return the input's (base, slope) over the step of ``period`` ns that begins at ``start``.

        Samples of the step's end or later are left for the next step: a peer on the same grid may
        already have sent one. None when the newest sample is older than ``timeout`` ns at the
        beginning of the step, or when there is none. ``horizon`` is in steps, see
        :func:`.hold.line`.
        """
        end = start + (1.0 - GUARD) * period
        kept = self._kept
        i = len(kept) - 1
        while i >= 0 and kept[i][0] >= end:
            i -= 1
        if i < 0 or start - kept[i][0] > timeout:
            return None
        stamp, newest = kept[i]
        age = -_on_grid((stamp - start) / period)
        if i == 0:
            return line(newest, newest, age, 1.0, 0.0)
        before, previous = kept[i - 1]
        gap = -age - _on_grid((before - start) / period)
        if gap <= 0.0:
            return line(newest, newest, age, 1.0, 0.0)
        return line(newest, previous, age, gap, horizon)


def _on_grid(steps: float) -> float:
    """Return ``steps``, or the instant of the grid that it is only a little late for."""
    instant = math.floor(steps)
    return float(instant) if steps - instant < SNAP else steps
