# SPDX-License-Identifier: Apache-2.0
"""The Morris-Lecar neuron, and the oscillator made of two: the paper's idea with other membranes.

    C V' = I - g_Ca m(V) (V - V_Ca) - g_K n (V - V_K) - g_L (V - V_L) + k (sum of inputs - z)
      n' = phi (n_inf(V) - n) cosh((V - V_3) / (2 V_4))

(Morris and Lecar, Biophys. J. 35, 1981; the constants are those of its class 2 excitability.) Time
is in ms, voltages in mV, currents in uA/cm2, conductances in mS/cm2, the capacitance in uF/cm2.
Signals are voltages about the rest V_0 of the plant, z = V - V_0: the states are (z, n). So the
oscillators have to know the plant's current (``i_rest``); the other constants are taken as theirs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .model import Model, ModelParameter, Params, State, first_state
from .rest import lowest_root


class Membrane(NamedTuple):
    """What a block with these neurons is stepped with; ``v_0`` is the plant's rest, in mV."""

    k: float
    drive_gain: float
    current: float
    v_0: float
    phi: float
    v_1: float
    v_2: float
    v_3: float
    v_4: float
    g_ca: float
    g_k: float
    g_l: float
    v_ca: float
    v_k: float
    v_l: float
    capacitance: float


def _constant(
    name: str, doc: str, default: float, unit: str, positive: bool = False
) -> ModelParameter:
    """Return the row of a constant; ``positive`` ones must be > 0."""
    low = 0.0 if positive else None
    return ModelParameter(name, doc, default, unit, low=low, open_low=positive)


COUPLING = (
    ModelParameter('k', 'conductance of the gap junction', unit='mS/cm2; 0: uncoupled', low=0.0),
    ModelParameter('drive_gain', 'factor of the drive within it', 1.0),
)
CONSTANTS = (
    _constant('phi', 'rate of the potassium gate', 0.04, '1/ms', True),
    _constant('v_1', 'where half the calcium channels are open', -1.2, 'mV'),
    _constant('v_2', 'over how many volts they open', 18.0, 'mV', True),
    _constant('v_3', 'where half the potassium channels are open', 2.0, 'mV'),
    _constant('v_4', 'over how many volts they open', 30.0, 'mV', True),
    _constant('g_ca', 'conductance of the calcium channels', 4.4, 'mS/cm2', True),
    _constant('g_k', 'conductance of the potassium channels', 8.0, 'mS/cm2', True),
    _constant('g_l', 'conductance of the leak', 2.0, 'mS/cm2', True),
    _constant('v_ca', 'reversal potential of calcium', 120.0, 'mV'),
    _constant('v_k', 'reversal potential of potassium', -84.0, 'mV'),
    _constant('v_l', 'reversal potential of the leak', -60.0, 'mV'),
    _constant('capacitance', 'capacitance of the membrane', 20.0, 'uF/cm2', True),
)
PLANT_CURRENT, OSCILLATOR_CURRENT = 60.0, 100.0
"""Applied currents with which one neuron is at rest, and two keep firing in turn."""


def rest(current: float, constants: tuple[float, ...]) -> float:
    """Return the lowest voltage (mV) at which a neuron with ``current`` is in equilibrium.

    ``constants`` are the values of :data:`CONSTANTS`.
    """
    p = Membrane(0.0, 1.0, current, 0.0, *constants)
    reversal = (p.v_k, p.v_l, p.v_ca)
    far = abs(current) / p.g_l + 1.0
    return lowest_root(lambda v: _balance(v, p), min(reversal) - far, max(reversal) + far)


def _balance(v: float, p: Membrane) -> float:
    """Return the current into a membrane at ``v`` whose gates have settled."""
    return membrane(v, opened(v, p[7], p[8]), p)[0]


def _pack_neuron(k: float, drive_gain: float, current: float, *constants: float) -> Membrane:
    return Membrane(k, drive_gain, current, rest(current, constants), *constants)


def _pack_oscillator(
    k: float, drive_gain: float, current: float, i_rest: float, *constants: float
) -> Membrane:
    return Membrane(k, drive_gain, current, rest(i_rest, constants), *constants)


def opened(v: float, half: float, width: float) -> float:
    """Return the share of channels that are open at ``v`` in equilibrium, 0 to 1."""
    return 0.5 * (1.0 + math.tanh((v - half) / width))


def membrane(v: float, n: float, p: Params) -> tuple[float, float]:
    """Return the ionic and applied current at ``v``, and the derivative of the gate ``n``."""
    phi, v_1, v_2, v_3, v_4 = p[4], p[5], p[6], p[7], p[8]
    g_ca, g_k, g_l, v_ca, v_k, v_l = p[9], p[10], p[11], p[12], p[13], p[14]
    calcium = g_ca * opened(v, v_1, v_2) * (v - v_ca)
    potassium = g_k * n * (v - v_k)
    speed = phi * math.cosh(_bounded((v - v_3) / (2.0 * v_4)))
    return p[2] - calcium - potassium - g_l * (v - v_l), speed * (opened(v, v_3, v_4) - n)


def _bounded(a: float) -> float:
    """Return ``a`` within what cosh can take: a state that explodes is found out elsewhere."""
    return 300.0 if a > 300.0 else -300.0 if a < -300.0 else a


def morris_lecar_rhs(x: State, drive: float, p: Params) -> State:
    """One neuron whose inputs enter inside a single gap junction; ``x`` is (z, n)."""
    k, gain, v_0, c = p[0], p[1], p[3], p[15]
    current, dn = membrane(x[0] + v_0, x[1], p)
    return ((current + k * (gain * drive - x[0])) / c, dn)


def morris_lecar_oscillator_rhs(x: State, drive: float, p: Params) -> State:
    """Two neurons that inhibit each other, wired as the paper's; ``x`` is (z1, n1, z2, n2)."""
    k, gain, v_0, c = p[0], p[1], p[3], p[15]
    first, dn1 = membrane(x[0] + v_0, x[1], p)
    second, dn2 = membrane(x[2] + v_0, x[3], p)
    return (
        (first + k * (gain * drive - x[2] - x[0])) / c,
        dn1,
        (second + k * (-x[0] - x[2])) / c,
        dn2,
    )


def _slopes(v: float, n: float, p: Params) -> tuple[float, float, float, float]:
    """Return the derivatives of :func:`membrane`: of the current by v and n, of n' by v and n."""
    phi, v_1, v_2, v_3, v_4 = p[4], p[5], p[6], p[7], p[8]
    g_ca, g_k, g_l, v_ca, v_k = p[9], p[10], p[11], p[12], p[13]
    m, n_inf = opened(v, v_1, v_2), opened(v, v_3, v_4)
    a = _bounded((v - v_3) / (2.0 * v_4))
    by_v = -g_ca * (m + 2.0 * m * (1.0 - m) / v_2 * (v - v_ca)) - g_k * n - g_l
    gate = phi * (
        math.cosh(a) * 2.0 * n_inf * (1.0 - n_inf) / v_4 + math.sinh(a) / (2.0 * v_4) * (n_inf - n)
    )
    return by_v, -g_k * (v - v_k), gate, -phi * math.cosh(a)


def morris_lecar_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return D f of :func:`morris_lecar_rhs`, last column by the drive."""
    k, gain, c = p[0], p[1], p[15]
    a, b, g, d = _slopes(x[0] + p[3], x[1], p)
    return (((a - k) / c, b / c, k * gain / c), (g, d, 0.0))


def morris_lecar_oscillator_jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
    """Return D f of :func:`morris_lecar_oscillator_rhs`, last column by the drive."""
    k, gain, c = p[0], p[1], p[15]
    a1, b1, g1, d1 = _slopes(x[0] + p[3], x[1], p)
    a2, b2, g2, d2 = _slopes(x[2] + p[3], x[3], p)
    return (
        ((a1 - k) / c, b1 / c, -k / c, 0.0, k * gain / c),
        (g1, d1, 0.0, 0.0, 0.0),
        (-k / c, 0.0, (a2 - k) / c, b2 / c, 0.0),
        (0.0, 0.0, g2, d2, 0.0),
    )


MORRIS_LECAR = Model(
    'morris_lecar',
    2,
    morris_lecar_rhs,
    first_state,
    (*COUPLING, _constant('current', 'applied current', PLANT_CURRENT, 'uA/cm2'), *CONSTANTS),
    _pack_neuron,
    jacobian=morris_lecar_jacobian,
    x0=(0.0, 0.07),
)
MORRIS_LECAR_OSCILLATOR = Model(
    'morris_lecar_oscillator',
    4,
    morris_lecar_oscillator_rhs,
    first_state,
    (
        *COUPLING,
        _constant('current', 'applied current of both neurons', OSCILLATOR_CURRENT, 'uA/cm2'),
        _constant('i_rest', "the plant's current, whose rest is 0 of all signals", 60.0, 'uA/cm2'),
        *CONSTANTS,
    ),
    _pack_oscillator,
    jacobian=morris_lecar_oscillator_jacobian,
    x0=(20.0, 0.1, -10.0, 0.1),
)
