# SPDX-License-Identifier: Apache-2.0
"""A neuron model of one's own: the Van der Pol oscillator as generator and internal model."""

from __future__ import annotations

from eventreg_ros.models import Model, ModelParameter, Params, State, first_state


def van_der_pol_rhs(x: State, drive: float, p: Params) -> State:
    """x1' = mu (x1 - x1^3/3 - x2) + k drive, x2' = x1 / mu: relaxation oscillations for mu > 1."""
    mu, k = p
    return (mu * (x[0] - x[0] * x[0] * x[0] / 3.0 - x[1]) + k * drive, x[0] / mu)


def van_der_pol_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return the derivative by each state and, last, by the drive."""
    mu, k = p
    return ((mu * (1.0 - x[0] * x[0]), -mu, k), (1.0 / mu, 0.0, 0.0))


VAN_DER_POL = Model(
    'van_der_pol',
    2,
    van_der_pol_rhs,
    first_state,
    (
        ModelParameter('mu', 'stiffness', 3.0, low=0.0, open_low=True),
        ModelParameter('k', 'weight of the drive', 2.0, low=0.0),
    ),
    jacobian=van_der_pol_jacobian,
    x0=(1.0, 0.0),
)
