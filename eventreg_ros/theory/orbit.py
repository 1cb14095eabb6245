# SPDX-License-Identifier: Apache-2.0
"""The periodic orbit with which the sampled loop answers a periodic w, and the peak of an output.

No whole number of steps h fits into the period T of w, so the sampled loop itself repeats nothing.
It is taken at the step T / N nearest to h instead: there its map over N steps has a fixed point,

    P(z; h) = z,    w(0) = middle of its swing,    unknown: z and h,

found by Newton's method, with w on its limit cycle and everything else on its answer. z holds all
states and the samples that the hold still needs. What the step changes, h^2 for the linear hold and
h for the zero one, is thereby kept, to a part h / T of it. P is the simulation's own step
(:mod:`..simulation.lane_flow`); its derivative is taken by central differences side by side, 1e-9
of its size off, which slows Newton's method down by nothing and shifts no solution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..simulation.lane_flow import LaneFlow
from ..simulation.loop import Loop
from ..simulation.trajectory import Array
from .waves import OrbitError, last_rise, peak_of

NEWTON = 8
"""Newton steps at most from where a simulation ends."""

CLOSED = 1e-9
"""What one period may change of an orbit, relative to its size."""

SHIFT = 1e-6
"""By how much states are shifted for the derivative, relative to their size, and h to itself."""

SHIFT_OF_POINT = 1e-4
"""By how much the point is shifted."""

NEUTRAL = 1e-4
"""A multiplier less than this below 1 is not taken to attract."""

ENOUGH = 0.6
"""Steps by which a period may differ from the whole number that is taken for it."""

ParamsAt = Callable[[Array], Sequence[Array]]
"""Takes points, shape (n, m); returns the parameters of each block, shape (n, count)."""


NONE = 'no orbit with the period of w is found'


class _Around(NamedTuple):
    """The map about a state: where it goes, its derivatives, and the same of the peak."""

    end: Array
    by_z: Array
    by_h: Array
    by_point: Array
    peak: float
    low: float
    peak_by_z: Array
    peak_by_h: float
    peak_by_point: Array


@dataclass(frozen=True)
class Orbit:
    """A periodic orbit at a ``point``, shape (m,): a state ``z`` on it, ``steps`` of ``h`` long.

    ``exact`` says whether it is closed, to rounding, or a step of Newton's method on its way there.
    ``peak`` and ``low`` are the largest and the smallest value of the output, ``slope`` the
    gradient of the peak by the point, shape (m,). ``multipliers`` are Floquet's, largest first,
    those of w without the one along its cycle.
    """

    point: Array
    z: Array
    h: float
    steps: int
    exact: bool
    peak: float
    low: float
    slope: Array
    multipliers: tuple[complex, ...]
    by_point: Array
    """How z and, last, h change with the point, shape (size + 1, m)."""

    @property
    def period(self) -> float:
        """Model time after which it repeats itself."""
        return self.h * self.steps

    @property
    def attracts(self) -> bool:
        """Whether all that starts near it ends on it."""
        return abs(self.multipliers[0]) < 1.0 - NEUTRAL


class Orbits:
    """The orbits of a sampled loop with one ``exosystem`` (a block's name), no stimulus, no delay.

    ``output`` is the signal whose peak is asked for. ``params`` gives the parameters of all blocks
    at a point; nothing else changes with it.
    """

    def __init__(self, loop: Loop, exosystem: str, output: str, params: ParamsAt) -> None:
        time_scale, rate = loop.grid
        self._h, self._params = time_scale / rate, params
        w = loop.blocks[exosystem].output
        self._flow = LaneFlow(loop, [w, output])
        self._w = self._flow.sample_of(w)
        self._of_w = self._flow.places_of(exosystem)
        self._others = [i for i in range(self._flow.size) if i not in set(self._of_w)]

    def settled(self, point: Array, time: float) -> Orbit:
        """Return the orbit at ``point`` that the loop has reached after ``time`` (model time).

        Raises OrbitError.
        """
        params, start = self._params(point[None]), self._flow.start[None]
        steps = round(time / self._h)
        w = self._flow.take(start, params, self._h, steps).samples[0, 0]
        first, period = last_rise(w[steps // 2 :])
        near = self._flow.take(start, params, self._h, steps // 2 + first).ends[0]
        found = self._step(point, near, self._h, period * self._h)
        for _ in range(NEWTON):
            if found.exact:
                return found
            found = self.at(point, found)
        raise OrbitError(NONE)

    def at(self, point: Array, near: Orbit) -> Orbit:
        """Return the orbit at ``point`` next to ``near`` after one step of Newton's method.

        Raises OrbitError.
        """
        change = near.by_point @ (point - near.point)
        h = near.h + float(change[-1])
        return self._step(point, near.z + change[:-1], h, near.steps * h)

    def _step(self, point: Array, z: Array, h: float, period: float) -> Orbit:
        if not 4.0 * self._h < period < np.inf:
            raise OrbitError('w has no period of more than a few steps')
        steps = round(period / self._h)
        h = period / steps
        with np.errstate(all='ignore'):
            found = self._around(point, z, h, steps)
        n = len(z)
        system, gap = np.zeros((n + 1, n + 1)), np.zeros((n + 1, 1 + len(point)))
        system[:n] = np.column_stack([found.by_z - np.eye(n), found.by_h])
        system[n, self._w] = 1.0
        gap[:n] = np.column_stack([found.end - z, found.by_point])
        size = float(np.abs(gap[:, 0]).max()) / (1.0 + float(np.abs(z).max()))
        if not (np.isfinite(system).all() and np.isfinite(gap).all() and size < 1.0):
            raise OrbitError(NONE)
        try:
            moved: Array = np.linalg.solve(system, -gap).astype(np.float64)
        except np.linalg.LinAlgError:
            raise OrbitError(NONE) from None
        exact = bool(size < CLOSED and abs(period / self._h - steps) < ENOUGH)
        return self._orbit(point, z, h, steps, found, moved, exact)

    def _orbit(
        self,
        point: Array,
        z: Array,
        h: float,
        steps: int,
        found: _Around,
        moved: Array,
        exact: bool,
    ) -> Orbit:
        by_point = moved[:, 1:]
        slope = found.peak_by_point + found.peak_by_z @ by_point[:-1]
        slope = slope + found.peak_by_h * by_point[-1]
        of_w = np.linalg.eigvals(found.by_z[np.ix_(self._of_w, self._of_w)])
        of_w = np.delete(of_w, np.argmin(np.abs(of_w - 1.0)))
        if exact and not np.abs(of_w).max(initial=0.0) < 1.0 - NEUTRAL:
            raise OrbitError('w runs on no limit cycle: its size depends on where it starts')
        others = np.linalg.eigvals(found.by_z[np.ix_(self._others, self._others)])
        every = sorted(map(complex, np.concatenate([of_w, others])), key=abs, reverse=True)
        dz, dh = moved[:-1, 0], float(moved[-1, 0])
        peak = found.peak + float(found.peak_by_z @ dz) + found.peak_by_h * dh
        return Orbit(
            point, z + dz, h + dh, steps, exact, peak, found.low, slope, tuple(every), by_point
        )  # fmt: skip

    def _around(self, point: Array, z: Array, h: float, steps: int) -> _Around:
        """Return the map about ``z``: all shifted states, then all shifted points."""
        size, m = len(z), len(point)
        shifts = SHIFT * np.maximum(1.0, np.abs(z))
        by_state = np.vstack([np.diag(shifts), -np.diag(shifts)])
        states = np.vstack([z, z + by_state, np.tile(z, (2 * m, 1))])
        both = SHIFT_OF_POINT * np.vstack([np.eye(m), -np.eye(m)])
        table = self._params(np.vstack([point, point + both]))
        lanes = [0] * (1 + 2 * size) + list(range(1, 1 + 2 * m))
        params = [each[lanes] for each in table]
        ends, samples = self._flow.take(states, params, h, steps)
        y = samples[:, 1, :steps]
        peak, place, weights = peak_of(y[0])
        base = [each[:1] for each in table]
        by_h = [self._flow.take(z[None], base, h + s, steps) for s in (SHIFT * h, -SHIFT * h)]
        peaks = y[:, place] @ weights
        peaks_by_h = [float(each.samples[0, 1, place] @ weights) for each in by_h]
        width, width_h = 2.0 * shifts, 2.0 * SHIFT * h
        cut = 1 + 2 * size
        return _Around(
            ends[0],
            ((ends[1 : 1 + size] - ends[1 + size : cut]) / width[:, None]).T,
            (by_h[0].ends[0] - by_h[1].ends[0]) / width_h,
            ((ends[cut : cut + m] - ends[cut + m :]) / (2.0 * SHIFT_OF_POINT)).T,
            peak,
            float(y[0].min()),
            (peaks[1 : 1 + size] - peaks[1 + size : cut]) / width,
            (peaks_by_h[0] - peaks_by_h[1]) / width_h,
            (peaks[cut : cut + m] - peaks[cut + m :]) / (2.0 * SHIFT_OF_POINT),
        )
