# SPDX-License-Identifier: Apache-2.0
"""Hodgkin-Huxley neurons against their equations, written out again in absolute voltages."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros import simulate
from eventreg_ros.models.catalogue import model_of
from eventreg_ros.models.hodgkin_huxley import (
    HODGKIN_HUXLEY,
    HODGKIN_HUXLEY_OSCILLATOR,
    gates,
    rest,
)
from eventreg_ros.scenario import Scenario
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.simulation.sampled import simulate_sampled

STARTS = (
    [5.0, 0.05, 0.6, 0.32, -5.0, 0.05, 0.6, 0.32],
    [45.0, 0.5, 0.2, 0.5, 0.0, 0.05, 0.6, 0.32],
    [0.0, 0.05, 0.5, 0.4, 15.0, 0.1, 0.4, 0.4],
)


def scenario(k=0.3, gain=5.0, x0=STARTS[0], **controller):
    """Time in ms, h = 0.05; an event is a spike of 55 mV above the rest, to -10 mV."""
    pace = {'time_scale': 10.0, 'rate': 200.0}
    pair = {'model': 'hodgkin_huxley_oscillator', 'k': k, **pace}
    return Scenario.of(
        'axons',
        {
            'exosystem': pair,
            'plant': {'model': 'hodgkin_huxley', 'k': k, **pace},
            'controller': {**pair, 'drive_gain': gain, 'x0': list(x0), **controller},
            'spike_monitor': {'signals': ['w', 'y', 'u'], 'threshold': 55.0, 'reset': 35.0},
        },
    )


def axon(v, m, h, n, applied):
    """Currents and gates of the squid's axon, as the textbooks have them."""
    a_m = 0.1 * (v + 40) / (1 - np.exp(-(v + 40) / 10))
    a_n = 0.01 * (v + 55) / (1 - np.exp(-(v + 55) / 10))
    a_h, b_h = 0.07 * np.exp(-(v + 65) / 20), 1 / (1 + np.exp(-(v + 35) / 10))
    b_m, b_n = 4 * np.exp(-(v + 65) / 18), 0.125 * np.exp(-(v + 65) / 80)
    current = applied - 120 * m**3 * h * (v - 50) - 36 * n**4 * (v + 77) - 0.3 * (v + 54.387)
    return current, a_m * (1 - m) - b_m * m, a_h * (1 - h) - b_h * h, a_n * (1 - n) - b_n * n


def test_the_rest_is_the_textbooks():
    v = rest(0.0)
    assert v == pytest.approx(-65.0, abs=0.01)
    # each gate is linear: where it stands still follows from its slope at 0 and at 1
    at_0, at_1 = (np.array(axon(v, gate, gate, gate, 0.0))[1:] for gate in (0.0, 1.0))
    settled = at_0 / (at_0 - at_1)
    assert np.abs(axon(v, *settled, 0.0)).max() < 1e-9
    assert HODGKIN_HUXLEY.x0[1:] == pytest.approx(settled, abs=5e-3)
    assert rest(5.0) > v


@pytest.mark.slow
def test_the_loop_is_that_of_equations_written_out_again():
    v0, k, gain = rest(0.0), 0.3, 5.0

    def slope(t, s):
        c = s.reshape(5, 4)
        w, w2, u, u2, y = c[:, 0] - v0
        inputs = (-w2 - w, -w - w2, gain * y - u2 - u, -u - u2, w - u - y)
        found = np.array([axon(*x, i) for x, i in zip(c, (20, 20, 20, 20, 0), strict=True)])
        found[:, 0] += k * np.array(inputs)
        return found.ravel()

    run = simulate(scenario(), 60.0)
    start = np.array([*HODGKIN_HUXLEY_OSCILLATOR.x0, *STARTS[0], *HODGKIN_HUXLEY.x0])
    start[::4] += v0
    truth = solve_ivp(slope, (0.0, 60.0), start, 'DOP853', run.t, rtol=1e-10, atol=1e-11).y
    for signal, i in (('w', 0), ('u', 8), ('y', 16)):
        np.testing.assert_allclose(run[signal], truth[i] - v0, rtol=0.0, atol=1e-5)


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    blocks = scenario().loop.blocks
    loop = Loop({name: blocks[name] for name in ('exosystem', 'plant')})
    plain, fast = (simulate_sampled(loop, 60.0, compiled=c).signals for c in (False, True))
    for name, x in plain.items():
        np.testing.assert_array_equal(x.view(np.int64), fast[name].view(np.int64))


@pytest.mark.slow
@pytest.mark.parametrize('x0', STARTS, ids=['near', 'spiking', 'apart'])
def test_with_a_gain_on_its_drive_the_controller_works_from_all_starts(x0):
    run = simulate(scenario(x0=x0), 400.0, sampled=True)
    assert run.verdict == 'rejected'
    assert np.abs(run['y'][run.t > 380.0]).max() < 1.0
    assert run['w'].max() > 90.0


@pytest.mark.slow
def test_without_it_there_are_starts_from_which_it_does_not():
    assert simulate(scenario(gain=1.0, x0=STARTS[2]), 400.0, sampled=True).verdict == 'not rejected'


def test_at_the_removable_singularities_the_gates_are_smooth():
    assert (gates(-40.0)[0][0], gates(-55.0)[2][0]) == (1.0, 0.1)
    for d in (1e-12, 1e-9, 1e-6):  # the slope is half the rate over the width
        assert gates(-40.0 + d)[0][0] - 1.0 == pytest.approx(0.05 * d, rel=1e-3, abs=1e-14)
        assert gates(-55.0 - d)[2][0] - 0.1 == pytest.approx(-0.005 * d, rel=1e-3, abs=1e-14)
    p = HODGKIN_HUXLEY.pack(0.0, 1.0, 0.0)
    assert np.isfinite(HODGKIN_HUXLEY.rhs((1e6, 0.5, 0.5, 0.5), 0.0, p)).all()
    assert np.isfinite(HODGKIN_HUXLEY.rhs((-1e6, 0.5, 0.5, 0.5), 0.0, p)).all()


def test_they_are_in_the_catalogue_in_every_role():
    for role in ('exosystem', 'plant', 'controller', 'reference'):
        assert model_of(role, 'hodgkin_huxley') is HODGKIN_HUXLEY
        assert model_of(role, 'hodgkin_huxley_oscillator') is HODGKIN_HUXLEY_OSCILLATOR
