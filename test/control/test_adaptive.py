# SPDX-License-Identifier: Apache-2.0
"""The adaptive internal model against equations written out again, and the bits of the fixed."""

from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.control.adaptive import adaptive, learning_parameters, paused
from eventreg_ros.errors import EventregError, ModelError
from eventreg_ros.models import NEURON, OSCILLATOR, Model, ModelParameter, first_state
from eventreg_ros.simulation.block import Block, make_advance
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.simulation.sampled import simulate_sampled

LEARNS = 'controller.adapt:=0.04'
SLOW = ('controller.k:=1', 'exosystem.tau:=0.05', LEARNS)
"""The fixed controller lets 13 events through here, and the adaptive one none."""


def equations(s, k_w, tau_w, k, k_p, tau_p, gamma):
    """Loop of exosystem, adaptive controller and plant: 4, 5 and 2 states, without any bounds."""
    a, b, c, d, p, q, r, z, tau, y, m = s
    return np.array([
        a - a**3 / 3 - b + k_w * (-c - a), tau_w * (a - b),
        c - c**3 / 3 - d + k_w * (-a - c), tau_w * (c - d),
        p - p**3 / 3 - q + k * (y - r - p), tau * (p - q),
        r - r**3 / 3 - z + k * (-p - r), tau * (r - z),
        -gamma * k * y * q * tau,
        y - y**3 / 3 - m + k_p * (a - p - y), tau_p * (y - m),
    ])  # fmt: skip


def integrated(steps, h, *constants):
    """Plain RK4; return y and tau at every step."""
    s = np.array([1.0, 0.0, -1.0, 0.0, 0.5, 0.0, -0.5, 0.0, 1 / 12, 0.0, 0.0])
    found = [s]
    for _ in range(steps):
        k1 = equations(s, *constants)
        k2 = equations(s + 0.5 * h * k1, *constants)
        k3 = equations(s + 0.5 * h * k2, *constants)
        k4 = equations(s + h * k3, *constants)
        s = s + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6
        found.append(s)
    return np.array(found)[:, [9, 8]].T


@pytest.mark.slow
def test_the_loop_is_that_of_equations_written_out_again():
    run = simulate(load('exact', *SLOW), 60.0)
    y, tau = integrated(12000, 0.005, 2.0, 0.05, 1.0, 1.0, 1 / 11, 0.04)
    assert abs(tau[-1] - tau[0]) > 0.02, 'it has learned meanwhile'
    np.testing.assert_allclose(run['y'], y[::10], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(run['u/tau'], tau[::10], rtol=0.0, atol=1e-10)


def test_without_gain_it_is_the_model_of_ever():
    fixed = load('exact').loop
    assert load('exact', 'controller.adapt:=0', 'controller.tau_max:=0.01').loop == fixed
    assert fixed.signals == ['w', 'y', 'u']
    with_tau = load('exact', LEARNS).loop
    assert with_tau.signals == ['w', 'y', 'u', 'u/tau']
    spec = with_tau.blocks['controller']
    still = replace(spec, params=paused(spec.model, spec.params))
    learned = simulate_sampled(Loop({**with_tau.blocks, 'controller': still}), 100.0).signals
    assert set(learned.pop('u/tau')) == {1 / 12}
    for name, x in simulate_sampled(fixed, 100.0).signals.items():
        np.testing.assert_array_equal(x.view(np.int64), learned[name].view(np.int64))


def test_nodes_plain_and_compiled_take_the_same_steps():
    pytest.importorskip('numba')
    loop = load('exact', *SLOW, 'controller.tau_min:=0.07').loop
    plain, fast = (simulate_sampled(loop, 120.0, compiled=c).signals for c in (False, True))
    for name, x in plain.items():
        np.testing.assert_array_equal(x.view(np.int64), fast[name].view(np.int64))
    assert plain['u/tau'].min() == 0.07, 'the bound was met'
    block = Block(loop.blocks['controller'])
    found = [block.learned['tau']]
    y = plain['y']
    for n in range(2000):
        slope = y[n] - y[n - 1] if n else 0.0  # the linear hold
        block.advance((float(y[n]), 0.0), (float(slope), 0.0))
        found.append(block.x[4])
    assert found == plain['u/tau'][:2001].tolist()


def test_the_jacobian_is_the_derivative():
    model, rng, step = adaptive(OSCILLATOR), np.random.default_rng(3), 1e-4
    p = (1.7, 9.9, 0.04, 0.02, 1.5)
    for _ in range(20):
        z = np.append(rng.normal(size=4), [rng.uniform(0.1, 0.9), rng.normal()])

        def rhs(z):
            return np.array(model.rhs(tuple(z[:5]), z[5], p))

        each = step * np.eye(6)
        expected = [(rhs(z + e) - rhs(z - e)) / (2 * step) for e in each]
        found = np.array(model.jacobian(tuple(z[:5]), z[5], p))
        np.testing.assert_allclose(found, np.transpose(expected), rtol=0.0, atol=1e-7)


@pytest.mark.slow
def test_it_stays_within_its_bounds_and_comes_back():
    model = adaptive(OSCILLATOR)
    p = (1.0, 0.0, 0.5, 0.05, 0.2)
    up, down = (1.0, -1.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0)
    assert model.rhs((*up, 0.2), 1.0, p)[4] == 0.0
    assert model.rhs((*down, 0.05), 1.0, p)[4] == 0.0
    assert model.rhs((*down, 0.2), 1.0, p)[4] == pytest.approx(-0.5 * 0.2)
    assert model.rhs((*up, 0.05), 1.0, p)[4] == pytest.approx(0.5 * 0.05)
    advance = make_advance(model)
    for x, bound in ((up, 0.2), (down, 0.05)):
        assert advance((*x, bound), (1.0,), (50.0,), (0.0,), p, 0.05)[0][4] == bound
    alone = load('quiescent', 'controller.adapt:=0.04')
    for sampled in (True, False):
        tau = simulate(alone, 600.0, sampled=sampled)['u/tau']
        assert tau.max() == pytest.approx(1.5, abs=1e-3), 'without w it goes to the upper bound'
        assert tau.min() >= 0.02
        assert sampled is False or tau.max() == 1.5


def test_retuned_it_goes_on_from_where_it_was():
    """A learned parameter becomes a state, and a state a parameter, at the values in the spec."""
    fixed = load('exact').loop.blocks['controller']
    block = Block(fixed)
    for _ in range(100):
        block.advance((0.7, 0.0), (0.0, 0.0))
    own = block.x
    block.retune(load('exact', LEARNS, 'controller.tau:=0.07').loop.blocks['controller'])
    assert block.x == (*own, 0.07)
    assert block.learned == {'tau': 0.07}
    block.advance((0.7, 0.0), (0.0, 0.0))
    own = block.x[:4]
    assert block.learned['tau'] != 0.07
    block.retune(fixed)
    assert block.x == own
    assert block.learned == {}


def half(v):
    return 0.5 * v


def made_of_others(leak):
    """A model whose functions call others, by name and by closure, as a package's may."""

    def inner(v):
        return leak * half(v)

    def rhs(x, drive, p):
        return (p[0] * (drive - inner(x[0])),)

    return Model('made', 1, rhs, first_state, (ModelParameter('k', 'gain'),))


def test_a_model_may_call_functions_of_its_own_compiled_too():
    pytest.importorskip('numba')
    loop = load('exact').loop
    plant = replace(loop.blocks['plant'], model=made_of_others(0.3), params=(0.4,), x0=(0.1,))
    loop = Loop({**loop.blocks, 'plant': plant})
    plain, fast = (simulate_sampled(loop, 50.0, compiled=c).signals for c in (False, True))
    for name, x in plain.items():
        np.testing.assert_array_equal(x.view(np.int64), fast[name].view(np.int64))


def test_only_what_can_learn_learns():
    with pytest.raises(ModelError, match="'neuron' does not say how it learns"):
        adaptive(NEURON)
    for bad in ('exosystem.adapt:=0.1', 'plant.adapt:=0.1'):
        with pytest.raises(EventregError, match="has no parameter 'adapt'"):
            load('exact', bad)
    with pytest.raises(EventregError, match="has no parameter 'adapt'"):
        load('linear', 'controller.adapt:=0.1')
    assert adaptive(OSCILLATOR) is adaptive(OSCILLATOR), 'compiled kernels are kept by it'
    assert [row.name for row in learning_parameters(OSCILLATOR.learns)] == [
        'adapt', 'tau_min', 'tau_max',
    ]  # fmt: skip


@pytest.mark.parametrize(
    ('overrides', 'words'),
    [
        (['controller.adapt:=-0.1'], 'controller.adapt must be a finite number >= 0'),
        ([LEARNS, 'controller.tau:=1.6'], r'tau must lie between tau_min and tau_max'),
        ([LEARNS, 'controller.tau_min:=0.09'], r'\(0.09 to 1.5\) to be learned, got 0.0833'),
        ([LEARNS, 'controller.tau_min:=2'], r'tau_min must be < tau_max \(1.5\)'),
        ([LEARNS, 'plant.output:=u/tau'], r"plant and controller both publish 'u/tau'"),
    ],
)
def test_bad_values_are_refused(overrides, words):
    with pytest.raises(EventregError, match=words):
        load('exact', *overrides)


def test_what_it_learns_is_a_signal_without_events():
    run = simulate(load('exact', 'controller.adapt:=0.04', 'controller.tau:=0.9'), 150.0)
    assert run['u/tau'][0] == 0.9
    entry = run.report.signals['u/tau']
    assert (entry.samples, entry.max, entry.events) == (len(run.t), 0.9, ())
    recorded = run.scenario.with_recorder('bag', 'text')
    assert recorded.nodes['recorder']['signals'] == ['w', 'y', 'u', 'u/tau']
    assert recorded.nodes['spike_monitor']['signals'] == ['w', 'y', 'u']


def test_another_block_may_listen_to_it():
    """u/tau is a signal like any other: the plant subtracts it here."""
    scenario = load('exact', LEARNS, 'plant.inhibitory:=[u, u/tau]')
    sampled = simulate(scenario, 30.0, sampled=True)
    assert ('plant', 'u/tau') in scenario.loop.links
    fixed = simulate(load('exact', LEARNS), 30.0, sampled=True)
    assert abs(sampled['y'][1] - fixed['y'][1]) > 1e-3
    continuous = simulate(scenario, 30.0)
    assert np.abs(continuous['y'] - sampled['y']).max() < 1e-2
