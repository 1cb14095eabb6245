# SPDX-License-Identifier: Apache-2.0
"""Identification against generators integrated here, by equations written down once more."""

import json
from functools import lru_cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from eventreg_ros.analysis.identification import (
    Plant,
    identify_from_plant,
    identify_generator,
    identify_generators,
    identify_generators_from_plant,
    integration,
)
from eventreg_ros.analysis.identification.orbit import period
from eventreg_ros.errors import EventregError

KEYS = ['tau', 'tau_sd', 'k', 'k_sd', 'identifiable', 'period', 'residual_rms', 'signal']
PLANT = Plant(1.0, 1 / 11)
IN_ANTIPHASE = (1.0, 0.3, -1.0, -0.3)
OTHER = (-0.4, 0.6, 0.4, -0.6)
FROM_ANYWHERE = (1.0, 0.5, 0.3, 0.2)


def neuron(v, r, drive, k, tau):
    return v - v**3 / 3.0 - r + k * (drive - v), tau * (v - r)


@lru_cache
def record(tau, x0=IN_ANTIPHASE, k=2.0, *, length=200.0, every=0.05, plant=PLANT, controller=None):
    """Return t, w, y, u of generator, plant and, if there is one, a controller (k, tau)."""
    k_c, tau_c = controller or (0.0, 1.0)

    def loop(_, x):
        a, b, c, d, y, q, e, f, g, h = x.tolist()
        u = e if controller else 0.0
        return (
            *neuron(a, b, -c, k, tau), *neuron(c, d, -a, k, tau), *neuron(y, q, a - u, *plant),
            *neuron(e, f, y - g, k_c, tau_c), *neuron(g, h, -e, k_c, tau_c),
        )  # fmt: skip

    t = every * np.arange(round(length / every) + 1)
    start = [*x0, 0.0, 0.0, 0.5, 0.0, -0.5, 0.0]
    x = solve_ivp(loop, (0.0, t[-1]), start, 'DOP853', t, rtol=1e-10, atol=1e-12).y
    return t, x[0], x[4], x[6]


@pytest.fixture(scope='module')
def many():
    """Six generators, each without control and in a loop."""
    random = np.random.default_rng(3)
    taus = np.exp(random.uniform(np.log(1 / 25), np.log(1 / 6), 6))
    starts = random.uniform(-2.0, 2.0, (6, 2))
    x0 = [(a, b, -a, -b) for a, b in starts.tolist()]
    free = [record(tau, x) for tau, x in zip(taus, x0, strict=True)]
    closed = [record(tau, x, controller=(1.0, 1 / 12)) for tau, x in zip(taus, x0, strict=True)]
    return taus, free, closed


def median_error(tau, found):
    return np.median(np.abs(np.log([one.tau for one in found] / tau)))


def noisy(x, sd):
    return x + sd * np.random.default_rng(0).standard_normal(len(x))


@pytest.mark.slow
@pytest.mark.parametrize(('sd', 'limit'), [(0.0, 1e-7), (0.01, 2e-5), (0.05, 2e-4)])
def test_tau_from_w(many, sd, limit):
    taus, free, _ = many
    assert median_error(taus, [identify_generator(t, noisy(w, sd)) for t, w, _, _ in free]) < limit


@pytest.mark.slow
@pytest.mark.parametrize(('sd', 'limit'), [(0.0, 1e-7), (0.05, 2e-4)])
@pytest.mark.parametrize('plant', [PLANT, None])
def test_tau_through_a_plant(many, sd, limit, plant):
    some = slice(6 if plant else 2)
    taus, free, _ = many
    found = [identify_from_plant(t, noisy(y, sd), plant=plant) for t, _, y, _ in free[some]]
    assert median_error(taus[some], found) < limit


@pytest.mark.slow
@pytest.mark.parametrize(('sd', 'limit'), [(0.0, 1e-7), (0.05, 1e-4)])
def test_tau_from_a_running_loop(many, sd, limit):
    taus, _, closed = many
    found = [identify_from_plant(t, noisy(y, sd), u) for t, _, y, u in closed]
    assert median_error(taus, found) < limit


def orbits(taus, x, h, steps):
    """Return w of many uncoupled neurons, shape (steps + 1, m), by the classical Runge-Kutta."""
    rows = [x[0]]
    for _ in range(steps):
        a = np.array(neuron(*x, 0.0, 0.0, taus))
        b = np.array(neuron(*(x + h / 2 * a), 0.0, 0.0, taus))
        c = np.array(neuron(*(x + h / 2 * b), 0.0, 0.0, taus))
        d = np.array(neuron(*(x + h * c), 0.0, 0.0, taus))
        x = x + h / 6 * (a + 2 * b + 2 * c + d)
        rows.append(x[0])
    return np.array(rows)


@pytest.mark.slow
def test_the_intervals_hold_the_truth_as_often_as_they_say():
    random = np.random.default_rng(11)
    taus = np.exp(random.uniform(np.log(1 / 9), np.log(1 / 6), 200))
    w = orbits(taus, random.uniform(-2.0, 2.0, (2, 200)), 0.05, 1400)[::8]
    w += 0.05 * random.standard_normal(w.shape)
    found = [identify_generator(0.4 * np.arange(len(x)), x) for x in w.T]
    for level, least, most in ((0.95, 0.90, 0.99), (0.5, 0.4, 0.7)):
        intervals = [one.interval(level) for one in found]
        held = [low <= tau <= high for tau, (low, high) in zip(taus, intervals, strict=True)]
        assert least <= np.mean(held) <= most


def test_without_noise_the_interval_is_that_of_the_integration():
    t, w, _, _ = record(1 / 12)
    found = identify_generator(t, w)
    low, high = found.interval()
    assert low < 1 / 12 < high
    assert 1e-9 < found.tau_sd * 12 < 1e-6


@pytest.mark.slow
def test_k_cannot_be_known_in_antiphase():
    for sd in (0.0, 0.05):
        t, w, _, _ = record(1 / 12, k=1.3)
        found = identify_generator(t, w + sd * np.random.default_rng(2).standard_normal(len(w)))
        assert found.identifiable == (True, False)
        assert found.k is found.k_sd is found.k_interval() is None
        assert 'antiphase' in found.reason


@pytest.mark.slow
@pytest.mark.parametrize('way', ['w', 'y'])
def test_k_is_known_where_the_generator_starts_out_of_antiphase(way):
    t, w, y, _ = record(1 / 12, FROM_ANYWHERE, k=1.3)
    noise = 0.005 * np.random.default_rng(2).standard_normal(len(w))
    found = identify_generator(t, w + noise) if way == 'w' else identify_from_plant(t, y + noise)
    assert found.identifiable == (True, True)
    low, high = found.k_interval(0.99)
    assert low < 1.3 < high < 1.5 * low
    low, high = found.interval(0.99)
    assert low < 1 / 12 < high
    assert 'out of antiphase' in found.reason


@pytest.mark.slow
def test_k_in_much_noise_is_not_identifiable():
    t, w, _, _ = record(1 / 12, FROM_ANYWHERE, k=1.3)
    found = identify_generator(t, w + 0.5 * np.random.default_rng(2).standard_normal(len(w)))
    assert not found.identifiable.k
    low, high = found.interval(0.99)
    assert low < 1 / 12 < high


def sampled(t, x, how):
    random = np.random.default_rng(7)
    if how == 'every 2':
        return t[::40], x[::40]
    if how == 'irregular':
        kept = np.sort(random.permutation(len(t))[: len(t) // 20])
        return t[kept], x[kept]
    if how == 'gaps':
        kept = (t < 60.0) | ((t > 90.0) & (t < 150.0)) | (t > 200.0)
        return t[kept], x[kept]
    if how == 'not finite':
        x = x.copy()
        x[200:400] = np.nan
        return t, x
    if how == 'jitter':
        return np.sort(t + 2e-3 * random.exponential(size=len(t))), x
    return t + 1.7e9, x


@pytest.mark.slow
@pytest.mark.parametrize(
    'how', ['every 2', 'irregular', 'gaps', 'not finite', 'jitter', 'from far']
)
def test_any_rate_gaps_and_jitter(how):
    t, w, y, _ = record(1 / 12, length=250.0)
    for identify, x in ((identify_generator, w), (identify_from_plant, y)):
        found = identify(*sampled(t, x, how))
        low, high = found.interval(0.99)
        assert low < 1 / 12 < high
        assert found.tau == pytest.approx(1 / 12, rel=1e-5)


@pytest.mark.slow
def test_of_a_running_loop_only_the_longest_part_without_a_gap_is_taken():
    t, _, y, u = record(1 / 12, length=250.0, controller=(1.0, 1 / 10))
    kept = (t < 60.0) | (t > 90.0)
    found = identify_from_plant(t[kept], y[kept], u[kept])
    assert found.tau == pytest.approx(1 / 12, rel=1e-5)
    assert found.duration == pytest.approx(159.95)


@pytest.mark.slow
def test_what_is_too_long_is_cut():
    t, w, _, _ = record(1 / 12, length=1100.0)
    assert identify_generator(t, w).duration == pytest.approx(1000.0)
    fine = np.linspace(0.0, 200.0, 100_000)
    found = identify_generator(fine, np.interp(fine, t, w))
    assert found.samples <= 40_000
    assert found.duration == pytest.approx(200.0, abs=0.01)


@pytest.mark.slow
def test_a_sensor_with_gain_and_offset():
    t, w, y, _ = record(1 / 12)
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(w))
    for identify, x in ((identify_generator, w), (identify_from_plant, y)):
        found = identify(t, 40.0 * (x + noise) - 65.0, affine=True)
        assert found.tau == pytest.approx(1 / 12, rel=1e-4)
        assert (found.gain, found.offset) == pytest.approx((40.0, -65.0), rel=1e-3)
        assert found.residual_rms == pytest.approx(0.4, rel=0.05)
    with pytest.raises(EventregError, match=r'not what a generator makes: .* gain'):
        identify_generator(t, 1.7 * w + 0.3)
    with pytest.raises(EventregError, match='affine'):
        identify_from_plant(t, y, 0.0 * y, affine=True)


@pytest.mark.slow
def test_upside_down_the_tau_is_the_same():
    t, w, y, _ = record(1 / 12)
    assert identify_generator(t, -w).tau == pytest.approx(1 / 12, rel=1e-7)
    assert identify_from_plant(t, -y).tau == pytest.approx(1 / 12, rel=1e-7)


@pytest.mark.slow
def test_another_plant():
    t, _, y, _ = record(1 / 12, plant=(0.6, 1 / 7))
    assert identify_from_plant(t, y, plant=Plant(0.6, 1 / 7)).tau == pytest.approx(1 / 12, rel=1e-7)
    assert identify_from_plant(t, y, plant=None).tau == pytest.approx(1 / 12, rel=1e-7)


def test_the_period_is_that_of_the_spikes():
    def upwards(_, x):
        return x[0]

    upwards.direction = 1.0
    exact = solve_ivp(
        lambda _, x: neuron(*x, 0.0, 0.0, 1 / 12), (0.0, 300.0), (1.0, 0.0), 'DOP853',
        events=upwards, rtol=1e-10, atol=1e-12,
    ).t_events[0]  # fmt: skip
    assert period(1 / 12) == pytest.approx(exact[-1] - exact[-2], rel=1e-6)
    assert identify_generator(*record(1 / 12)[:2]).period == pytest.approx(period(1 / 12), rel=1e-6)


T = np.arange(0.0, 400.0, 0.1)
NOISE = np.random.default_rng(4).standard_normal(len(T))


@pytest.mark.slow
@pytest.mark.parametrize(
    ('x', 'reason'),
    [
        (0.0 * T, r'constant \(0\)'),
        (0.0 * T[:0], '0 finite samples'),
        (np.nan * T, '0 finite samples of 4000'),
        (0.2 * np.sin(T / 6.0), 'shows no spikes: .* stays within 0.2'),
        (0.3 * NOISE, 'shows no spikes'),
        (3.0 * NOISE, 'not periodic: .* vary from'),
        (2.0 * np.sin(T / 8.0 * (1.0 + T / 400.0)), 'not periodic: .* vary from'),
        (2.0 * np.sin(T / 90.0), r'1 spike up and 1 down in 399\.5 .* two of the one and one'),
        (2.0 * np.sin(T / 6.0), r'repeats after 37\.7 of .* not what a generator makes'),
        (2.0 * np.sign(np.sin(T / 6.0)), r'repeats after 37\.\d* of .* not what a generator makes'),
    ],
)
def test_what_is_no_periodic_spike_train_is_refused_with_the_reason(x, reason):
    with pytest.raises(EventregError, match=reason) as caught:
        identify_generator(T[: len(x)], x)
    message = str(caught.value)
    assert message.startswith('w')
    assert len(message) < 300
    assert '\n' not in message


def test_a_recording_of_few_samples_is_refused():
    t, w, _, _ = record(1 / 12)
    with pytest.raises(EventregError, match=r'too thinly: every 6 of .* after 36\.9'):
        identify_generator(t[::120], w[::120])


@pytest.mark.parametrize(
    ('t', 'x', 'reason'),
    [
        (T, T[1:], r'one length, got the shapes \(4000,\), \(3999,\)'),
        (T[::-1], T, 'must not decrease, but do after 399.9'),
    ],
)
def test_arrays_that_do_not_fit(t, x, reason):
    with pytest.raises(EventregError, match=reason):
        identify_generator(t, x)


def test_a_plant_that_cannot_be():
    with pytest.raises(EventregError, match=r'k > 0 and tau > 0, got 0 and 0\.1'):
        identify_from_plant(T, T, plant=Plant(0.0, 0.1))


def test_a_generator_that_changes_is_refused():
    t, fast, _, _ = record(1 / 12)
    _, slow, _, _ = record(1 / 18)
    with pytest.raises(EventregError, match='not periodic'):
        identify_generator(np.arange(2 * len(t)) * 0.05, np.concatenate([fast, slow]))


def plant_under(t, w):
    """Return y of the plant that w drives, as a curve through its samples."""
    curve = CubicSpline(t, w)
    x = solve_ivp(
        lambda at, x: neuron(*x, float(curve(at)), *PLANT), (0.0, t[-1]), (0.0, 0.0), 'DOP853', t,
        rtol=1e-8, atol=1e-9,
    )  # fmt: skip
    return x.y[0]


@pytest.mark.slow
@pytest.mark.parametrize('way', ['w', 'y'])
def test_two_generators_in_one_signal(way):
    t, one, _, _ = record(1 / 12, length=300.0)
    _, other, _, _ = record(1 / 19, OTHER, length=300.0)
    if way == 'w':
        found = identify_generators(t, noisy(one + other, 0.02), 2)
    else:
        y = plant_under(t, one + other)
        found = identify_generators_from_plant(t, noisy(y, 0.02), 2)
    assert [each.tau for each in found] == pytest.approx([1 / 19, 1 / 12], rel=1e-4)
    for each, truth in zip(found, (1 / 19, 1 / 12), strict=True):
        low, high = each.interval(0.999)
        assert low < truth < high
        assert not each.identifiable.k


@pytest.mark.slow
def test_generators_that_are_not_separable():
    t, one, _, _ = record(1 / 12, length=300.0)
    _, same, _, _ = record(1 / 12, OTHER, length=300.0)
    with pytest.raises(EventregError, match='not separable'):
        identify_generators(t, one + same, 2)
    with pytest.raises(EventregError, match='not separable'):
        identify_generators(t, one, 2)
    with pytest.raises(EventregError, match='at least 2, got 1'):
        identify_generators(t, one, 1)


@pytest.mark.slow
def test_compiled_and_plain_agree(monkeypatch):
    t, w, _, _ = record(1 / 12, FROM_ANYWHERE)
    monkeypatch.setattr(integration, 'compiles', lambda: False)
    plain = identify_generator(t, w)
    monkeypatch.undo()
    monkeypatch.setattr(integration, 'PAYS', 0)
    compiled = identify_generator(t, w)
    assert compiled.tau == pytest.approx(plain.tau, rel=1e-12)
    assert compiled.k == pytest.approx(plain.k, rel=1e-9)


def test_the_contract_of_the_json():
    t, w, _, _ = record(1 / 12)
    data = identify_generator(t, w, signal='w_2').to_dict()
    assert list(data) == KEYS
    assert data['signal'] == 'w_2'
    assert data['identifiable'] == {'tau': True, 'k': False}
    assert json.loads(json.dumps(data, allow_nan=False)) == data


def test_a_level_that_is_none():
    t, w, _, _ = record(1 / 12)
    with pytest.raises(EventregError, match='between 0 and 1, got 95'):
        identify_generator(t, w).interval(95)
