"""How an input is reconstructed between its samples.

Over one step an input is a straight line ``base + theta * slope``, theta running from 0 to 1. With
the ``zero`` hold the slope is 0; with ``linear`` the line goes on through the last two samples.
"""

from __future__ import annotations

from collections.abc import Sequence

HOLDS = ('zero', 'linear')

HORIZON = 4.0
"""Steps over which a line is drawn onwards; an older sample, or one after a wider gap, is held."""


def line(
    newest: float, previous: float, age: float, gap: float, linear: bool
) -> tuple[float, float]:
    """Return (base, slope) of an input over the coming step, slope per step.

    ``newest`` is the last sample received, ``age`` steps before the step begins; ``previous`` came
    ``gap`` > 0 steps before it. With nothing before it, pass ``newest`` twice. A sample that is
    newer than the step's beginning has a negative age.
    """
    if not linear or age > HORIZON or gap > HORIZON:
        return newest, 0.0
    slope = (newest - previous) / gap
    return newest + age * slope, slope


def drive(
    sign: Sequence[float], base: Sequence[float], slope: Sequence[float], theta: float
) -> float:
    """Return the signed sum of the inputs at ``theta`` of the step (the sum in eq. fhn)."""
    total = 0.0
    for i in range(len(sign)):
        total += sign[i] * (base[i] + theta * slope[i])
    return total
