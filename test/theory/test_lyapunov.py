# SPDX-License-Identifier: Apache-2.0
"""Exponents against eigenvalues, known values, and the distance of two real trajectories."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros import scenario
from eventreg_ros.errors import EventregError
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.theory.linear import closed_loop, spectral_abscissa
from eventreg_ros.theory.lyapunov import (
    Exponent,
    UnboundedError,
    conditional_exponent,
    largest_exponent,
)
from eventreg_ros.theory.tangent import Tangent


def without_w(found):
    return found.loop.without('exosystem')


@pytest.mark.parametrize('moved', ['exosystem plant controller reference', 'plant'])
@pytest.mark.parametrize('name', scenario.shipped())
def test_tangent_is_the_derivative_of_the_loop(name, moved):
    """By central differences in a random direction, through every output and sign.

    With only the plant moved, the controller still is, through its input.
    """
    rng, found = np.random.default_rng(4), scenario.load(name, ['/**.k:=1.3', '/**.k_y:=0.7'])
    loop = Tangent(found.loop)
    x, dx = rng.normal(size=(2, len(loop.x0)))
    dx *= [role in moved for role, spec in found.blocks.items() for _ in spec.x0]
    v = [0.4] * len(found.stimuli)
    slope = loop.flow(v, x.tolist(), dx.tolist())
    expected = [loop.derivative(v, (x + sign * 1e-5 * dx).tolist()) for sign in (1, -1)]
    assert slope[: len(x)] == loop.derivative(v, x.tolist())
    np.testing.assert_allclose(slope[len(x) :], np.subtract(*expected) / 2e-5, rtol=1e-7, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize('gain', ['[1.0, 0.0]', '[0.5, -0.3]', '[3.0, 0.9]'])
def test_linear_loop_has_its_eigenvalue(gain):
    found = scenario.load('linear', [f'controller.gain:={gain}'])
    expected = spectral_abscissa(closed_loop(found.blocks['controller'].params))
    assert conditional_exponent(found.loop, 200.0).value == pytest.approx(expected, abs=1e-4)


@pytest.mark.slow
def test_linear_loop_that_is_unstable():
    found = scenario.load('linear', ['controller.gain:=[-1.0, 0.5]'])
    with pytest.raises(UnboundedError, match=r'before t = 1\d\d '):
        conditional_exponent(found.loop)
    at_rest = conditional_exponent(without_w(found), 200.0)
    expected = spectral_abscissa(closed_loop(found.blocks['controller'].params))
    assert at_rest.value == pytest.approx(expected, abs=1e-3)
    assert at_rest.sign == 1


def scalar(rate):
    """x' = rate(t) x + cos t, with its variation."""

    def flow(t, x, dx):
        return [rate(t) * x[0] + math.cos(t), rate(t) * dx[0]]

    return flow


def test_driven_scalar():
    found = largest_exponent(scalar(lambda t: -1.0 + 2.0 * math.sin(0.7 * t)), [1.0], [1.0], 300.0)
    assert found.value == pytest.approx(-1.0, abs=1e-3)
    assert found.sign == -1


@pytest.mark.slow
def test_fast_decay_is_not_lost_in_the_tolerance():
    """Within 5 units dx would fall to e^-200; the slower direction still shows."""

    def flow(_, x, dx):
        a, b = -40.0, -41.0
        return [a * x[0], b * x[1] + x[0], a * dx[0], b * dx[1] + dx[0]]

    found = largest_exponent(flow, [1.0, 1.0], [1.0, 1.0], 20.0, transient=10.0)
    assert found.value == pytest.approx(-40.0, rel=1e-6)


class Watched:
    """Pulses at 10, 20, ... that remember when they were asked; no stimulus class needs more."""

    def __init__(self):
        self.asked = []

    def __call__(self, t):
        self.asked.append(t)
        return 1.5 if int(t) // 10 % 2 else 0.0

    def breaks(self, end):
        return [10.0 * i for i in range(1, int(end) // 10 + 1)]


@pytest.mark.slow
def test_the_stimulus_is_asked_on_one_side_of_a_jump_only():
    v = Watched()
    conditional_exponent(Loop({'plant': scenario.load('open').blocks['plant']}, {'v': v}), 40.0)
    assert not set(v.asked).intersection(v.breaks(1000.0))
    assert len(v.asked) > 1000
    pieces = [int(t) // 10 for t in v.asked]
    assert pieces == sorted(pieces), 'an integrator that steps over a jump comes back to it'


@pytest.mark.slow
def test_lorenz():
    """0.9056, as in the literature (Sprott, Chaos and Time-Series Analysis, 2003)."""

    def flow(_, z, d):
        x, y, u = z
        return [
            10.0 * (y - x), x * (28.0 - u) - y, x * y - 8.0 / 3.0 * u,
            10.0 * (d[1] - d[0]), (28.0 - u) * d[0] - d[1] - x * d[2],
            y * d[0] + x * d[1] - 8.0 / 3.0 * d[2],
        ]  # fmt: skip

    found = largest_exponent(flow, [1.0, 1.0, 20.0], [1.0, 0.0, 0.0], 200.0, transient=20.0)
    assert found.value == pytest.approx(0.9056, abs=0.06)
    assert found.sign == 1
    assert 0.005 < found.half_width < 0.2


def test_limit_cycle_has_exponent_0():
    def van_der_pol(_, z, d):
        x, y = z
        return [y, (1 - x * x) * y - x, d[1], (-2 * x * y - 1) * d[0] + (1 - x * x) * d[1]]

    found = largest_exponent(van_der_pol, [1.0, 0.0], [1.0, 0.3], 300.0, transient=50.0)
    assert abs(found.value) < 1e-4
    assert found.sign == 0


@pytest.mark.slow
def test_exact_contracts_with_w_as_two_trajectories_do():
    """The distance of two solutions of the paper's equations, written out here, falls as fast."""

    def neuron(x1, x2, k, tau, z):
        return [x1 - x1**3 / 3 - x2 + k * (z - x1), tau * (x1 - x2)]

    def loop(w1, w2, w3, w4, x1, x2, a, b, c, d):
        return [
            *neuron(w1, w2, 2, 1 / 12, -w3), *neuron(w3, w4, 2, 1 / 12, -w1),
            *neuron(x1, x2, 1, 1 / 11, w1 - a),
            *neuron(a, b, 2, 1 / 12, x1 - c), *neuron(c, d, 2, 1 / 12, -a),
        ]  # fmt: skip

    w = [1.0, 0.0, -1.0, 0.0]
    t = np.arange(0.0, 151.0, 37.5467)  # whole periods of w, see truth/trajectories.json
    runs = [
        solve_ivp(lambda _, z: loop(*z), (0, 151), w + x, 'DOP853', t, rtol=1e-12, atol=1e-14).y
        for x in ([0.0, 0.0, 0.5, 0.0, -0.5, 0.0], [0.1, 0.1, 0.4, 0.1, -0.4, 0.0])
    ]
    distance = np.log(np.linalg.norm(runs[0] - runs[1], axis=0))[1:]
    measured = np.polyfit(t[1:], distance, 1)[0]
    found = conditional_exponent(scenario.load('exact').loop)
    assert found.value == pytest.approx(measured, abs=0.005)
    assert found.sign == -1


@pytest.mark.slow
def test_exact_does_not_contract_without_w():
    found = conditional_exponent(without_w(scenario.load('exact')), 200.0)
    assert abs(found.value) < 1e-3
    assert found.sign == 0


def test_plant_alone_at_rest_has_its_eigenvalue():
    """At 0 with k = 1 the Jacobian is ((0, -1), (tau, -tau)): real part -tau / 2."""
    found = conditional_exponent(without_w(scenario.load('uncontrolled')), 400.0)
    assert found.value == pytest.approx(-1 / 22, abs=1e-4)


@pytest.mark.slow
def test_reference_and_stimulus_belong_to_the_drive():
    """Perturbing the reference too would show its own rate, slower than the plant's."""
    found = scenario.load('open', ['reference.tau:=0.001'])
    blocks = {name: found.blocks[name] for name in ('plant', 'reference')}
    alone = conditional_exponent(Loop({'plant': blocks['plant']}, found.stimuli), 200.0)
    both = conditional_exponent(Loop(blocks, found.stimuli), 200.0)
    assert both.value == pytest.approx(alone.value, abs=1e-4)
    everything = conditional_exponent(
        Loop(blocks, found.stimuli), 200.0, perturbed=('plant', 'reference')
    )
    assert everything.value > -0.005 > both.value


def test_nothing_to_perturb():
    blocks = scenario.load('exact').blocks
    with pytest.raises(EventregError, match='nothing to perturb'):
        conditional_exponent(Loop({'exosystem': blocks['exosystem']}))


def test_rates_that_the_run_is_too_short_for_are_indistinguishable_from_0():
    slow = largest_exponent(scalar(lambda t: -0.01), [1.0], [1.0], 50.0, transient=1.0)
    assert slow.half_width == pytest.approx(1 / 50.0)
    assert slow.value == pytest.approx(-0.01, abs=1e-6)
    assert slow.sign == 0
    assert [Exponent(v, 0.1, (), 1.0).sign for v in (-0.2, -0.1, 0.0, 0.2)] == [-1, 0, 0, 1]
