# SPDX-License-Identifier: Apache-2.0
"""Least squares for identification: from a coarse start to the last digit, and how sure it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .layout import Array, Layout
from .model import Forward
from .recorded import Recorded

ROUGH, FINE = 0.2, 0.05
"""Steps of the integration at first and at the end (model time)."""

GUESSES = 2.0
"""What was given between its samples may be so much further from two interpolations than they are
from each other."""

LATE = 0.05
"""Model time by which what was given may act later than it is stamped, or a sample if that is
less."""

EVALUATIONS = 25
MISFIT = 0.2
"""Root mean square of what remains, noise apart, from which on it is not a generator's signal."""

CLEARLY = 3.0
"""Standard deviations that correlation must show by."""

CLUSTER = 5.0
"""Model time over which residuals may be correlated."""


@dataclass(frozen=True)
class Fit:
    """Where a fit ended.

    ``unknowns`` has shape (size,), ``residual`` (n,) at the times ``t``, ``jacobian`` (n, size).
    ``shift``, of shape (size,), is how far other steps of the integration, or another interpolation
    of what is given, or a later one, would have moved it.
    """

    layout: Layout
    t: Array
    unknowns: Array
    residual: Array
    jacobian: Array
    shift: Array

    @property
    def squares(self) -> float:
        """The sum of the squares of the residuals."""
        return float(self.residual @ self.residual)

    @property
    def rms(self) -> float:
        """The root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def misfit(self) -> float:
        """The part of :attr:`rms` that neighbouring samples share: white noise has none."""
        r = self.residual
        return float(np.sqrt(max(float(np.mean(r[1:] * r[:-1])), 0.0)))

    @property
    def free(self) -> int:
        """Degrees of freedom."""
        return max(len(self.t) - self.layout.size, 1)

    @property
    def repetition(self) -> float:
        """How many residuals say what one would, since they are correlated; 1 for white noise."""
        sums = np.bincount(self._cells, self.residual)
        return max(float(sums @ sums) / self.squares, 1.0) if self.squares > 0.0 else 1.0

    @property
    def _cells(self) -> npt.NDArray[np.intp]:
        """Which of the stretches of :data:`CLUSTER` each sample is in, counted from 0."""
        return np.unique(np.floor(self.t / CLUSTER), return_inverse=True)[1]

    def deviations(self) -> Array:
        """Return the standard deviation of each of the unknowns, shape (size,); inf if free.

        The largest of three estimates: for white noise; for noise that is stronger at some samples
        than at others, as jitter of the stamps makes it; and, where the residuals are clearly
        correlated, for noise that is so over :data:`CLUSTER` of model time. To that adds
        :attr:`shift`.
        """
        scale = np.linalg.norm(self.jacobian, axis=0)
        scale[scale == 0.0] = 1.0
        j = self.jacobian / scale
        _, s, v = np.linalg.svd(j, full_matrices=False)
        sure = s > 1e-10 * s[0]
        inverse = (v[sure].T / s[sure] ** 2) @ v[sure]
        white = self.squares / self.free * inverse
        each = j * self.residual[:, None]
        found = [np.diag(white)]
        for rows in (each, *self._clusters(each)):
            found.append(np.sum((rows @ inverse) ** 2, axis=0) * len(self.t) / self.free)
        deviation: Array = np.hypot(np.sqrt(np.max(found, axis=0)) / scale, self.shift)
        lost = (v[~sure] ** 2).sum(axis=0) > 1e-6
        deviation[lost] = np.inf
        return deviation

    def _clusters(self, each: Array) -> list[Array]:
        """Return the sums of ``each`` over cells of CLUSTER, nothing if they seem uncorrelated."""
        cells = self._cells
        count = int(cells.max()) + 1
        if self.repetition < 1.0 + CLEARLY * np.sqrt(2.0 / count):
            return []
        sums = np.zeros((count, each.shape[1]))
        np.add.at(sums, cells, each)
        return [sums]


def solve(recorded: Recorded, layout: Layout, start: Array, windows: Sequence[float]) -> Fit:
    """Return the fit from ``start``, over growing ``windows`` (model time) and then over all."""
    unknowns = start
    for end in (*windows, np.inf):
        part = recorded.beginning(end, 4 * layout.size)
        forward = part.forward(layout, ROUGH)
        unknowns = descend(forward, part.x, unknowns)
    return _polished(recorded, forward, unknowns)


def descend(forward: Forward, x: Array, start: Array, evaluations: int = EVALUATIONS) -> Array:
    """Return where least squares lead from ``start`` with so many evaluations at most."""
    from scipy.optimize import least_squares

    low, high = forward.layout.bounds
    found = least_squares(
        lambda unknowns: np.nan_to_num(forward.predict(unknowns) - x, nan=1e3),
        np.clip(start, low + 1e-9, high - 1e-9),
        lambda unknowns: np.nan_to_num(forward.jacobian(unknowns)),
        bounds=(low, high), x_scale='jac', ftol=1e-6, xtol=1e-9, gtol=1e-12, max_nfev=evaluations,
    )  # fmt: skip
    return np.asarray(found.x)


def _polished(recorded: Recorded, rough: Forward, unknowns: Array) -> Fit:
    """Take the last steps with the fine integration; the derivative may be the rough one."""
    jacobian = rough.jacobian(unknowns)
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = np.inf

    def newton(residual: Array) -> Array:
        step: Array = np.linalg.lstsq(jacobian / scale, -residual, 1e-10)[0] / scale
        return step

    forward = recorded.forward(rough.layout, FINE)
    residual = forward.predict(unknowns) - recorded.x
    for _ in range(5):
        moved = np.clip(unknowns + newton(residual), *rough.layout.bounds)
        remaining = forward.predict(moved) - recorded.x
        if not remaining @ remaining < residual @ residual:
            break
        done = abs(moved[0] - unknowns[0]) < 1e-10
        unknowns, residual = moved, remaining
        if done:
            break
    every = float(np.clip(np.median(np.diff(recorded.t)), FINE, ROUGH))
    others = [recorded.forward(rough.layout, h) for h in {0.5 * FINE, every}]
    if recorded.given is not None:
        others.append(recorded.forward(rough.layout, FINE, late=min(every, LATE)))
        others.append(recorded.forward(rough.layout, FINE, straight=True))
    shifts = [newton(other.predict(unknowns) - recorded.x - residual) for other in others]
    if recorded.given is not None:
        shifts[-1] *= GUESSES
    shift = np.max(np.abs(shifts), axis=0)
    return Fit(rough.layout, recorded.t, unknowns, residual, jacobian, shift)
