# SPDX-License-Identifier: Apache-2.0
"""The Hodgkin-Huxley neuron, and the oscillator made of two.

    C V' = I - g_Na m^3 h (V - V_Na) - g_K n^4 (V - V_K) - g_L (V - V_L) + k (sum of inputs - z)

with the gates and constants of the squid's axon at 6.3 degrees (Hodgkin and Huxley, J. Physiol.
117, 1952; here with the rest at -65 mV). Units, and z as the voltage about the plant's rest, are
those of :mod:`.morris_lecar`; the states of a neuron are (z, m, h, n). A ``drive_gain`` of 3 to 10
makes the controller work from all initial states; with 1 it does so in pockets of k only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .model import Model, ModelParameter, Params, State, first_state
from .morris_lecar import COUPLING
from .rest import lowest_root


class Axon(NamedTuple):
    """What a block with these neurons is stepped with; ``v_0`` is the plant's rest, in mV."""

    k: float
    drive_gain: float
    current: float
    v_0: float


G_NA, G_K, G_L = 120.0, 36.0, 0.3
V_NA, V_K, V_L = 50.0, -77.0, -54.387
CAPACITANCE = 1.0
"""Conductances in mS/cm2, reversal potentials in mV, the capacitance in uF/cm2."""


def rest(current: float) -> float:
    """Return the lowest voltage (mV) at which a neuron with ``current`` is in equilibrium."""
    far = abs(current) / G_L + 1.0

    def balance(v: float) -> float:
        m, h, n = (opening / (opening + closing) for opening, closing in gates(v))
        return axon(v, m, h, n, current)[0]

    return lowest_root(balance, V_K - far, V_NA + far)


def _pack_neuron(k: float, drive_gain: float, current: float) -> Axon:
    return Axon(k, drive_gain, current, rest(current))


def _pack_oscillator(k: float, drive_gain: float, current: float, i_rest: float) -> Axon:
    return Axon(k, drive_gain, current, rest(i_rest))


def _bounded(a: float) -> float:
    """Return ``a`` such that e^a does not overflow: a state that explodes is found elsewhere."""
    return 300.0 if a > 300.0 else -300.0 if a < -300.0 else a


def _exp(a: float) -> float:
    return math.exp(_bounded(a))


def _linoid(v: float, width: float) -> float:
    """Return v / (1 - e^(-v/width)), which at v = 0 is ``width``."""
    return width if v == 0.0 else -v / math.expm1(_bounded(-v / width))


def gates(v: float) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Return the rates (1/ms) at which the gates m, h and n open and close at ``v``."""
    return (
        (0.1 * _linoid(v + 40.0, 10.0), 4.0 * _exp(-(v + 65.0) / 18.0)),
        (0.07 * _exp(-(v + 65.0) / 20.0), 1.0 / (1.0 + _exp(-(v + 35.0) / 10.0))),
        (0.01 * _linoid(v + 55.0, 10.0), 0.125 * _exp(-(v + 65.0) / 80.0)),
    )


def axon(
    v: float, m: float, h: float, n: float, applied: float
) -> tuple[float, float, float, float]:
    """Return the ionic and applied current at ``v``, and the derivatives of the gates."""
    (a_m, b_m), (a_h, b_h), (a_n, b_n) = gates(v)
    sodium = G_NA * m * m * m * h * (v - V_NA)
    potassium = G_K * n * n * n * n * (v - V_K)
    return (
        applied - sodium - potassium - G_L * (v - V_L),
        a_m * (1.0 - m) - b_m * m,
        a_h * (1.0 - h) - b_h * h,
        a_n * (1.0 - n) - b_n * n,
    )


def hodgkin_huxley_rhs(x: State, drive: float, p: Params) -> State:
    """One neuron whose inputs enter inside a single gap junction; ``x`` is (z, m, h, n)."""
    current, dm, dh, dn = axon(x[0] + p[3], x[1], x[2], x[3], p[2])
    return ((current + p[0] * (p[1] * drive - x[0])) / CAPACITANCE, dm, dh, dn)


def hodgkin_huxley_oscillator_rhs(x: State, drive: float, p: Params) -> State:
    """Two neurons that inhibit each other, wired as the paper's; ``x`` is (z1, ..., z2, ...)."""
    first, dm1, dh1, dn1 = axon(x[0] + p[3], x[1], x[2], x[3], p[2])
    second, dm2, dh2, dn2 = axon(x[4] + p[3], x[5], x[6], x[7], p[2])
    return (
        (first + p[0] * (p[1] * drive - x[4] - x[0])) / CAPACITANCE,
        dm1,
        dh1,
        dn1,
        (second + p[0] * (-x[0] - x[4])) / CAPACITANCE,
        dm2,
        dh2,
        dn2,
    )


def _current(name: str, doc: str, default: float) -> ModelParameter:
    return ModelParameter(name, doc, default, 'uA/cm2')


HODGKIN_HUXLEY = Model(
    'hodgkin_huxley',
    4,
    hodgkin_huxley_rhs,
    first_state,
    (*COUPLING, _current('current', 'applied current', 0.0)),
    _pack_neuron,
    x0=(0.0, 0.053, 0.6, 0.32),
)
HODGKIN_HUXLEY_OSCILLATOR = Model(
    'hodgkin_huxley_oscillator',
    8,
    hodgkin_huxley_oscillator_rhs,
    first_state,
    (
        *COUPLING,
        _current('current', 'applied current of both neurons', 20.0),
        _current('i_rest', "the plant's current, whose rest is 0 of all signals", 0.0),
    ),
    _pack_oscillator,
    x0=(15.0, 0.05, 0.6, 0.32, -5.0, 0.05, 0.6, 0.32),
)
