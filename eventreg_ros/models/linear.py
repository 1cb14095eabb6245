# SPDX-License-Identifier: Apache-2.0
"""The linear motif: what the nonlinear construction is modelled on (the paper's section 2)."""

from __future__ import annotations

from typing import NamedTuple

from .model import Model, ModelParameter, Params, State, first_state


class Gains(NamedTuple):
    """The gains of the linear controller: k_y and the two entries of K_eta (eq. s.linear)."""

    k_y: float
    k_1: float
    k_2: float


GAINS = (
    ModelParameter('k_y', "direct gain from y in the linear controller's output", live=False),
    ModelParameter('gain', "K_eta of the linear controller's output", length=2),
)


def harmonic_rhs(x: State, drive: float, p: Params) -> State:
    """Turn with unit angular frequency: the exosystem of eq. s.linear.w. It has no input."""
    return (x[1], -x[0])


def lag_rhs(x: State, drive: float, p: Params) -> State:
    """Follow the drive with unit time constant: the plant of eq. s.xp, drive = w - u."""
    return (drive - x[0],)


def internal_model_rhs(x: State, drive: float, p: Params) -> State:
    """Turn with unit angular frequency, driven by y through G = (1, 0) (eq. s.linear.xeta)."""
    return (x[1] + drive, -x[0])


def internal_model_output(x: State, drive: float, p: Params) -> float:
    """Return u = k_y y + K_eta x_eta (eq. s.linear, second line)."""
    return p[0] * drive + p[1] * x[0] + p[2] * x[1]


def harmonic_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return S of eq. s.linear.w; the last column, by the drive, is 0."""
    return ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))


def lag_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return the derivative of :func:`lag_rhs` by its state and, last, by the drive."""
    return ((-1.0, 1.0),)


def internal_model_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return (Phi, G) of eq. s.linear.I.choice: by the states and, last, by the drive."""
    return ((0.0, 1.0, 1.0), (-1.0, 0.0, 0.0))


HARMONIC = Model(
    'harmonic', 2, harmonic_rhs, first_state, jacobian=harmonic_jacobian, x0=(1.0, 0.0)
)
LAG = Model('lag', 1, lag_rhs, first_state, jacobian=lag_jacobian, x0=(0.0,))
INTERNAL_MODEL = Model(
    'internal_model',
    2,
    internal_model_rhs,
    internal_model_output,
    GAINS,
    Gains,
    feedthrough=True,
    jacobian=internal_model_jacobian,
    x0=(0.0, 0.0),
)
