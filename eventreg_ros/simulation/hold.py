# SPDX-License-Identifier: Apache-2.0
"""How an input is reconstructed between its samples.

Over one step an input is a straight line ``base + theta * slope``, theta running from 0 to 1. With
the ``zero`` hold the slope is 0; with ``linear`` the line goes on through the last two samples.
"""

from __future__ import annotations

from collections.abc import Sequence

HOLDS = ('zero', 'linear')

HORIZON = 0.4
"""Model time over which a line is drawn onwards; beyond it, or after a wider gap, it is held.

Delays are physical, so this is a time and not a number of steps. docs/delays.md says what it buys
and why it is not longer.
"""

REACH = 1.0
"""How far the line of a late sample may lead from it, in the signal's unit (spikes are 4 high).

What leads further is no slope but a jump, a controller's last u = 0, say, and is held.
"""


SHORTEST = 1e-300
"""Model time below which the length of a step is no divisor."""


def horizon_in_steps(hold: str, h: float) -> float:
    """Return how many steps of length ``h`` (model time) a line is drawn onwards; ``zero``: none.

    At least the step itself is bridged, however long it is.
    """
    return max(HORIZON / max(h, SHORTEST), 1.0) + 1e-9 if hold == 'linear' else 0.0


def line(
    newest: float, previous: float, age: float, gap: float, horizon: float
) -> tuple[float, float]:
    """Return (base, slope) of an input over the coming step, slope per step.

    ``newest`` is the last sample received, ``age`` steps before the step begins; ``previous`` came
    ``gap`` > 0 steps before it. With nothing before it, pass ``newest`` twice. A sample that is
    newer than the step's beginning has a negative age. Beyond ``horizon`` steps it is held, and so
    is a late one whose line would lead further than :data:`REACH`.
    """
    if age > horizon or gap > horizon:
        return newest, 0.0
    slope = (newest - previous) / gap
    if age == 0.0:
        return newest, slope
    if age > 0.0 and abs(age * slope) > REACH:
        return newest, 0.0
    return newest + age * slope, slope


def drives(
    sign: Sequence[float], base: Sequence[float], slope: Sequence[float]
) -> tuple[float, float, float]:
    """Return :func:`drive` at the start, the middle and the end of the step.

    Without the products by 0 and 1, which no compiler may leave out.
    """
    start = middle = end = 0.0
    for i in range(len(sign)):
        start += sign[i] * base[i]
        middle += sign[i] * (base[i] + 0.5 * slope[i])
        end += sign[i] * (base[i] + slope[i])
    return start, middle, end


def drive(
    sign: Sequence[float], base: Sequence[float], slope: Sequence[float], theta: float
) -> float:
    """Return the signed sum of the inputs at ``theta`` of the step (the sum in eq. fhn)."""
    total = 0.0
    for i in range(len(sign)):
        total += sign[i] * (base[i] + theta * slope[i])
    return total
