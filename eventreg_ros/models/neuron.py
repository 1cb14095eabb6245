# SPDX-License-Identifier: Apache-2.0
"""The FitzHugh-Nagumo neuron and the oscillator made of two of them (the paper's section 3)."""

from __future__ import annotations

from typing import NamedTuple

from .model import Learner, Model, ModelParameter, Params, State, first_state

FOLD = 1.0
"""The fold of the cubic nullcline x - x^3/3: beyond it a neuron is on its way into a spike."""


class NeuronParams(NamedTuple):
    """Conductance and time constant of a neuron, or of both neurons of an oscillator."""

    k: float
    tau: float


PARAMETERS = (
    ModelParameter('k', 'synaptic conductance; 0: uncoupled', low=0.0),
    ModelParameter('tau', 'time constant of the recovery', low=0.0, open_low=True),
)


def neuron_rhs(x: State, drive: float, p: Params) -> State:
    """One neuron whose inputs enter inside a single gap junction (eq. fhn of the paper).

    ``x`` is (x1, x2), voltage and recovery; ``drive`` is the signed sum of the presynaptic
    voltages; ``p`` gives k and tau. Returns the derivative by model time.
    """
    v, r = x[0], x[1]
    k, tau = p[0], p[1]
    return (v - v * v * v / 3.0 - r + k * (drive - v), tau * (v - r))


def oscillator_rhs(x: State, drive: float, p: Params) -> State:
    """Two neurons that inhibit each other (eq. s.w; with a drive, eq. s.I, the controller).

    ``x`` is (x1, x2, x3, x4): voltage and recovery of the first neuron, then of the second. The
    drive reaches the first neuron only; both have the same k and tau.
    """
    v1, r1, v2, r2 = x[0], x[1], x[2], x[3]
    k, tau = p[0], p[1]
    return (
        v1 - v1 * v1 * v1 / 3.0 - r1 + k * (drive - v2 - v1),
        tau * (v1 - r1),
        v2 - v2 * v2 * v2 / 3.0 - r2 + k * (-v1 - v2),
        tau * (v2 - r2),
    )


def neuron_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return D f of :func:`neuron_rhs` (in the proof of Lemma 1), last column by the drive."""
    k, tau = p[0], p[1]
    return ((1.0 - k - x[0] * x[0], -1.0, k), (tau, -tau, 0.0))


def oscillator_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return D f of :func:`oscillator_rhs`, last column by the drive."""
    k, tau = p[0], p[1]
    return (
        (1.0 - k - x[0] * x[0], -1.0, -k, 0.0, k),
        (tau, -tau, 0.0, 0.0, 0.0),
        (-k, 0.0, 1.0 - k - x[2] * x[2], -1.0, 0.0),
        (0.0, 0.0, tau, -tau, 0.0),
    )


def oscillator_sensitivity(x: State, drive: float, p: Params) -> State:
    """Return the derivative of :func:`oscillator_rhs` by tau."""
    return (0.0, x[0] - x[1], 0.0, x[2] - x[3])


def tau_rate(x: State, drive: float, p: Params) -> float:
    """Return -k e x2 tau, by which a driven oscillator learns the tau of what drives it.

    The rule of adaptive frequency oscillators (Righetti, Buchli, Ijspeert, Physica D 216, 2006)
    with the regulation error e, the drive, as teacher.
    """
    return -p[0] * drive * x[1] * p[1]


def tau_gradient(x: State, drive: float, p: Params) -> State:
    """Return the derivative of :func:`tau_rate` by the states, by tau, and by the drive."""
    k, tau = p[0], p[1]
    return (0.0, -k * drive * tau, 0.0, 0.0, -k * drive * x[1], -k * x[1] * tau)


NEURON = Model(
    'neuron', 2, neuron_rhs, first_state, PARAMETERS, NeuronParams, jacobian=neuron_jacobian
)
OSCILLATOR = Model(
    'oscillator',
    4,
    oscillator_rhs,
    first_state,
    PARAMETERS,
    NeuronParams,
    jacobian=oscillator_jacobian,
    learns=Learner('tau', tau_rate, 0.02, 1.5, oscillator_sensitivity, tau_gradient),
)
