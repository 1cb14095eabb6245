# SPDX-License-Identifier: Apache-2.0
import cmath
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from eventreg_ros import scenario
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.evaluator import Evaluator, Setting
from eventreg_ros.robustness.margin_words import least_share
from eventreg_ros.robustness.margins import (
    FINE,
    KINDS,
    Limit,
    delay_and_loss,
    limit,
    margins,
    rate_for,
    reach,
)
from eventreg_ros.robustness.scans import scan_of, search
from eventreg_ros.simulation.impairment import Impairment

LONG = Setting(duration=900.0, settle=700.0)
"""Long enough that what is stable has died out, and what is not has grown, before it is judged."""


def trial(name, hold, h, setting=None, *overrides):
    return Evaluator(scenario.load(name, overrides), hold, 10.0 / h, setting or Setting())


# The linear motif with k_y = 0, K_eta = (1, 0): every link late by tau, the characteristic
# equation is (s + 1)(s^2 + 1) + s e^(-2 s tau) = 0, for y and u are each late once.


def critical_delay():
    """Return the least tau at which a root of the characteristic equation is imaginary, s = j a."""
    a = np.sqrt([r.real for r in np.roots([1.0, -1.0, -2.0, 1.0]) if r.real > 0.0])  # |.| = |.|
    assert (1.0 + a**2) * (1.0 - a**2) ** 2 == pytest.approx(a**2)
    phases = [-cmath.phase(-(1.0 + 1j * x) * (1.0 - x * x) / (1j * x)) % math.tau for x in a]
    return min(phase / (2.0 * x) for phase, x in zip(phases, a, strict=True))


def spectral_radius(d, h):
    """Return the largest |z| of the sampled linear loop with zero hold and links late by d steps.

    The state is x, the controller's two, and the last d samples of y and of u.
    """
    n = 3 + 2 * d
    a = np.zeros((n, n))
    c, s = math.cos(h), math.sin(h)
    y_late = [0] if d == 0 else [2 + d]
    u_late = [1] if d == 0 else [2 + 2 * d]
    a[0, 0] = math.exp(-h)
    a[0, u_late] -= 1.0 - math.exp(-h)
    a[1:3, 1:3] = [[c, s], [-s, c]]
    a[1, y_late] += s  # the integral of e^(Phi t) G over a step
    a[2, y_late] += c - 1.0
    for first, source in ((3, 0), (3 + d, 1)) if d else ():
        a[first, source] = 1.0
        a[first + 1 : first + d, first : first + d - 1] = np.eye(d - 1)
    return abs(np.linalg.eigvals(a)).max()


@pytest.mark.slow
@pytest.mark.parametrize('h', [0.02, 0.01])
def test_the_delay_margin_of_the_linear_motif_is_that_of_theory(h):
    found = limit(trial('linear', 'zero', h, LONG), 'delay')
    # a zero hold is late by half a step more, in the mean
    assert found.largest < critical_delay() - h / 2 < found.fails_at
    assert found.fails_at - found.largest == pytest.approx(h)
    radius = [spectral_radius(round(delay / h), h) for delay in (found.largest, found.fails_at)]
    assert radius[0] < 1.0 < radius[1]


@pytest.mark.slow
@pytest.mark.parametrize('signal', ['y', 'u'])
def test_a_delay_of_one_signal_of_the_loop_may_be_twice_as_long(signal):
    # The characteristic equation has e^(-s tau) then, for only one of y and u is late.
    h = 0.02
    alone = Evaluator(scenario.load('linear'), 'zero', 10.0 / h, LONG, signal)
    found = limit(alone, 'delay')
    # the hold of each of the two links is late by half a step, and the bisection ends within one
    assert found.largest < 2.0 * critical_delay() - h < found.fails_at


def test_a_delay_outside_the_loop_is_borne_without_end():
    found = limit(Evaluator(scenario.load('linear'), 'zero', 200.0, Setting(), 'w'), 'delay')
    assert found.largest == found.scanned_to
    assert found.fails_at is None


@pytest.mark.slow
def test_bisection_finds_what_trying_every_delay_finds():
    # k_y and the gain move the edge, so that it is not always at the same place of the scan
    for overrides in ([], ['controller.gain:=[0.5, 0.0]'], ['controller.k_y:=0.2']):
        tested = trial('linear', 'zero', 0.05, Setting(duration=300.0), *overrides)
        every = [tested.rejected(Impairment(delay=0.05 * k)) for k in range(21)]
        first = every.index(False)
        assert not any(every[first:])
        found = limit(tested, 'delay')
        assert found.largest == pytest.approx(0.05 * (first - 1))
        assert found.fails_at == pytest.approx(0.05 * first)


@pytest.mark.slow
@pytest.mark.parametrize(('name', 'low', 'high'), [('exact', 0.3, 0.45), ('mismatch', 0.2, 0.35)])
def test_the_delay_margins_are_in_the_brackets(name, low, high):
    setup = scenario.load(name)
    rate = rate_for('delay', setup, Setting())
    zero, linear = (
        limit(Evaluator(setup, hold, rate, Setting()), 'delay') for hold in ('zero', 'linear')
    )
    assert low <= zero.largest < zero.fails_at <= high
    assert zero.resolution == zero.h == 0.01
    assert linear.largest >= zero.largest
    assert zero.rejected_again == linear.rejected_again == ()


@pytest.mark.slow
def test_margins_asks_for_each_hold_and_kind_at_its_rate():
    setup, shown = scenario.load('linear'), []
    found = margins(setup, Setting(duration=200.0, seeds=1), lambda *step: shown.append(step))
    cases = [(kind, None) for kind in (*KINDS, 'delay')]
    cases += [('delay', signal) for signal in 'wyu']
    wanted = [(hold, *case) for hold in ('zero', 'linear') for case in cases]
    assert [(x.hold, x.kind, x.on) for x in found] == wanted
    assert [x.rate for x in found[:5]] == [1000.0, 200.0, 200.0, 200.0, 1000.0]
    for x in (x for x in found if x.on is None):
        assert x.fails_at - x.largest == pytest.approx(x.resolution)
        again = Evaluator(setup, x.hold, x.rate, Setting(duration=200.0, seeds=1))
        assert again.rejected(Impairment(**{x.kind: x.largest}))
        assert not again.rejected(Impairment(**{x.kind: x.fails_at}))
    words = [words for _, _, words in shown]
    assert f'zero hold, delay {found[0].largest:g}: rejected' in words
    assert f'zero hold, delay {found[0].fails_at:g}: not rejected' in words
    assert {count for _, count, _ in shown} == {14}
    assert [done for done, _, _ in shown] == sorted(done for done, _, _ in shown)
    assert shown[0][0] == 0
    assert shown[-1][0] > 7


def test_the_rate():
    setup = scenario.load('exact')
    assert rate_for('delay', setup, Setting()) == 10.0 / FINE
    assert rate_for('loss', setup, Setting()) == rate_for('jitter', setup, Setting()) == 200.0
    fast = scenario.load('exact', ['/**.rate:=5000'])
    assert {rate_for(kind, fast, Setting()) for kind in KINDS} == {5000.0}
    assert {rate_for(kind, fast, Setting(rate=50.0)) for kind in KINDS} == {50.0}


def test_search_finds_the_edge_wherever_it_is():
    for scan in ([0, 1, 10, 20, 40], list(range(0, 30, 7)), [0, 5]):
        for edge in range(1, scan[-1] + 1):
            asked = []
            found = search(lambda k, e=edge, a=asked: a.append(k) or k < e, scan)
            assert found == (edge - 1, edge, ())
            assert len(asked) <= len(scan) + math.ceil(math.log2(max(np.diff(scan))))


def test_search_at_the_ends():
    assert search(lambda k: True, [0, 5, 10]) == (10, None, ())
    assert search(lambda k: k > 0, [0, 5, 10]) == (None, 0, ())


def test_search_stops_at_the_first_failure_and_tells_what_passes_beyond():
    def passes(k):
        return k < 23 or 37 <= k < 58

    assert search(passes, list(range(0, 51, 10))) == (22, 23, (40, 50))
    assert search(passes, list(range(0, 61, 10))) == (22, 23, (40, 50))


@pytest.mark.parametrize('h', [0.001, 0.01, 0.05, 0.3, 3.0, 50.0])
@pytest.mark.parametrize('kind', KINDS)
def test_the_scan_begins_at_0_and_goes_on_to_its_end(kind, h):
    scan, unit = scan_of(kind, h)
    assert scan[:1] == [0]
    assert scan == sorted(set(scan))
    assert len(scan) > 1
    if kind == 'loss':
        assert scan[-1] * unit == 0.99
    else:
        assert scan[1] == 1
        assert scan[-1] * unit == pytest.approx({'delay': 2.0, 'jitter': 20.0}[kind], abs=h)


@pytest.mark.slow
def test_every_seed_must_be_rejected():
    tested = trial('exact', 'linear', 0.05, Setting(seeds=6))
    verdicts = [tested.verdict(Impairment(loss=0.85, seed=seed)) == 'rejected' for seed in range(6)]
    assert len(set(verdicts)) == 2  # at this loss some are and some are not
    assert verdicts == [
        tested.verdict(Impairment(loss=0.85, seed=seed)) == 'rejected' for seed in range(6)
    ]
    assert tested.share(Impairment(loss=0.85)) == sum(verdicts) / 6
    assert not tested.rejected(Impairment(loss=0.85))
    first = verdicts.index(False)
    some = trial('exact', 'linear', 0.05, Setting(seeds=first + 1))
    assert not some.rejected(Impairment(loss=0.85))
    if first:
        assert trial('exact', 'linear', 0.05, Setting(seeds=first)).rejected(Impairment(loss=0.85))


def test_a_scenario_that_is_not_rejected_has_no_margin():
    found = margins(scenario.load('uncontrolled'), Setting(duration=200.0, rate=100.0))
    assert {(x.largest, x.fails_at, x.rejected_again) for x in found} == {(None, 0.0, ())}


@pytest.mark.slow
def test_a_loop_that_goes_out_of_all_bounds_is_not_rejected():
    wild = trial('linear', 'zero', 0.05, Setting(duration=1500.0), 'controller.gain:=[-5, 0]')
    assert wild.verdict() == 'not rejected'
    assert limit(wild, 'loss').largest is None


@pytest.mark.parametrize(
    ('name', 'setting', 'says'),
    [
        ('quiescent', Setting(), 'scenario quiescent has no verdict'),
        ('exact', Setting(duration=120.0), 'longer --duration'),
        ('exact', Setting(duration=1e12), 'shorter duration'),
    ],
)
def test_what_has_no_verdict_is_an_error(name, setting, says):
    with pytest.raises(EventregError, match=says):
        margins(scenario.load(name), setting)


@pytest.mark.slow
def test_the_map_agrees_with_single_trials():
    setup = scenario.load('linear', ['/**.rate:=100'])
    setting = Setting(duration=200.0, seeds=2)
    found = delay_and_loss(setup, 0.5, setting, rows=3)
    assert found.h == 0.1
    assert found.delays == pytest.approx(0.1 * np.arange(6))
    assert found.losses.tolist() == [0.0, 0.475, 0.95]
    for hold, share in found.rejected.items():
        tested = Evaluator(setup, hold, 100.0, setting)
        for i, loss in enumerate(found.losses.tolist()):
            for j, delay in enumerate(found.delays.tolist()):
                assert share[i, j] == tested.share(Impairment(delay=delay, loss=loss))
    assert 0.0 < found.rejected['zero'].mean() < found.rejected['linear'].mean() < 1.0


def test_a_map_has_no_more_columns_than_asked_for():
    setup = scenario.load('uncontrolled')
    found = delay_and_loss(setup, 2.0, Setting(duration=40.0, seeds=1), columns=4, rows=2)
    assert len(found.delays) <= 4
    assert found.delays[-1] == pytest.approx(2.0, abs=found.delays[1])


@pytest.mark.parametrize('seeds', [1, 5, 20, 100])
def test_what_all_seeds_say_of_all_runs_is_wilsons_interval(seeds):
    interval = binomtest(seeds, seeds).proportion_ci(0.95, method='wilson')
    assert least_share(seeds) == pytest.approx(interval.low, abs=1e-6)


def test_the_picture_reaches_beyond_both_edges():
    at = Limit('delay', 'zero', None, 200.0, 0.05, 0.05, 0.2, 0.25, 2.0, ())
    assert reach([at, replace(at, fails_at=0.4)]) == pytest.approx(0.6)
    assert reach([at, replace(at, fails_at=None)]) == 2.0
    assert reach([replace(at, largest=None, fails_at=0.0)]) == 0.3
