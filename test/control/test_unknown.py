# SPDX-License-Identifier: Apache-2.0
"""Loops whose generator nobody knows: what a fixed controller loses, and an adaptive one not."""

import math

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.learning import locked_at
from eventreg_ros.api import judge as judge_run

LEARNS = 'controller.adapt:=0.04'
SLOW = ('controller.k:=1', 'exosystem.tau:=0.05')
RIGHT = ('controller.tau:=1/12', 'reference.k:=1', 'reference.tau:=1/11')
IMPAIRED = {'delay': 0.2, 'loss': 0.1}


def outcome(run, settle, late):
    """Wrong events after ``settle``, and the largest |y - y_r| after ``late``."""
    rejection = judge_run(run, settle).rejection
    y_r = run.signals.get('y_r', np.zeros_like(run.t))
    return rejection.spurious + rejection.missed, np.abs(run['y'] - y_r)[run.t >= late].max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'overrides', 'links', 'wrong', 'late', 'left', 'rate'),
    [
        ('exact', SLOW, {}, 13, 600.0, (1.6, 3.5e-8), 20.0),
        ('exact', SLOW, IMPAIRED, 13, 600.0, (1.6, 0.007), 20.0),
        ('open', ('controller.k:=1', 'exosystem.tau:=1/20', *RIGHT), {}, 14, 600.0,
         (2.5, 1.3e-7), 20.0),
        ('open', ('controller.k:=2', 'exosystem.tau:=1/25', *RIGHT), {}, 2, 600.0, None, 25.0),
        ('mismatch', (), {}, 0, 400.0, (0.145, 5.8e-6), 12.0),
        ('open', (), {}, 0, 600.0, None, 12.9),
    ],
    ids=str,
)  # fmt: skip
def test_single_settings_fixed_and_adaptive(name, overrides, links, wrong, late, left, rate):
    """Computed beforehand by code that shares nothing with this package."""
    fixed, adaptive = (
        simulate(load(name, *overrides, *more), 800.0, sampled=True, **links)
        for more in ((), (LEARNS,))
    )
    found = [outcome(run, 100.0, late) for run in (fixed, adaptive)]
    assert [count for count, _ in found] == [wrong, 0]
    if left is not None:
        assert [size for _, size in found] == pytest.approx(list(left), rel=0.05)
    assert 1.0 / adaptive['u/tau'][-1] == pytest.approx(rate, rel=2e-3)


def generators(count):
    """Random generators: tau log-uniform in 1/25..1/6, k in 0.7..4, any initial state."""
    rng = np.random.default_rng(11)
    for _ in range(count):
        tau = math.exp(rng.uniform(math.log(1 / 25), math.log(1 / 6)))
        x0 = rng.uniform(-2.0, 2.0, 4).tolist()
        yield {'exosystem': {'tau': tau, 'k': rng.uniform(0.7, 4.0), 'x0': x0}}


@pytest.mark.slow
def test_random_generators_are_learned_within_eight_periods():
    """At k 0.7, with delay and loss: most of them are too much for the fixed controller."""
    base = load('exact', 'controller.k:=0.7')
    lost = 0
    for given in generators(12):
        scenario, tau = base.with_given(given), given['exosystem']['tau']
        lost += outcome(simulate(scenario, 600.0, sampled=True, **IMPAIRED), 300.0, 0.0)[0] > 0
        adaptive = scenario.with_given({'controller': {'adapt': 0.04}})
        run = simulate(adaptive, 700.0, sampled=True, **IMPAIRED)
        assert outcome(run, 300.0, 0.0)[0] == 0
        period = 10.275 + 2.2726 / tau
        assert locked_at(run.t, run['u/tau'], tau) < 8.0 * period
    assert lost >= 6, 'or the test has no teeth'


def derivative(s, tau_w, k, gamma):
    """Two generators with k 2, two controllers that learn, one plant: all written out again."""
    w, c, (y, m) = s[:8].reshape(2, 4), s[8:18].reshape(2, 5), s[18:]
    a, b, c3, c4 = w.T
    p, q, r, z, tau = c.T
    rows = [
        np.stack(
            [a - a**3 / 3 - b + 2 * (-c3 - a), tau_w * (a - b),
             c3 - c3**3 / 3 - c4 + 2 * (-a - c3), tau_w * (c3 - c4)], axis=1,
        ).ravel(),
        np.stack(
            [p - p**3 / 3 - q + k * (y - r - p), tau * (p - q),
             r - r**3 / 3 - z + k * (-p - r), tau * (r - z), -gamma * k * y * q * tau], axis=1,
        ).ravel(),
        [y - y**3 / 3 - m + (a.sum() - p.sum() - y), (y - m) / 11],
    ]  # fmt: skip
    return np.concatenate(rows)


@pytest.mark.slow
def test_the_bank_is_that_of_equations_written_out_again():
    run = simulate('unknown', 60.0)
    s = [1, 0, -1, 0, -0.4, 0.6, 0.9, -0.3]
    s = np.array([*s, 0.5, 0, -0.5, 0, 0.1, 0.5, 0, -0.5, 0, 1 / 22, 0, 0], dtype=float)
    arguments, h, every = (np.array([1 / 12, 1 / 19]), 1.0, 0.04), 0.01, 5
    for n in range(6001):
        if n % every == 0:
            found = (run['y'][n // every], run['u/tau'][n // every], run['u_2/tau'][n // every])
            assert found == pytest.approx((s[18], s[12], s[17]), abs=2e-7)
        k1 = derivative(s, *arguments)
        k2 = derivative(s + 0.5 * h * k1, *arguments)
        k3 = derivative(s + 0.5 * h * k2, *arguments)
        k4 = derivative(s + h * k3, *arguments)
        s = s + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6


@pytest.mark.slow
def test_a_bank_needs_no_more_than_the_right_taus():
    run = simulate('two_generators', 900.0, sampled=True)
    assert run.verdict == 'rejected'
    late = run.t > 800.0
    assert np.abs(run['y'][late]).max() < 1e-12
    for suffix in ('', '_2'):
        assert np.abs(run[f'w{suffix}'] - run[f'u{suffix}'])[late].max() < 1e-9, 'each its own'
    one = load('two_generators', 'plant.inhibitory:=[u]')
    assert simulate(one, 900.0, sampled=True).verdict == 'not rejected'


def test_after_a_long_time_it_is_exact():
    pytest.importorskip('numba')
    run = simulate(load('exact', LEARNS), 20000.0, sampled=True)
    assert abs(math.log(12.0 * run['u/tau'][-1])) < 1e-9
    assert np.abs(run['y'][run.t > 19900.0]).max() < 1e-9


def test_a_gain_beyond_what_converges_fails_for_a_slow_generator():
    slow = load('exact', 'exosystem.tau:=0.04', 'controller.k:=2', 'controller.adapt:=0.2')
    run = simulate(slow, 1500.0, sampled=True)
    assert np.abs(np.log(25.0 * run['u/tau'][run.t > 1200.0])).max() > 0.05
