# SPDX-License-Identifier: Apache-2.0
"""Axes: round ticks, scales that outliers do not squeeze, labels as people write them."""

import numpy as np
import pytest

from eventreg_ros.plots.axis import Axis, around, decades, label, power, round_step, ticks


@pytest.mark.parametrize('seed', range(40))
def test_ticks_are_round_evenly_spaced_and_few(seed):
    draw = np.random.default_rng(seed)
    length = 10.0 ** draw.uniform(-6, 6)
    low, most = draw.uniform(-3.0, 3.0) * length, int(draw.integers(2, 10))
    found = [value for value, _ in ticks(low, low + length, most)]
    step = round_step(length / most)
    assert 1 <= len(found) <= most + 1 or step > length
    assert all(low - 1e-6 * step <= t <= low + length + 1e-6 * step for t in found)
    assert np.allclose(np.diff(found), step)
    assert float(f'{step:.0e}') == pytest.approx(step)
    assert round(step / 10 ** np.floor(np.log10(step) + 1e-9)) in (1, 2, 5)


@pytest.mark.parametrize(
    ('value', 'step', 'words'),
    [
        (0.0, 50.0, '0'), (0.0, 0.01, '0'), (150.0, 50.0, '150'), (-2.0, 1.0, '\u22122'),
        (0.5, 0.5, '0.5'), (1.0, 0.5, '1.0'), (2e5, 1e5, '2e5'), (-1e-4, 1e-4, '\u22121e\u22124'),
        (36000.0, 1000.0, '36000'),
    ],
)  # fmt: skip
def test_labels(value, step, words):
    assert label(value, step) == words


def test_powers_of_ten():
    assert [power(n) for n in (-12, -4, -2, 0, 3, 4)] == [
        '10⁻¹²',
        '10⁻⁴',
        '0.01',
        '1',
        '1000',
        '10⁴',
    ]
    assert [words for _, words in Axis(-6.3, 1.0, True).ticks(4)] == ['10⁻⁶', '10⁻⁴', '0.01', '1']


def test_an_axis_shows_everything_but_what_is_far_off_all_others():
    x = np.sin(np.arange(4000) / 50.0)
    assert around([x]) == pytest.approx((-1.1, 1.1, False), abs=1e-3)
    spike = x.copy()
    spike[1000:1040] = 2.5  # one in a hundred: a spike, not an outlier
    assert around([spike]).high > 2.5
    for wild in (1e7, 1e306, np.inf, np.nan):
        spike[77] = wild
        assert around([spike]).high < 2.8
    assert around([x], (-3.0, 1.0)).low < -3.0


@pytest.mark.parametrize('samples', [[], [np.empty(0)], [np.full(9, np.nan)], [np.full(5, 7.0)]])
def test_an_axis_has_a_range_whatever_there_is(samples):
    axis = around(samples)
    assert np.isfinite(axis.low)
    assert axis.low < axis.high
    axis, logs = decades(np.concatenate([np.empty(0), *samples]), 1e-16)
    assert axis.low < axis.high
    assert len(logs) == sum(map(len, samples))


def test_a_single_spike_of_a_quiet_signal_is_on_the_scale():
    x = np.zeros(100_000)
    x[5000:5005] = 2.0  # fewer than one sample in a thousand
    assert around([x], (-1.0, 2.0)).high > 2.0
    assert around([x]).high > 2.0


def test_magnitudes_that_pass_through_zero():
    x = np.abs(np.sin(np.arange(10_000) / 100.0))
    axis, logs = decades(np.append(x, 1e9), 1e-16)
    assert -3.5 < axis.low < -1.0
    assert 0.5 <= axis.high <= 1.5
    assert logs[0] == -16.0
