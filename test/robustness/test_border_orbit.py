# SPDX-License-Identifier: Apache-2.0
"""The followed border, against bisected simulations and against the continuous system."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.models import catalogue
from eventreg_ros.models.neuron import NEURON, neuron_rhs
from eventreg_ros.robustness import border_orbit
from eventreg_ros.robustness.border import Border, find_border
from eventreg_ros.robustness.border_orbit import follow
from eventreg_ros.robustness.followed import orbit_csv, orbit_curves
from eventreg_ros.robustness.orbit_rules import Line
from eventreg_ros.robustness.outcome import VERDICTS
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets
from eventreg_ros.robustness.sweep_words import border_words
from eventreg_ros.simulation.continuous import simulate

pytest.importorskip('numba')

TAU, K = 'exosystem.tau:=1/20..1/6/41', 'controller.k:=0.7..1/13'
BORDERS = {0.7: (9.25, 13.25), 1.0: (6.75, 15.0)}
"""The border in 1 / tau by k on steps of 0.25; beyond them the loop is not rejected."""

CONTINUOUS = {0.7: (9.1756, 13.3524), 1.0: (6.6787, 15.2402)}
"""The same border of the continuous system, as the docs have it."""


class Offer(NamedTuple):
    """What an installed package says of a model, as far as it is asked for."""

    load: object
    value: str = 'own:model'
    dist: None = None


def found(*parameters, names=('exosystem.tau', 'controller.k'), scenario='exact', **more):
    plan = Plan.of(load(scenario), [TAU, K, *parameters], **{'duration': 600.0, **more})
    border = find_border(plan, names)
    return plan, border, follow(plan, border)


def ends(border, followed):
    """Return tau and ``off`` where the curve reaches k = 0.7 and 1, by k, in order."""
    reached = {0.7: [], 1.0: []}
    for curve, piece in zip(orbit_curves(border, followed), followed.pieces, strict=True):
        for i in (0, -1):
            reached[round(curve[i, 1], 9)].append((curve[i, 0], piece.off[i]))
    return {k: sorted(each, reverse=True) for k, each in reached.items()}


def bisected(tau, k, hold, width):
    """Return where runs have their border about ``tau``, to a part in a million of ``width``."""
    plan = Plan.of(
        load('exact'), ['exosystem.tau:=0.01..1/9', f'controller.k:={k}', f'/**.hold:={hold}'],
        duration=600.0,
    )  # fmt: skip
    sets, low, high = Sets(plan), tau - width, tau + width
    for _ in range(3):
        values = np.linspace(low, high, 97)
        rejected = sets.run([values]).rows['verdict'] == 1
        changes = np.flatnonzero(rejected[1:] != rejected[:-1])
        assert len(changes) == 1
        low, high = values[changes[0]], values[changes[0] + 1]
    return 0.5 * (low + high)


@pytest.mark.slow
@pytest.mark.parametrize('hold', ['linear', 'zero'])
def test_the_curve_is_where_simulations_have_their_border(hold):
    """Nothing but how near a sample comes to the peak lies between, and ``off`` measures it."""
    _, border, followed = found(f'/**.hold:={hold}')
    assert (followed.missed, followed.dropped, followed.reason) == (0, 0, '')
    step = (1 / 6 - 1 / 20) / 40
    for k, (low, high) in BORDERS.items():
        pairs = ends(border, followed)[k]
        assert len(pairs) == 2
        for (tau, off), quarter, sign in zip(pairs, (low, high), (1.0, -1.0), strict=True):
            exact = bisected(tau, k, hold, 0.02 * step)
            assert 0.3 < sign * (exact - tau) / (off * step) < 3.0
            assert abs(exact - tau) < 1e-3 * step
            if hold == 'linear':
                assert 0.0 < sign * (quarter - 1 / tau) < 0.25


def peak(tau, k):
    """Return the largest y of the continuous loop once it has settled."""
    loop = load('exact', {'exosystem.tau': tau, 'controller.k': k}).loop
    y = simulate(loop, 450.0, 0.01).signals['y'][37_500:]  # more than a period
    top = int(np.argmax(y))
    a, b, c = y[top - 1 : top + 2]
    return b + (c - a) ** 2 / (8 * (2 * b - a - c))


@pytest.mark.slow
def test_with_the_step_it_goes_to_the_border_of_the_continuous_loop():
    """Of second order for the linear hold; the rest is what Richardson's rule leaves."""
    coarse, fine = (ends(*found(f'/**.rate:={rate}')[1:]) for rate in (200, 400))
    for k, borders in CONTINUOUS.items():
        for (a, _), (b, _), border in zip(coarse[k], fine[k], borders, strict=True):
            limit = (4 * b - a) / 3
            below, above = limit - 1e-5, limit + 1e-5
            y = peak(below, k), peak(above, k)
            exact = below + (1.0 - y[0]) / (y[1] - y[0]) * 2e-5
            assert abs(a - exact) > 1e-5
            assert abs(limit - exact) < 0.01 * abs(a - exact)
            assert 1 / exact == pytest.approx(border, abs=5e-5)


@pytest.mark.parametrize(
    ('values', 'between'),
    [
        ([1.0, 1.5, 2.0, 2.5], lambda i: 1.0 + 0.5 * i),
        ([0.5, 0.25, 0.125], lambda i: 0.5 * 2.0**-i),
        ([1 / (4 + 0.25 * i) for i in range(40)], lambda i: 1 / (4 + 0.25 * i)),
    ],
)
def test_values_between_those_of_a_grid(values, between):
    line, places = Line(values), np.linspace(0.0, len(values) - 1.0, 50)
    assert line.ordered
    np.testing.assert_allclose(line(np.arange(float(len(values)))), values, rtol=1e-14)
    np.testing.assert_allclose(line(places), between(places), rtol=2e-4)


@pytest.mark.slow
def test_a_list_of_values_may_be_uneven():
    """The border is the same, whatever grid it was found on."""
    quarters = ','.join(repr(1 / (6 + 0.25 * i)) for i in range(45))
    plan = Plan.of(load('exact'), [f'exosystem.tau:={{{quarters}}}', K], duration=600.0)
    border = find_border(plan, ('exosystem.tau', 'controller.k'))
    one, other = ends(border, follow(plan, border)), ends(*found()[1:])
    for k in BORDERS:
        tau = [[tau for tau, _ in each[k]] for each in (one, other)]
        np.testing.assert_allclose(*tau, rtol=1e-6)


@pytest.mark.slow
def test_what_is_left_of_the_start_moves_the_border_of_the_runs_and_not_the_curve():
    """An event soon after ``settle`` is the start's: the runs' border is on the rejected side."""
    early, late = found(settle=20.0)[2], found(settle=100.0)[2]
    assert min(piece.off.min() for piece in early.pieces) < -0.1
    assert late.missed == late.dropped == 0
    assert min(piece.off.min() for piece in late.pieces) > -1e-3
    places = np.vstack([piece.places for piece in late.pieces])
    for piece in early.pieces:
        near = np.abs(piece.places[:, None] - places).max(axis=2).min(axis=1)
        assert np.median(near) < 0.5


@pytest.mark.slow
def test_turning_the_axes_turns_the_curve():
    plan, border, followed = found()
    turned = follow(plan, border.turned)
    assert turned.points == followed.points > 20
    for one, other in zip(followed.pieces, turned.pieces, strict=True):
        assert np.array_equal(one.places, other.places[:, ::-1])
    assert max(followed.apart, turned.apart) < 0.75
    text = orbit_csv(border.turned, turned).splitlines()
    assert text[0] == 'curve,controller.k,exosystem.tau,off,within'
    assert len(text) == 1 + turned.points
    words = border_words(plan, border, followed)
    assert f'2 curves of {followed.points} points' in words
    assert 'undecided' not in words


@pytest.mark.slow
def test_what_runs_do_not_confirm_is_not_given_out(monkeypatch):
    """A follower that takes the peak for something else follows a curve, and runs refute it."""
    true = border_orbit.OnBorder
    monkeypatch.setattr(border_orbit, 'OnBorder', lambda orbit, value: true(orbit, value + 0.4))
    plan, border, followed = found()
    assert followed.pieces == []
    assert followed.dropped > 10
    assert followed.missed == sum(map(len, border.places))
    assert 'runs on both sides of it do not differ' in border_words(plan, border, followed)


@pytest.mark.slow
@pytest.mark.parametrize('verdict', VERDICTS)
def test_both_runs_have_to_say_so(monkeypatch, verdict):
    class OfOneMind(Sets):
        def run(self, columns, pool=None):
            found = super().run(columns, pool)
            found.rows['verdict'] = VERDICTS.index(verdict)
            return found

    plan, border, _ = found()
    monkeypatch.setattr(border_orbit, 'Sets', OfOneMind)
    followed = follow(plan, border)
    assert followed.pieces == []
    assert followed.dropped > 20


@pytest.mark.slow
def test_no_stretch_is_given_out_twice():
    """Two walks that differ where runs do not confirm them may be the same where they do."""
    ranges = ['/**.k:=0.5..3/21', 'controller.tau:=0.05..0.2/33']
    plan = Plan.of(load('exact'), ranges, duration=400.0)
    border = find_border(plan, ['/**.k', 'controller.tau'])
    followed = follow(plan, border)
    assert followed.missed == 0 < followed.dropped
    words = border_words(plan, border, followed)
    assert f'not everywhere: {followed.dropped} points of the curve are left out: ' in words
    starts = [tuple(piece.places[0].round(3)) for piece in followed.pieces]
    assert len(starts) == len(set(starts)) == 2


@pytest.mark.slow
def test_it_ends_when_its_time_is_over():
    plan, border, _ = found()
    followed = follow(plan, border, limit=0.0)
    assert (followed.points, followed.missed) == (0, sum(map(len, border.places)))
    assert followed.reason == 'it takes too long; give smaller ranges, or fewer values'


@pytest.mark.slow
def test_an_orbit_that_does_not_attract_is_not_followed(monkeypatch):
    monkeypatch.setattr(border_orbit.Orbit, 'attracts', property(lambda orbit: False))
    plan, border, followed = found()
    assert (followed.points, followed.reason) == (0, 'the orbit does not attract')
    assert 'not followed as a periodic orbit: the orbit' in border_words(plan, border, followed)


@pytest.mark.slow
def test_an_orbit_that_has_one_event_and_no_more_is_not_followed():
    border = found()[1]
    low = Plan.of(load('exact'), [TAU, K, 'spike_monitor.reset:=-3'], duration=600.0)
    followed = follow(low, border)
    assert (followed.points, followed.reason) == (0, 'y does not come down to the reset, -3')


@pytest.mark.parametrize(
    ('scenario', 'parameters', 'words'),
    [
        ('exact', ['plant.k:=1..2/5', 'links.delay:=0..1/5'], 'links.delay is not in the eq'),
        ('exact', ['plant.k:=1..2/5', 'plant.tau:=1..2/5', 'links.delay:=0.1'], 'impaired'),
        ('exact', ['plant.k:=1..2/5', 'plant.tau:=1..2/5', 'noise.y:=0.1'], 'noise'),
        ('exact', ['plant.k:=1..2/5', 'plant.x0[0]:=1..2/5'], 'plant.x0[0] is no parameter'),
        ('exact', ['plant.k:=1..2/5', '/**.rate:=50..60/5'], '/**.rate is no parameter'),
        ('exact', ['plant.k:=1..2/5', 'plant.tau:={1,2,5,4}'], 'plant.tau are in no order'),
        ('exact', ['plant.k:=1..2/5', 'plant.tau:=1..2/5', 'spike_monitor.min_width:=1'], 'min_'),
        ('open', ['plant.k:=1..2/5', 'plant.tau:=1..2/5'], 'an open input, v, drives it'),
        ('quiescent', ['plant.k:=1..2/5', 'plant.tau:=1..2/5'], 'there are 0 exosystems'),
        ('two_generators', ['plant.k:=1..2/5', 'plant.tau:=1..2/5'], 'there are 2 exosystems'),
        ('late', ['plant.k:=1..2/5', 'plant.tau:=1..2/5'], 'learns, predicts'),
    ],
)
def test_where_it_is_not_sound_it_says_why(scenario, parameters, words):
    assert words in border_orbit.unsound(Plan.of(load(scenario), parameters))


def test_where_there_is_no_numba(monkeypatch):
    monkeypatch.setattr('eventreg_ros.robustness.orbit_rules.compiles', lambda: False)
    plan = Plan.of(load('exact'), ['plant.k:=1..2/5', 'plant.tau:=1..2/5'])
    assert 'numba' in border_orbit.unsound(plan)


def unfit_rhs(x, drive, p):
    """The neuron, in a way that numba does not know."""
    found = dict(zip(('v', 'r'), neuron_rhs(x, drive, p), strict=True))
    return (found['v'], found['r'])


@pytest.mark.slow
def test_a_plant_of_another_package_that_numba_does_not_know(monkeypatch):
    own = replace(NEURON, name='own', rhs=unfit_rhs, x0=(0.0, 0.0))
    monkeypatch.setattr(catalogue, '_installed', lambda: {'own': Offer(lambda: own)})
    catalogue._plugged_in.cache_clear()
    pair = ['exosystem.tau:=1/20..1/12/9', 'controller.k:=0.7..1/9', 'plant.model:=own']
    plan = Plan.of(load('exact'), pair)
    line = np.column_stack([np.arange(9.0), np.linspace(8.0, 0.0, 9)])
    border = Border(('exosystem.tau', 'controller.k'), *(a.values for a in plan.axes), {}, [line])
    followed = follow(plan, border)
    catalogue._plugged_in.cache_clear()
    assert (followed.pieces, followed.missed) == ([], 9)
    assert followed.reason.startswith('a model fails')


@pytest.mark.slow
def test_numbers_of_another_kind_of_neuron():
    """Its parameters go through a function; those that others are computed from are refused."""
    pair = ['exosystem.k:=0.1..3/9', 'controller.k:=0.02..1/9']
    plan = Plan.of(load('morris_lecar'), pair)
    sets = Sets(plan)
    numbers = border_orbit.Numbers(sets, [Line(axis.values) for axis in plan.axes])
    given = numbers(np.array([[2.0, 8.0], [8.0, 2.5]]))
    specs = sets.scenario([0.825, 1.0]).loop.blocks.values()
    for of_block, spec in zip(given, specs, strict=True):
        np.testing.assert_allclose(of_block[0], tuple(spec.params), rtol=1e-15)
    plan = Plan.of(load('morris_lecar'), ['plant.current:=60..70/9', 'controller.k:=0.02..1/9'])
    with pytest.raises(border_orbit.EventregError, match='others are computed from'):
        border_orbit.Numbers(Sets(plan), [Line(axis.values) for axis in plan.axes])


def test_what_has_no_verdict_has_a_reason():
    plan = Plan.of(load('exact'), ['controller.k:=-2..-1/9', TAU, '/**.rate:=50'], duration=150.0)
    border = find_border(plan, ['exosystem.tau', 'controller.k'])
    assert border.bad == border.runs
    words = border_words(plan, border, border_orbit.Followed([]))
    assert 'the first without a verdict: controller.k must be a finite number >= 0, got' in words


@pytest.mark.slow
def test_undecided_runs_are_counted():
    """A generator that is too slow for three events within the run has no verdict."""
    ranges = ['exosystem.tau:=0.005..0.2/40', 'controller.k:=0.3..2/40', '/**.rate:=50']
    plan = Plan.of(load('exact'), ranges, duration=250.0)
    border = find_border(plan, ['exosystem.tau', 'controller.k'])
    places = np.array(list(border.known)).T
    columns = [axis.nth(at) for axis, at in zip(plan.axes, places, strict=True)]
    verdicts = Sets(plan).run(columns).rows['verdict']
    assert border.undecided == (verdicts == 3).sum() > 0
    assert border.bad == (verdicts == 0).sum() == 0
    words = border_words(plan, border, border_orbit.Followed([], reason='R'))
    assert f'{border.undecided} of the runs undecided and 0 without a verdict' in words
