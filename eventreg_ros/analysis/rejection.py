"""Which events of y are asked for, which are not, and which are missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .criteria import SETTLE, WINDOW

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


def outcomes(
    y: Sequence[float], y_r: Sequence[float], settle: float = SETTLE, window: float = WINDOW
) -> dict[str, list[float]]:
    """Say what became of each event of y and y_r (times in model time) at or after ``settle``.

    Returns the times by outcome: ``preserved`` and ``spurious`` are events of y, ``missed`` of y_r.
    Without a reference pass no events of y_r: then every event of y is spurious.
    """
    y, y_r = _after(settle, y), _after(settle, y_r)
    pairs = match(y, y_r, window)
    matched, answered = {i for i, _ in pairs}, {j for _, j in pairs}
    return {
        'preserved': [y[i] for i, _ in pairs],
        'spurious': [t for i, t in enumerate(y) if i not in matched],
        'missed': [t for j, t in enumerate(y_r) if j not in answered],
    }


def reject(
    w: Sequence[float],
    y: Sequence[float],
    y_r: Sequence[float],
    settle: float = SETTLE,
    window: float = WINDOW,
) -> Rejection:
    """Count, from the event times of w, y and y_r in model time, those at or after ``settle``."""
    counts = {name: len(times) for name, times in outcomes(y, y_r, settle, window).items()}
    return Rejection(
        disturbance_events=len(_after(settle, w)),
        reference_events=len(_after(settle, y_r)),
        **counts,
    )


def _after(settle: float, times: Sequence[float]) -> list[float]:
    return [t for t in times if t >= settle]
