# SPDX-License-Identifier: Apache-2.0
"""Noise: found where it is and nowhere else, counted by hand, and gone with what is advised."""

import math

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.events import detect
from eventreg_ros.analysis.noise import examine, noise_level, table, words
from eventreg_ros.analysis.trains import coincidence
from eventreg_ros.scenario.criteria import Criteria

T = np.arange(8001) * 0.05


@pytest.fixture(scope='module')
def loops():
    return {name: simulate(name, 400.0, sampled=True) for name in ('exact', 'uncontrolled')}


def white(sd, seed):
    return np.random.default_rng(seed).normal(0.0, sd, len(T))


# What is counted ----------------------------------------------------------------------------------


def test_crossings_and_widths_by_hand():
    #    up at 0.5  down 2.5     up 4.5  up 6.5   down 8.25
    x = [0.0, 2.0, 0.5, -0.5, 0.0, 2.0, 0.5, 1.5, 0.5, -1.5]
    noise = examine(np.arange(10.0), np.array(x))
    assert (noise.crossings, noise.recrossings, noise.events) == (3, 1, 2)
    assert noise.scale == math.log2(10) + 2
    assert noise.short == 2
    widths = noise.widths
    assert (widths.count, widths.least, widths.median, widths.largest) == (2, 2.0, 2.875, 3.75)


def test_samples_that_are_not_finite_are_passed_over():
    x = np.sin(T) + white(0.3, 1)
    holes = x.copy()
    holes[::7] = np.nan
    kept = np.isfinite(holes)
    assert examine(T, holes) == examine(T[kept], x[kept])


@pytest.mark.parametrize('n', [0, 1, 9])
def test_too_few_samples_say_nothing(n):
    noise = examine(T[:n], np.zeros(n))
    assert (noise.sd, noise.noisy, noise.suggestion, noise.widths.least) == (
        None,
        False,
        None,
        None,
    )
    assert words('y', noise) == ''


def test_huge_values_overflow_quietly():
    x = np.where(np.arange(200) % 2 == 0, 1e308, -1e308)
    assert examine(T[:200], x).sd is None
    spiked = white(0.3, 2)
    spiked[::100] = 1e308
    assert examine(T, spiked).sd == pytest.approx(0.3, rel=0.05)
    assert words('y', examine(T, spiked)) == ''  # not what white noise of that size does


# How much noise there is --------------------------------------------------------------------------


@pytest.mark.parametrize('sd', [0.1, 0.3, 0.6])
def test_the_level_is_that_of_the_noise(loops, sd):
    # The median of |d|, d of n normal second differences, has a standard error below 2 % here.
    for run in loops.values():
        found = [noise_level(run['y'] + white(sd, seed)) for seed in range(10)]
        assert np.mean(found) == pytest.approx(sd, rel=0.02)


def test_white_noise_at_rest_seldom_outlasts_its_scale():
    # At reset half of the samples end a rise: less than one run in four should have a longer one.
    runs = [examine(T, white(0.6, seed)) for seed in range(40)]
    assert sum(run.short < run.widths.count for run in runs) <= 10
    assert max(run.widths.largest for run in runs) > 0.5 * runs[0].scale  # and the scale is no more


# Whether it matters -------------------------------------------------------------------------------


@pytest.mark.parametrize('name', ['exact', 'uncontrolled', 'open', 'linear', 'single_neuron'])
def test_a_clean_signal_is_not_noisy_at_any_rate(name):
    run = simulate(name, 400.0, sampled=True)
    for x in run.signals.values():
        for every in (1, 10, 40, 100, 150):
            assert not examine(run.t[::every], x[::every]).noisy


def test_noise_that_reset_keeps_out_needs_nothing(loops):
    y = loops['uncontrolled']['y'] + white(0.1, 3)
    noise = examine(T, y)
    assert noise.noisy
    assert noise.recrossings > 50
    assert noise.suggestion is None
    assert words('y', noise).endswith('no event depends on it')


@pytest.mark.parametrize('name', ['exact', 'uncontrolled'])
@pytest.mark.parametrize('sd', [0.4, 0.6])
def test_the_advice_leaves_the_events_of_the_clean_signal(loops, name, sd):
    clean = loops[name]['y']
    truth = detect(T, clean)
    for seed in range(5):
        noisy = clean + white(sd, seed)
        before = detect(T, noisy)
        assert len(before) - coincidence(before, truth).matched > 10
        noise = examine(T, noisy)
        after = detect(T, noisy, *noise.suggestion.criteria.detector)
        assert len(after) == len(truth) == coincidence(after, truth).matched
        assert noise.suggestion.events == len(after)
        first, second = words('y', noise).splitlines()
        assert f'{len(before)} events, {len(truth)} with min_width' in first
        assert second.startswith('  because noise alone lasts up to 0.75; ')
        assert table({'w': (T, clean), 'y': (T, noisy)}) == words('y', noise)


def test_the_advice_lies_between_noise_and_spikes(loops):
    noise = examine(T, loops['uncontrolled']['y'] + white(0.5, 4))
    limits = noise.suggestion.criteria
    # The clean spikes are 17.79 wide, the first two of them 33.26 apart, the others 37.55.
    assert noise.scale < limits.min_width < 17.79 / 2.0
    assert limits.refractory == pytest.approx(33.26 / 2.0, rel=0.05)
    assert limits.reset > -1.89  # it falls as low after each spike
    assert any('min_width' in reason for reason in noise.suggestion.reasons)
    assert any('refractory' in reason for reason in noise.suggestion.reasons)


def test_a_reset_too_close_to_the_threshold_is_lowered(loops):
    clean = loops['uncontrolled']['y']
    noisy = clean + white(0.3, 5)
    noise = examine(T, noisy, Criteria(reset=0.9))
    assert noise.suggestion.criteria.reset < 0.9 - 0.3
    assert any('reset' in reason for reason in noise.suggestion.reasons)
    after = detect(T, noisy, *noise.suggestion.criteria.detector)
    assert coincidence(after, detect(T, clean)).matched == len(after) == 11
