# SPDX-License-Identifier: Apache-2.0
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros import scenario
from eventreg_ros.analysis.events import detect
from eventreg_ros.errors import EventregError
from eventreg_ros.models import INTERNAL_MODEL
from eventreg_ros.simulation import continuous
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.simulation.stimulus import Stimulus

TRUTH = json.loads(Path(__file__).with_name('truth.json').read_text())
H = 0.02


@pytest.mark.slow
@pytest.mark.parametrize('name', [name for name in TRUTH if name != 'source'])
def test_meets_the_truth(name):
    truth, setup = TRUTH[name], scenario.load(name)
    found = simulate(setup.loop, truth['duration'], H)
    samples = dict(truth['samples'])
    at = np.rint(np.array(samples.pop('t')) / H).astype(int)
    for signal, values in samples.items():
        np.testing.assert_allclose(found.signals[signal][at], values, rtol=0, atol=1e-6)
    for signal, events in truth['events'].items():
        times = detect(found.t, found.signals[signal], *setup.criteria.detector)
        np.testing.assert_allclose(times, events, rtol=0, atol=1e-3)


def by_hand(pieces, x0, par, times):
    """The open loop of the paper, written down again: integrate it piece by piece of constant v."""
    (k_w, tau_w), (k_p, tau_p), (k_c, tau_c), (k_r, tau_r) = par
    own = np.array([k_w, k_w, k_p, k_c, k_c, k_r])
    tau = np.array([tau_w, tau_w, tau_p, tau_c, tau_c, tau_r])

    def rhs(t, x, v):
        a, b = x[:6], x[6:]
        w, w2, y, u, u2, y_r = a
        inputs = np.array([-w2, -w, w + v - u, y - y_r - u2, -u, v])
        return np.concatenate([a - a**3 / 3 - b + own * (inputs - a), tau * (a - b)])

    found, x = np.empty((12, len(times))), np.array(x0)
    for start, end, v in pieces:
        inside = (times >= start) & (times < end)
        result = solve_ivp(
            rhs, (start, end), x, 'LSODA', dense_output=True, args=(v,), rtol=1e-12, atol=1e-13
        )
        if inside.any():
            found[:, inside] = result.sol(times[inside])
        x = result.y[:, -1]
    return dict(zip(('w', 'y', 'u', 'y_r'), found[[0, 2, 3, 5]], strict=True))


def test_meets_an_independent_integration_elsewhere():
    par = [(0.8, 0.1), (1.3, 0.07), (2.6, 0.05), (0.9, 0.2)]
    # voltages, then recoveries: w1 w2 | y | u1 u2 | y_r; not symmetric, not at rest
    x0 = [0.7, -0.2, 0.4, -1.1, 0.9, -0.5, 0.1, 0.3, -0.6, 0.2, -0.1, 0.05]
    order = {'exosystem': (0, 6, 1, 7), 'plant': (2, 8), 'controller': (3, 9, 4, 10)}
    order['reference'] = (5, 11)
    blocks = {
        name: replace(spec, params=p, x0=tuple(x0[i] for i in order[name]))
        for (name, spec), p in zip(scenario.load('open').blocks.items(), par, strict=True)
    }
    stimulus = Stimulus('pulses', amplitude=1.2, offset=-0.1, onsets=(3.3, 17.003), width=4.1)
    edges = [0.0, *stimulus.breaks(40.0), 40.01]
    pieces = [(a, b, stimulus((a + b) / 2)) for a, b in pairwise(edges)]
    found = simulate(Loop(blocks, {'v': stimulus}), 40.0, 0.1)
    expected = by_hand(pieces, x0, par, found.t)
    for signal, values in expected.items():
        np.testing.assert_allclose(found.signals[signal], values, rtol=0, atol=1e-7)
    np.testing.assert_array_equal(found.signals['v'], [stimulus(t) for t in found.t.tolist()])


class Spy(Stimulus):
    """A stimulus that remembers when it was asked."""

    def __call__(self, t):
        self.__dict__.setdefault('asked', []).append(t)
        return super().__call__(t)


def test_no_step_straddles_a_jump():
    # far shorter than a step of the integrator, and never asked for at a jump itself
    stimulus = Spy('pulses', amplitude=40.0, onsets=(11.3, 20.1), width=0.015)
    blocks = scenario.load('open').blocks
    found = simulate(Loop(blocks, {'v': stimulus}), 30.0, 0.25)
    breaks = stimulus.breaks(30.0)
    assert len(breaks) == 4
    assert not set(breaks) & set(stimulus.asked)
    edges = [0.0, *breaks, 30.01]
    pieces = [(a, b, stimulus((a + b) / 2)) for a, b in pairwise(edges)]
    par = [spec.params[:2] for spec in blocks.values()]
    expected = by_hand(pieces, [1, -1, 0, 0.5, -0.5, 0, 0, 0, 0, 0, 0, 0], par, found.t)
    assert np.ptp(expected['y_r'][(found.t > 11) & (found.t < 13)]) > 1.0
    for signal, values in expected.items():
        np.testing.assert_allclose(found.signals[signal], values, rtol=0, atol=1e-7)


def test_feedthrough_meets_the_matrix_exponential():
    from scipy.linalg import expm

    k_y, k1, k2 = 0.4, 0.7, 0.3
    setup = scenario.load(
        'linear', [f'controller.k_y:={k_y}', f'controller.gain:=[{k1}, {k2}]', 'plant.x0:=[0.5]']
    )
    # states: w, its partner, x, and the controller's two; u = k_y x + k1 eta1 + k2 eta2
    a = np.array([
        [0, 1, 0, 0, 0], [-1, 0, 0, 0, 0], [1, 0, -1 - k_y, -k1, -k2],
        [0, 0, 1, 0, 1], [0, 0, 0, -1, 0],
    ])  # fmt: skip
    found = simulate(setup.loop, 12.0, 1.0)
    x = np.array([expm(a * t) @ [1, 0, 0.5, 0, 0] for t in found.t])
    np.testing.assert_allclose(found.signals['y'], x[:, 2], rtol=0, atol=1e-9)
    u = x @ [0, 0, k_y, k1, k2]
    np.testing.assert_allclose(found.signals['u'], u, rtol=0, atol=1e-9)


def test_feedthrough_in_a_row_in_any_order():
    specs = scenario.load('linear').blocks
    first = replace(specs['controller'], inputs=(('w', 1.0),), output='a', params=(2.0, 0, 0))
    second = replace(first, inputs=(('a', -1.0),), output='b')
    loop = Loop({'second': second, 'first': first, 'exo': specs['exosystem']})
    found = simulate(loop, 1.0, 0.5)
    np.testing.assert_allclose(found.signals['b'], -4.0 * found.signals['w'], rtol=1e-14)


def test_an_algebraic_loop_is_an_error():
    spec = scenario.load('linear').blocks['controller']
    assert spec.model is INTERNAL_MODEL
    a = replace(spec, inputs=(('b', 1.0),), output='a')
    b = replace(spec, inputs=(('a', 1.0),), output='b')
    with pytest.raises(EventregError, match='algebraic loop: the outputs of a, b'):
        simulate(Loop({'a': a, 'b': b}), 1.0)


def test_the_grid_is_every_h_from_0():
    found = simulate(scenario.load('exact').loop, 1.0)
    np.testing.assert_array_equal(found.t, np.arange(21) * 10.0 / 200.0)
    found = simulate(scenario.load('exact').loop, 1.0, 0.3)
    np.testing.assert_array_equal(found.t, np.arange(4) * 0.3)
    assert len(simulate(scenario.load('exact').loop, 0.3, 0.1).t) == 4
    assert len(simulate(scenario.load('open').loop, 0.0).t) == 1


@pytest.mark.parametrize('overrides', [['controller.gain:=[-5, 0]'], ['plant.x0:=[1e200]']])
def test_a_state_that_explodes_is_an_error(overrides):
    blocks = dict(scenario.load('linear', overrides).blocks)
    if 'x0' in overrides[0]:
        blocks['plant'] = replace(scenario.load('exact').blocks['plant'], x0=(1e200, 0.0))
    with pytest.raises(EventregError, match='stops being finite soon after t = '):
        simulate(Loop(blocks), 2000.0, 1.0)


def test_equations_too_stiff_to_wait_for_are_an_error(monkeypatch):
    for name in ('FIRST', 'EACH'):
        monkeypatch.setattr(continuous, name, 1000)  # the paper's loop takes less
    assert len(simulate(scenario.load('exact').loop, 20.0, 1.0).t) == 21
    stiff = scenario.load('exact', ['plant.k:=1e9']).loop
    with pytest.raises(EventregError, match=r'too stiff: 10\d\d evaluations reached t = '):
        simulate(stiff, 20.0, 1.0)


def test_bad_wiring_is_an_error():
    blocks = dict(scenario.load('exact').blocks)
    with pytest.raises(EventregError, match='exosystem and plant both publish'):
        Loop({**blocks, 'plant': replace(blocks['plant'], output='w')})
    with pytest.raises(EventregError, match='same time_scale and rate'):
        simulate(Loop({**blocks, 'plant': replace(blocks['plant'], rate=100.0)}), 1.0)
    with pytest.raises(EventregError, match='at least one block'):
        simulate(Loop({}), 1.0)
    with pytest.raises(EventregError, match='more than 4615384 steps'):
        simulate(Loop(blocks), 1e9)
