"""The linear motif: what the nonlinear construction is modelled on (the paper's section 2)."""

from __future__ import annotations

from .model import Model, Params, State, first_state


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
    return p[2] * drive + p[3] * x[0] + p[4] * x[1]


def harmonic_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return S of eq. s.linear.w; the last column, by the drive, is 0."""
    return ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))


def lag_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return the derivative of :func:`lag_rhs` by its state and, last, by the drive."""
    return ((-1.0, 1.0),)


def internal_model_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return (Phi, G) of eq. s.linear.I.choice: by the states and, last, by the drive."""
    return ((0.0, 1.0, 1.0), (-1.0, 0.0, 0.0))


HARMONIC = Model('harmonic', 2, harmonic_rhs, first_state, jacobian=harmonic_jacobian)
LAG = Model('lag', 1, lag_rhs, first_state, jacobian=lag_jacobian)
INTERNAL_MODEL = Model(
    'internal_model',
    2,
    internal_model_rhs,
    internal_model_output,
    feedthrough=True,
    jacobian=internal_model_jacobian,
)
