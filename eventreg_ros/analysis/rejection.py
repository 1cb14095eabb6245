"""Which events of y are asked for, which are not, and which are missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SETTLE = 100.0
WINDOW = 5.0
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
            return 'undecided'
        return 'not rejected' if self.spurious or self.missed else 'rejected'


def match(a: Sequence[float], b: Sequence[float], window: float) -> list[tuple[float, float]]:
    """Pair events of ``a`` and ``b`` (each in increasing order) one to one, as many as can be.

    Two events may pair when they are at most ``window`` apart. Taking the earliest pair first is
    optimal, since every event's partners form an interval that moves on with the event.
    """
    pairs = []
    i = j = 0
    while i < len(a) and j < len(b):
        if abs(a[i] - b[j]) <= window:
            pairs.append((a[i], b[j]))
            i += 1
            j += 1
        elif a[i] < b[j]:
            i += 1
        else:
            j += 1
    return pairs


def reject(
    w: Sequence[float],
    y: Sequence[float],
    y_r: Sequence[float],
    settle: float = SETTLE,
    window: float = WINDOW,
) -> Rejection:
    """Count, from the event times of w, y and y_r in model time, those at or after ``settle``.

    Without a reference pass no events of y_r: then every event of y is spurious.
    """
    w, y, y_r = ([t for t in times if t >= settle] for times in (w, y, y_r))
    preserved = len(match(y, y_r, window))
    return Rejection(
        disturbance_events=len(w),
        reference_events=len(y_r),
        preserved=preserved,
        spurious=len(y) - preserved,
        missed=len(y_r) - preserved,
    )
