# SPDX-License-Identifier: Apache-2.0
"""Observer and prediction against equations written out again, and what they are there for."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.api import judge as judged
from eventreg_ros.errors import EventregError
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import SampledLoop

H = 0.05
PREDICT = 'controller.predict:=true'
TRUE_PLANT = ('reference.k:=1', 'reference.tau:=0.09090909090909091')


def predicting(name, lead, *overrides):
    return load(name, PREDICT, f'/**.lead:={lead}', *overrides)


def late(name, delay, duration, *overrides, lead=None, **more):
    scenario = predicting(name, delay if lead is None else lead, *overrides)
    return simulate(scenario, duration, sampled=True, delay=delay, on='yu', **more)


# The equations again: lists, dicts, and lines as two-point formulas.


def rk4(f, x, h, drive):
    def at(k, a):
        return [p + a * q for p, q in zip(x, k, strict=True)]

    k1 = f(x, *drive(0.0))
    k2 = f(at(k1, h / 2), *drive(0.5))
    k3 = f(at(k2, h / 2), *drive(0.5))
    k4 = f(at(k3, h), *drive(1.0))
    mean = ((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True))
    return [p + h * m for p, m in zip(x, mean, strict=True)]


def neuron(x, drive, k, tau):
    return [x[0] - x[0] ** 3 / 3 - x[1] + k * (drive - x[0]), tau * (x[0] - x[1])]


def oscillator(x, drive, k, tau):
    return neuron(x[:2], drive - x[2], k, tau) + neuron(x[2:4], -x[0], k, tau)


def onwards(samples, s):
    """The line over step s through the last two samples; nothing before the first."""
    base = samples.get(s, 0.0)
    slope = base - samples.get(s - 1, base)
    return lambda theta: base + theta * slope


class Oracle:
    def __init__(self, k, tau, delay, lead, gamma=0.0, plant=(1.0, 1 / 11)):
        self.k, self.delay, self.lead, self.gamma, self.plant = k, delay, lead, gamma, plant
        self.z = [0.5, 0.0, -0.5, 0.0, 0.0, 0.0, tau]
        self.u = {lead: self.predicted(lead)}

    def rhs(self, z, y, acted):
        e, tau = y - z[4], z[6]
        return [
            *oscillator(z[:4], e, self.k, tau),
            *neuron(z[4:6], z[0] + acted, *self.plant),
            -self.gamma * self.k * e * z[1] * tau,
        ]

    def predicted(self, left):
        x = self.z[:4]
        while left:
            j = 4 if left >= 4 else 1
            x = rk4(lambda x: oscillator(x, 0.0, self.k, self.z[6]), x, H * j, lambda theta: ())
            left -= j
        return x[0]

    def step(self, n, y, v):
        m = n - self.delay
        if m > 0:
            u, hears = onwards(self.u, m - 1), onwards(v, m - 1)
            straight = lambda theta: y[m - 1] + theta * (y[m] - y[m - 1])  # noqa: E731
            drive = lambda theta: (straight(theta), hears(theta) - u(theta))  # noqa: E731
            self.z = rk4(self.rhs, self.z, H, drive)
        self.u[n + self.lead + 1] = self.predicted(n + self.lead + 1 - max(m, 0))


def acting(w, v, u, n):
    w, v, u = (onwards(samples, n) for samples in (w, v, u))
    return lambda theta: (w(theta) + v(theta) - u(theta),)


def whole_loop(steps, exosystem, controller, v=None):
    """The samples of y and u of a loop of exosystem (k, tau), oracle and plant; and 1/tau."""
    w, p, y, sent_w = [1.0, 0.0, -1.0, 0.0], [0.0, 0.0], {}, {}
    v = v or {}
    for n in range(steps):
        y[n], sent_w[n] = p[0], w[0]
        controller.step(n, y, v)
        p = rk4(lambda x, d: neuron(x, d, 1.0, 1 / 11), p, H, acting(sent_w, v, controller.u, n))
        w = rk4(lambda x: oscillator(x, 0.0, *exosystem), w, H, lambda theta: ())
    u = [controller.u[n + controller.lead] for n in range(steps)]
    return np.array(list(y.values())), np.array(u), controller.z[6]


@pytest.mark.slow
@pytest.mark.parametrize('delay', [0.0, 2.0])
def test_the_loop_is_that_of_equations_written_out_again(delay):
    d = round(delay / H)
    y, u, tau = whole_loop(2000, (1.0, 1 / 12), Oracle(3.0, 1 / 16, d, d, gamma=0.04))
    found = late('mismatch', delay, 100.0, 'controller.adapt:=0.04')
    assert tau > 1 / 16 + 0.003, 'it has learned meanwhile'
    np.testing.assert_allclose(found['y'][:-1], y, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(found['u'][:-1], u, rtol=0.0, atol=1e-9)
    assert found['u/tau'][-1] == pytest.approx(tau, abs=1e-11)


@pytest.mark.slow
def test_the_replica_hears_v_and_its_plant_may_be_another():
    found = late('open', 0.5, 100.0, 'controller.plant_k:=1.2', 'controller.plant_tau:=0.08')
    v = dict(enumerate(found['v']))
    assert 2.0 in np.diff(found['v']) + 0.5
    oracle = Oracle(4.0, 1 / 15, 10, 10, plant=(1.2, 0.08))
    y, u, _ = whole_loop(2000, (1.0, 1 / 12), oracle, v)
    np.testing.assert_allclose(found['y'][:-1], y, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(found['u'][:-1], u, rtol=0.0, atol=1e-9)


# What it is there for: the figures of the table in docs/late.md, a part of them.


@pytest.mark.slow
@pytest.mark.parametrize('delay', [0.5, 8.0])
def test_exact_vanishes_at_any_delay(delay):
    run = late('exact', delay, 400.0)
    assert run.verdict == 'rejected'
    assert np.abs(run['y'][run.t >= 300.0]).max() < 0.005


@pytest.mark.slow
def test_a_wrong_model_bears_0_80_and_not_0_85():
    assert late('mismatch', 0.80, 400.0).verdict == 'rejected'
    assert late('mismatch', 0.85, 400.0).verdict == 'not rejected'


CASES = {
    'mismatch': (1, 1 / 12, 3, 1 / 16),
    'fast': (2, 1 / 20, 1, 1 / 12),
}


@pytest.mark.slow
@pytest.mark.parametrize('case', CASES)
def test_learning_makes_up_for_a_wrong_model_at_2(case):
    names = ('exosystem.k', 'exosystem.tau', 'controller.k', 'controller.tau')
    values = [f'{name}:={value}' for name, value in zip(names, CASES[case], strict=True)]
    fixed = late('exact', 2.0, 450.0, *values)
    assert [t for t in fixed.events['y'] if t > 300.0]
    learned = late('exact', 2.0, 600.0, 'controller.adapt:=0.04', *values)
    assert [t for t in learned.events['y'] if t > 300.0] == []
    assert learned['u/tau'][-1] == pytest.approx(CASES[case][1], rel=1e-3)


@pytest.mark.slow
def test_events_that_v_asks_for_stay_without_a_reference_node():
    truth = late('open', 2.0, 600.0, 'controller.adapt:=0.04', *TRUE_PLANT)
    report = judged(truth, settle=300.0)
    assert report.rejection.reference_events >= 3
    assert (report.rejection.spurious, report.rejection.missed) == (0, 0)
    assert np.abs(truth['y'] - truth['y_r'])[truth.t > 300.0].max() < 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ('case', 'limit'),
    [
        ({'delay': 2.0, 'lead': 2.4}, 0.01),  # believed longer than it is: it waits
        ({'delay': 2.0, 'lead': 1.6}, 0.1),
        ({'delay': 2.0, 'loss': 0.5}, 0.06),
        ({'delay': 0.0, 'jitter': 4.0, 'lead': 5.0}, 0.005),
        ({'delay': 1.0, 'jitter': 4.0, 'lead': 3.0}, 0.1),  # covers half
    ],
)
def test_wrong_leads_loss_and_jitter(case, limit):
    run = late('exact', duration=340.0, seed=1, **case)
    assert run.verdict == 'rejected'
    assert np.abs(run['y'][run.t >= 300.0]).max() < limit


# How it behaves


def samples(scenario, impairment, duration, compiled):
    return SampledLoop(scenario.loop).run(duration, impairment, compiled=compiled).signals


@pytest.mark.slow
def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    coded = ['controller.coding:=spikes', 'plant.send_on_delta:=0.02']
    scenario = predicting('open', 1.5, 'controller.adapt:=0.04', *coded)
    jittery = Impairment(delay=1.0, jitter=1.0, loss=0.3, seed=3, on=frozenset('yuv'))
    for impairment in (Impairment(delay=1.5, on=frozenset('yu')), jittery):
        plain, fast = (samples(scenario, impairment, 120.0, c) for c in (False, True))
        for name in plain:
            assert plain[name].tobytes() == fast[name].tobytes(), name


@pytest.mark.slow
def test_switched_off_and_on_again_it_starts_anew_and_is_silent_soon():
    at = ['120:controller:deactivate', '170:controller:activate']
    run = late('exact', 2.0, 300.0, at=at)
    off = (run.t > 120.0) & (run.t < 170.0)
    assert not run['u'][off].any()
    # at first it goes as at the very start: u is what the copy makes of its x0 until y comes
    start, again = run['u'][:40], run['u'][round(170 / H) + 1 :][:40]
    np.testing.assert_array_equal(start, again)
    events = np.array(run.events['y'])
    assert ((events > 120.0) & (events < 175.0)).any()
    assert not (events > 170.0 + 35.0).any()


def test_what_is_set_while_it_runs_is_taken_over():
    at = ['100:controller.tau:=0.0625']
    changed, fixed = (late('exact', 1.0, 130.0, at=a) for a in (at, []))
    first = round(100 / H) + 1
    np.testing.assert_array_equal(changed['u'][:first], fixed['u'][:first])
    assert changed['u'][first] != fixed['u'][first]
    off = ['20:controller:deactivate', '30:controller:activate']
    continuous = simulate(predicting('open', 0.0), 40.0, at=off)
    assert not continuous['u'][(continuous.t > 20.0) & (continuous.t < 30.0)].any()


@pytest.mark.slow
def test_the_output_is_cut_off_and_the_replica_knows():
    run = late('exact', 1.0, 200.0, 'controller.output_limit:=1.5', 'controller.adapt:=0.01')
    assert run['u'].max() == 1.5
    assert run['u'].min() == -1.5
    free = late('exact', 1.0, 200.0, 'controller.adapt:=0.01')
    assert run['u/tau'][-1] == pytest.approx(free['u/tau'][-1], rel=2e-3)


def test_y_that_never_comes_is_skipped_and_u_goes_on():
    scenario = predicting('exact', 0.0, 'controller.excitatory:=[nobody]')
    alone = simulate(scenario, 100.0, sampled=True)
    free = simulate(load('exact', 'controller.excitatory:=[nobody]'), 100.0)
    np.testing.assert_allclose(alone['u'], free['u'], rtol=0.0, atol=2e-4)


@pytest.mark.slow
def test_a_lost_stretch_of_y_is_bridged_and_a_long_one_forgotten():
    patient = late('exact', 0.0, 300.0, '/**.input_timeout:=3.0', loss=0.95, seed=1)
    hasty = late('exact', 0.0, 300.0, '/**.input_timeout:=0.02', loss=0.95, seed=1)
    assert not np.array_equal(patient['u'], hasty['u'])
    for run in (patient, hasty):
        assert np.isfinite(run['u']).all()


@pytest.mark.slow
@pytest.mark.parametrize('name', ['mismatch', 'open'])
def test_continuous_is_the_limit_without_delay(name):
    truth = simulate(predicting(name, 2.0), 60.0)
    assert list(truth.signals) == list(late(name, 0.0, 1.0).signals)
    errors = []
    for times in (4, 8):
        run = late(name, 0.0, 60.0, f'/**.rate:={200 * times}')
        errors.append(np.abs(run['y'][::times] - truth['y']).max())
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.slow
def test_continuous_hears_v_through_the_replica():
    with_v = simulate(predicting('open', 0.0, *TRUE_PLANT), 200.0)
    reference = simulate(load('open', *TRUE_PLANT), 200.0)
    np.testing.assert_allclose(with_v['y'], reference['y'], rtol=0.0, atol=1e-6)


def test_the_lead_of_a_plant_delays_u_and_nothing_else():
    ahead = simulate(load('exact', 'plant.lead:=0.3'), 50.0, sampled=True)
    slow = simulate('exact', 50.0, sampled=True, delay=0.3, on=['u'])
    # the line of a sample that is played in time is not drawn onwards
    zero = [load('exact', *more, '/**.hold:=zero') for more in ([], ['plant.lead:=0.3'])]
    late_u = simulate(zero[0], 50.0, sampled=True, delay=0.3, on=['u'])
    assert simulate(zero[1], 50.0, sampled=True)['y'].tobytes() == late_u['y'].tobytes()
    assert not np.array_equal(ahead['y'], slow['y'])
    others = ['exosystem.lead:=1', 'reference.lead:=1', 'controller.lead:=1']
    same = [simulate(load('open', *more), 30.0, sampled=True) for more in ([], others)]
    assert same[0]['y'].tobytes() == same[1]['y'].tobytes()


@pytest.mark.parametrize(
    ('override', 'words'),
    [
        (['controller.plant_k:=0.7'], r'plant_k must be >= 1 .*contract'),
        (['controller.model:=neuron', 'controller.x0:=[0, 0]'], 'model must be oscillator'),
        (["controller.excitatory:=['y', w]"], 'excitatory must name one signal'),
        (["controller.plant_inputs:=['y']"], 'different signals'),
        (['plant.lead:=-1'], 'lead must be a finite number >= 0'),
        (['plant.predict:=true'], "no parameter 'predict'"),
    ],
)
def test_what_cannot_predict_is_refused(override, words):
    with pytest.raises(EventregError, match=words):
        load('open', PREDICT, *override)
