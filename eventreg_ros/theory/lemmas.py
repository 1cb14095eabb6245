# SPDX-License-Identifier: Apache-2.0
"""The paper's two lemmas as code: contraction of a neuron, antiphase of an oscillator.

Functions take the parameters (k, tau) of a neuron or an oscillator. Rates are per
unit of model time. The lemmas measure the distance of two solutions in the norm of
P = diag(1, 1/tau), by (dx_1^2 + dx_2^2 / tau)^(1/2).

On the edge (k = 1 for a neuron, k = 1/2 for an oscillator) they just miss: the largest eigenvalue
is 0, not negative. A direct computation still helps there. Let V = dx_1^2 + dx_2^2 / tau for two
solutions x and z under the same input; on the edge

    V' = -(2/3) dx_1 (x_1^3 - z_1^3) - 2 dx_2^2  <=  -dx_1^4 / 6 - 2 dx_2^2,

so their difference vanishes all the same if they are bounded. But all that this grants is a decay
like 1/sqrt(t); an exponential rate needs k above the edge, as the lemmas say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from ..models.model import Params
from ..models.neuron import neuron_jacobian

Status = Literal['pass', 'marginal', 'none', 'fail']
"""pass: it holds; marginal: on the edge; none: nothing follows; fail: it is known not to hold."""

EDGE = 1e-12
"""A rate this near to 0 is on the edge; absorbs the rounding of a k that was computed."""


@dataclass(frozen=True)
class Contraction:
    """What a lemma says: ``pass``, ``marginal`` or ``none``, and the two numbers behind it.

    ``largest_eigenvalue`` is that of the symmetric part (P Df + Df' P) / 2, the largest over all
    states; the paper's (lem.contr.eq) bounds twice that matrix. ``rate`` is the largest lambda with
    P Df + Df' P <= -2 lambda P at every state; only a positive one certifies anything.
    """

    status: Status
    largest_eigenvalue: float
    rate: float


def symmetric_part(k: float, tau: float, x_1: float) -> tuple[float, float, float]:
    """Return the entries (1,1), (1,2) and (2,2) of (P Df + Df' P) / 2 at the voltage ``x_1``."""
    (a, b, _), (c, d, _) = neuron_jacobian((x_1, 0.0), 0.0, (k, tau))
    return a, (b + c / tau) / 2.0, d / tau


def larger_eigenvalue(a: float, b: float, d: float) -> float:
    """Return the larger eigenvalue of the symmetric matrix with the rows (a, b) and (b, d)."""
    return (a + d) / 2.0 + math.hypot((a - d) / 2.0, b)


def contraction(k: float, tau: float) -> Contraction:
    """Return the contraction of a neuron with conductance ``k`` and time constant ``tau``.

    Only the entry (1,1) of Df depends on the state, by -x_1^2, so x_1 = 0 is the worst state. The
    symmetric part is diag(1 - k, -1) there: its largest eigenvalue is max(1 - k, -1), and the rate,
    which compares it with P = diag(1, 1/tau), is min(k - 1, tau).
    """
    a, b, d = symmetric_part(k, tau, 0.0)
    rate = -larger_eigenvalue(a, b * math.sqrt(tau), d * tau)
    status: Status = 'pass' if rate > EDGE else 'none' if rate < -EDGE else 'marginal'
    return Contraction(status, larger_eigenvalue(a, b, d), rate)


def lemma_1(p: Params) -> Contraction:
    """Return Lemma 1: if k > 1, a neuron contracts under any input, at rate min(k - 1, tau)."""
    return contraction(p[0], p[1])


def lemma_2(p: Params) -> Contraction:
    """Return Lemma 2: if k > 1/2, an oscillator without a drive goes into antiphase.

    Up to the sign of the second, both neurons are neurons of conductance 2 k under one common
    input, so Lemma 1 applies with 2 k: (x_1 + x_3, x_2 + x_4) vanishes in the norm of P at rate
    min(2 k - 1, tau). A drive reaches the first neuron only, and then the lemma does not apply.
    """
    return contraction(2.0 * p[0], p[1])


def antiphase_oscillates(p: Params) -> bool:
    """Say whether an oscillator in antiphase goes on oscillating: exactly if tau < 1.

    Lemma 2 does not say so. In antiphase the coupling cancels and each neuron moves as an uncoupled
    one (k = 0): bounded, with 0 as its only equilibrium, which repels for tau < 1 (so there is a
    closed orbit, Poincare-Bendixson), while for tau >= 1 the divergence 1 - tau - x_1^2 leaves room
    for none (Bendixson).
    """
    return p[1] < 1.0


def rests(p: Params) -> bool:
    """Say whether every solution of one neuron without a drive goes to 0: exactly if k >= 1 - tau.

    For k > 1 that is the paper's argument by Lemma 1. It reaches further: solutions are bounded, 0
    is the only equilibrium, and for k >= 1 - tau the divergence 1 - k - tau - x_1^2 leaves room for
    no closed orbit. Below that 0 repels, and the neuron oscillates by itself.
    """
    return p[0] >= 1.0 - p[1]
