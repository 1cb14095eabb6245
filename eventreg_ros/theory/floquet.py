# SPDX-License-Identifier: Apache-2.0
"""The exact rate of contraction along a periodic w: Floquet multipliers of the driven loop.

The generator is put on its closed orbit, and the loop left to itself until it answers with the same
period T. Perturb plant and controller alone (what drives them goes its way): an infinitesimal
perturbation obeys dx' = J(t) dx with J of period T, so dx(T) = M dx(0). The eigenvalues of the
monodromy M are the multipliers; ln |mu| / T of the largest is the exponent that :mod:`.lyapunov`
estimates by averaging, here to the accuracy of the integration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import EventregError
from ..simulation.continuous import Budget
from ..simulation.loop import Loop
from ..simulation.trajectory import Array
from .lyapunov import PERTURBED, need_jacobians
from .tangent import Tangent

TRANSIENT = 400.0
"""Model time after which the loop is close to the periodic solution, and w on it."""

NEWTON = 8
"""Newton steps that put the loop on it; one is enough where the transient has ended."""

RTOL, ATOL = 1e-11, 1e-13
FIRST, EACH = 20_000, 300
"""Evaluations after which an integration is given up; see :class:`.continuous.Budget`."""

CLOSED = 1e-8
"""Difference of the states one period apart, relative to their size, that counts as none."""

NEAR = 0.3
"""Difference from which on the loop is not taken to be on its way to a periodic solution."""

SKIP = 1e-2
"""Model time past a crossing from which on the next one is looked for."""


class AperiodicError(EventregError):
    """There is no periodic solution to measure along."""


@dataclass(frozen=True)
class Floquet:
    """The multipliers along a periodic solution, largest first; ``period`` is in model time."""

    period: float
    multipliers: tuple[complex, ...]

    @property
    def rate(self) -> float:
        """The largest exponent per unit of model time: negative where the loop contracts."""
        return math.log(abs(self.multipliers[0])) / self.period


def floquet(loop: Loop, *, perturbed: Sequence[str] = PERTURBED) -> Floquet:
    """Return the multipliers of the blocks whose role is ``perturbed``, driven by one generator.

    The loop must have one exosystem, which nobody drives, and no stimulus. Raises
    :class:`AperiodicError` when it has not, when w is not periodic, or when the loop does not
    answer with the period of w; NoJacobianError when a model does not say its derivative,
    StiffError when it takes too many evaluations.
    """
    names = [name for name, spec in loop.blocks.items() if spec.role == 'exosystem']
    driven = any(name in names for name, _ in loop.links)
    if len(names) != 1 or driven or loop.stimuli:
        raise AperiodicError('multipliers need one exosystem without inputs, and no stimulus')
    need_jacobians(loop)
    tangent = Tangent(loop)
    roles = [spec.role for spec in loop.blocks.values() for _ in spec.x0]
    others = [i for i, role in enumerate(roles) if role != 'exosystem']
    x, period = _on_the_orbit(tangent, tangent.slots[loop.blocks[names[0]].output])
    monodromy = _shoot(tangent, x, period, others)
    own = [i for i, state in enumerate(others) if roles[state] in perturbed]
    found = np.linalg.eigvals(monodromy[np.ix_(own, own)]).tolist()
    return Floquet(period, tuple(sorted(map(complex, found), key=abs, reverse=True)))


def _integrate(slope: Any, x: Array, end: float, **more: Any) -> Any:
    from scipy.integrate import solve_ivp

    budget = Budget(FIRST, EACH)

    def counted(t: float, x: Array) -> Any:
        budget.spend(t)
        return slope(t, x)

    with np.errstate(all='ignore'):
        found = solve_ivp(counted, (0.0, end), x, 'DOP853', rtol=RTOL, atol=ATOL, **more)
    if not (found.success and np.isfinite(found.y).all()):
        raise AperiodicError('the solution diverges; choose gentler parameters')
    return found


def _on_the_orbit(tangent: Tangent, slot: int) -> tuple[Array, float]:
    """Return a state where w, on its closed orbit, rises through its middle; and the period."""

    def slope(t: float, x: Array) -> list[float]:
        return tangent.derivative([], x.tolist())

    def w(x: Array) -> float:
        return float(tangent.signals([], x)[slot])

    settled = _integrate(slope, np.array(tangent.x0, float), TRANSIENT)
    late = [w(x) for t, x in zip(settled.t, settled.y.T, strict=True) if t > 0.5 * TRANSIENT]
    middle = 0.5 * (min(late) + max(late))
    if max(late) - min(late) < 1e-6 * max(1.0, abs(middle)):
        raise AperiodicError('w is at rest; give the exosystem parameters with which it moves')

    def rises(t: float, x: Array) -> float:
        return w(x) - middle

    rises.direction = 1.0  # type: ignore[attr-defined]
    rises.terminal = True  # type: ignore[attr-defined]
    x, before = settled.y[:, -1], math.nan
    for _ in range(5):
        x = _integrate(slope, x, SKIP).y[:, -1]
        found = _integrate(slope, x, TRANSIENT, events=rises)
        if found.status != 1:
            break
        x, t = found.y_events[0][-1], SKIP + float(found.t_events[0][-1])
        if abs(t - before) < CLOSED * t:
            return x, t
        before = t
    raise AperiodicError('w is not periodic')


def _shoot(tangent: Tangent, x: Array, period: float, others: Sequence[int]) -> Array:
    """Return the monodromy of the states ``others`` along the periodic solution near ``x``."""
    for _ in range(NEWTON):
        end, monodromy = _over_a_period(tangent, x, period, others)
        gap = (end - x)[others]
        size = float(np.abs(gap).max()) / (1.0 + float(np.abs(x).max()))
        if size > NEAR:
            break
        if size < CLOSED:
            return monodromy
        x = x.copy()
        x[others] += np.linalg.lstsq(np.eye(len(others)) - monodromy, gap)[0]
    raise AperiodicError('the loop does not respond with the period of w')


def _over_a_period(
    tangent: Tangent, x: Array, period: float, columns: Sequence[int]
) -> tuple[Array, Array]:
    """Return the state a period later, and the map of perturbations of the states ``columns``."""
    n = len(x)

    def slope(t: float, z: Array) -> list[float]:
        values = z.tolist()
        state, found = values[:n], []
        for first in range(n, len(values), n):
            both = tangent.flow([], state, values[first : first + n])
            found += both[n:]
        return both[:n] + found

    end = _integrate(slope, np.concatenate([x, np.eye(n)[columns].ravel()]), period).y[:, -1]
    return end[:n], end[n:].reshape(len(columns), n)[:, columns].T
