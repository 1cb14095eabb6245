# SPDX-License-Identifier: Apache-2.0
"""What has arrived of one input: its last samples, and its line over a given step."""

from __future__ import annotations

import math
import sys
from collections import deque
from typing import NamedTuple

from ..simulation.hold import line
from .duration_histogram import DurationHistogram
from .tick_grid import SECOND

KEPT = 256
"""Samples kept, enough for the steps that a late block catches up on."""

SNAP = 0.25
"""A stamp that is late by less than this part of a step belongs to the instant before it."""

CLOSEST = 0.5
"""Samples closer than this part of a step make no line: two writers, or a burst after a pause."""

RESTART = 1.0
"""Seconds back from which on a stamp is not out of order: the clock itself went back."""

GAP = 1.8
"""An interval of more than this many usual periods is a gap."""

FIRST = 8
"""Intervals before the usual one is known well enough to recognise a gap."""

FEW, PLAUSIBLE = 200, 10.0
"""So many numbers ahead, by more than this factor faster than usual, are another writer's."""

GUARD = 0.125
"""Samples stamped within this part of a step before its end belong to the next one."""


JUMP = 5.0
"""A sample further than this from the one before is believed once the next one is near it."""


class Dropped(NamedTuple):
    """How many samples were not believed: not finite, beyond the limit, alone far off."""

    not_finite: int = 0
    out_of_range: int = 0
    outliers: int = 0

    def since(self, before: Dropped) -> Dropped:
        """Return how many more there are than ``before``."""
        return Dropped(*(now - then for now, then in zip(self, before, strict=True)))


class StampedInput:
    """The samples of one input, by time stamp in nanoseconds."""

    def __init__(self) -> None:
        self._kept: deque[tuple[int, float]] = deque(maxlen=KEPT)
        self._newest: tuple[int, float] | None = None
        self.received = 0
        self.dropped = Dropped()
        self.limit = sys.float_info.max
        """Samples of larger magnitude are dropped; so are, at any limit, infinite ones."""
        self._suspect: tuple[int, float] | None = None
        self.sparse = False
        """Whether the sender leaves out samples on purpose."""
        self.patience = math.inf
        """Seconds without a sample that are a gap then."""
        self.out_of_order = 0
        self.lost = 0
        self.gaps = 0
        self.used: int | None = None
        """The stamp of the sample that the last step used, None when it used none."""
        self.period = DurationHistogram()
        self.jitter = DurationHistogram()
        """How far each interval was from the usual one."""
        self._number: int | None = None
        self._usual = self._sent_every = 0.0

    @property
    def last_stamp(self) -> int | None:
        """The stamp of the newest sample, or None when nothing has arrived."""
        return self._newest[0] if self._newest is not None else None

    @property
    def begun(self) -> bool:
        """Whether there is a sample that a step may use."""
        return self._newest is not None

    @property
    def _last_seen(self) -> int | None:
        """The stamp of the newest sample, believed or not yet."""
        return self._suspect[0] if self._suspect is not None else self.last_stamp

    def push(self, stamp: int, value: float, number: int | None = None) -> bool:
        """Take a sample with its writer's ``number``, where it is known.

        Returns False, and counts it, when it is not finite, beyond the limit, comes after a newer
        one, or twice, or is not believed yet. A number that was left out counts as lost.
        """
        last = self._last_seen
        since = None if last is None else (stamp - last) / SECOND
        if number is not None:
            self._note_number(number, since)
        if not abs(value) <= self.limit:
            self._drop(value)
            return False
        if since is not None:
            if since < -RESTART:
                self._forget()
            elif since <= 0.0:
                self.out_of_order += 1
                return False
            else:
                self._note_period(since)
        self.received += 1
        return self._believe((stamp, value))

    def _keep(self, sample: tuple[int, float]) -> None:
        self._newest = sample
        self._kept.append(sample)

    def _forget(self) -> None:
        self._kept.clear()
        self._newest = self._suspect = None

    def _drop(self, value: float) -> None:
        bad, far, alone = self.dropped
        infinite = not math.isfinite(value)
        self.dropped = Dropped(bad + infinite, far + (not infinite), alone)

    def _believe(self, sample: tuple[int, float]) -> bool:
        """Keep a sample that is near the last one, or, after a jump, near the one that jumped."""
        suspect, self._suspect = self._suspect, None
        if self._newest is not None and abs(sample[1] - self._newest[1]) > JUMP:
            if suspect is None or abs(sample[1] - suspect[1]) > JUMP:
                self._suspect = sample
            else:
                self._keep(suspect)
                suspect = None
        if suspect is not None:
            self.dropped = self.dropped._replace(outliers=self.dropped.outliers + 1)
        if self._suspect is None:
            self._keep(sample)
        return self._suspect is None

    def _note_number(self, number: int, since: float | None) -> None:
        """Count the samples between the last one and ``number``, if the same writer sent both.

        ``since``: the seconds between their stamps.
        """
        before, self._number = self._number, number
        if before is None or since is None:
            return
        if since <= 0.0:  # late or twice
            self._number = max(before, number)
        elif number > before:
            self._count_lost(number - before, since)

    def _count_lost(self, ahead: int, since: float) -> None:
        """Count what is missing of ``ahead`` numbers, unless time was too short to send it all."""
        each = since / ahead
        if ahead < FEW or each * PLAUSIBLE >= self._sent_every:
            self.lost += ahead - 1
            self._sent_every += 0.05 * (each - self._sent_every) if self._sent_every else each

    def _note_period(self, seconds: float) -> None:
        self.period.add(seconds)
        count = self.period.count
        if count == 1:
            self._usual = seconds
        self.jitter.add(abs(seconds - self._usual))
        if seconds > self.patience if self.sparse else self._is_gap(seconds):
            self.gaps += 1
        # A gap moves the usual period too, but no further than the interval that is just no gap.
        self._usual += max(0.05, 1.0 / count) * (min(seconds, GAP * self._usual) - self._usual)

    def _is_gap(self, seconds: float) -> bool:
        return self.period.count > FIRST and seconds > GAP * self._usual

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
            self.used = None
            return None
        stamp, newest = kept[i]
        self.used = stamp
        age = -_on_grid((stamp - start) / period)
        if i == 0:
            return line(newest, newest, age, 1.0, 0.0)
        before, previous = kept[i - 1]
        gap = -age - _on_grid((before - start) / period)
        if gap < CLOSEST:
            return line(newest, newest, age, 1.0, 0.0)
        return line(newest, previous, age, gap, horizon)


def _on_grid(steps: float) -> float:
    """Return ``steps``, or the instant of the grid that it is only a little late for."""
    instant = math.floor(steps)
    return float(instant) if steps - instant < SNAP else steps
