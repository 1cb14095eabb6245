# SPDX-License-Identifier: Apache-2.0
"""What samples say of a wave: its period, and its peak between them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from ..simulation.trajectory import Array

AROUND = np.arange(-2, 3)
"""The samples about the highest one through which the peak is laid."""


class OrbitError(EventregError):
    """There is no orbit of the kind that is looked for."""


def last_rise(w: Array) -> tuple[int, float]:
    """Return the number of the last sample before w rises through its middle, and its period.

    The period is in steps. Raises OrbitError where w does not repeat itself.
    """
    low, high = float(w.min()), float(w.max())
    middle = 0.5 * (low + high)
    if not high - low > 1e-6 * max(1.0, abs(middle)):
        raise OrbitError('w is at rest')
    before = np.flatnonzero((w[:-1] < middle) & (w[1:] >= middle))
    times = before + (middle - w[before]) / (w[before + 1] - w[before])
    for rises in range(1, (len(times) - 1) // 2 + 1):
        last, one_earlier = times[-1] - times[-1 - rises], times[-1 - rises] - times[-1 - 2 * rises]
        if abs(last - one_earlier) < 1e-3 * last:
            return int(before[-1]), float(last)
    raise OrbitError('w is not periodic')


def peak_of(y: Array) -> tuple[float, npt.NDArray[np.intp], Array]:
    """Return the peak of one period of y, and the places and weights of the samples that make it.

    It is that of the polynomial through five samples.
    """
    if not np.isfinite(y).all():
        raise OrbitError('the loop diverges')
    place = (int(np.argmax(y)) + AROUND) % len(y)
    monomials = np.linalg.inv(np.vander(AROUND.astype(float), increasing=True))
    c = monomials @ y[place]
    turns = np.polynomial.polynomial.polyroots([i * c[i] for i in range(1, 5)])
    real = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) <= 1.0)]
    at = max([0.0, *real.tolist()], key=lambda t: float(np.polynomial.polynomial.polyval(t, c)))
    weights = at ** np.arange(5) @ monomials
    return float(weights @ y[place]), place, weights
