# SPDX-License-Identifier: Apache-2.0
"""Which events of y are asked for, which are not, and which are missing."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import astuple, dataclass
from typing import NamedTuple

from ..scenario.criteria import SETTLE, WINDOW

REJECTED, NOT_REJECTED, UNDECIDED = 'rejected', 'not rejected', 'undecided'

ENOUGH = 3
"""Events of w after which a verdict may be given."""


@dataclass(frozen=True)
class Rejection:
    """Counts of events after the settling time."""

    disturbance_events: int
    reference_events: int
    preserved: int
    spurious: int
    missed: int

    @property
    def ratio(self) -> float | None:
        """The part of the disturbance's events that leave no trace in y; None without any."""
        if self.disturbance_events == 0:
            return None
        return 1.0 - self.spurious / self.disturbance_events

    @property
    def verdict(self) -> str:
        """``rejected``, ``not rejected``, or ``undecided`` when w has too few events."""
        if self.disturbance_events < ENOUGH:
            return UNDECIDED
        return NOT_REJECTED if self.spurious or self.missed else REJECTED


def match(a: Sequence[float], b: Sequence[float], window: float) -> list[tuple[int, int]]:
    """Pair events of ``a`` and ``b`` (each in increasing order) one to one, as many as can be.

    Returns the pairs' indices (i, j), both increasing. Two events may pair when they are at most
    ``window`` apart. Taking the earliest pair first is optimal, since every event's partners form
    an interval that moves on with the event.
    """
    pairs = []
    i = j = 0
    while i < len(a) and j < len(b):
        if abs(a[i] - b[j]) <= window:
            pairs.append((i, j))
            i += 1
            j += 1
        elif a[i] < b[j]:
            i += 1
        else:
            j += 1
    return pairs


class Outcomes(NamedTuple):
    """What became of the events of y and y_r, by time."""

    preserved: list[float]
    """Events of y with a partner in y_r."""
    spurious: list[float]
    """Events of y alone."""
    missed: list[float]
    """Events of y_r alone."""


def outcomes(
    y: Sequence[float],
    y_r: Sequence[float],
    settle: float = SETTLE,
    window: float = WINDOW,
    until: float = math.inf,
) -> Outcomes:
    """Say what became of each event of y and y_r from ``settle`` to ``until`` (model time).

    Without a reference pass no events of y_r: then every event of y is spurious.
    """
    y, y_r = _within(settle, until, y), _within(settle, until, y_r)
    pairs = match(y, y_r, window)
    matched, answered = {i for i, _ in pairs}, {j for _, j in pairs}
    return Outcomes(
        preserved=[y[i] for i, _ in pairs],
        spurious=[t for i, t in enumerate(y) if i not in matched],
        missed=[t for j, t in enumerate(y_r) if j not in answered],
    )


def reject(
    w: Sequence[float],
    y: Sequence[float],
    y_r: Sequence[float],
    settle: float = SETTLE,
    window: float = WINDOW,
    until: float = math.inf,
) -> Rejection:
    """Count, from the event times of w, y and y_r, those from ``settle`` to ``until``."""
    return counted(outcomes(y, y_r, settle, window, until), len(_within(settle, until, w)))


def counted(found: Outcomes, disturbance_events: int) -> Rejection:
    """Return the counts of ``found``, where the disturbance had so many events."""
    return Rejection(
        disturbance_events=disturbance_events,
        reference_events=len(found.preserved) + len(found.missed),
        preserved=len(found.preserved),
        spurious=len(found.spurious),
        missed=len(found.missed),
    )


def summed(rejections: Collection[Rejection]) -> Rejection:
    """Return the sums of the counts of several plants."""
    rows = [astuple(each) for each in rejections]
    return Rejection(*(sum(column) for column in zip(*rows, strict=True)))


def _within(start: float, stop: float, times: Sequence[float]) -> list[float]:
    return [t for t in times if start <= t <= stop]
