# SPDX-License-Identifier: Apache-2.0
"""Samples by time stamp: which one a step uses, and what is counted."""

import math

import pytest

from eventreg_ros.runtime.duration_histogram import DurationHistogram
from eventreg_ros.runtime.stamped_input import CLOSEST, StampedInput
from eventreg_ros.runtime.tick_grid import SECOND, TickGrid

PERIOD = 5_000_000
TIMEOUT = 0.5 * SECOND


def samples(*pairs):
    found = StampedInput()
    for stamp, value in pairs:
        found.push(round(stamp * PERIOD), value)
    return found


def over(found, n, horizon=8.0):
    return found.over(n * PERIOD, float(PERIOD), TIMEOUT, horizon)


def test_peers_on_the_grid_give_the_line_of_lockstep_when_they_are_a_little_late():
    found = samples((3.0, 0.2), (4.2, 0.5), (5.1, 4.5))
    assert over(found, 4) == (0.5, 0.5 - 0.2)


def test_a_sample_of_the_next_instant_waits_for_the_next_step():
    found = samples((3.02, 0.2), (4.02, 0.5), (5.02, 4.5))
    assert over(found, 4, 0.0) == (0.5, 0.0)
    assert over(found, 5, 0.0) == (4.5, 0.0)


def test_a_late_sample_is_drawn_on_to_the_instant_that_needs_it():
    found = samples((1.0, 0.2), (2.0, 0.3))
    base, slope = over(found, 4)
    assert (base, slope) == (pytest.approx(0.5), pytest.approx(0.1))


def test_no_sample_and_a_silent_input():
    assert over(StampedInput(), 4) is None
    assert over(samples((0.0, 1.0)), 99, 0.0) == (1.0, 0.0)
    assert over(samples((0.0, 1.0)), 101, 0.0) is None


def test_samples_too_close_together_make_no_line():
    found = samples((4.3, 1.0), (4.3 + CLOSEST / 2, -1.0))
    assert over(found, 4)[1] == 0.0


def test_what_is_counted():
    found = StampedInput()
    assert found.push(10, 1.0, 0)
    assert not found.push(10, 1.0, 0), 'twice'
    assert not found.push(9, 1.0, 1), 'overtaken'
    assert not found.push(20, math.nan, 2)
    assert found.push(30, 2.0, 5)
    assert (found.received, found.out_of_order, found.dropped.not_finite, found.lost) == (
        2,
        2,
        1,
        2,
    )


def test_gaps_are_intervals_of_almost_two_periods():
    found = samples(*((n, 0.0) for n in range(10)), *((n, 0.0) for n in range(11, 20)))
    assert found.gaps == 1


def test_a_period_learnt_wrong_is_learnt_anew():
    # the first interval was short; then the writer came back at half the rate
    found = samples(*((n, 0.0) for n in (0.8, 1, *range(2, 200))))
    assert found.gaps == 0
    for n in range(200, 2000, 2):
        found.push(n * PERIOD, 0.0)
    assert 1 <= found.gaps < 100


def test_jitter_is_the_distance_from_the_usual_interval():
    found = samples(*((n + 0.1 * (n % 2), 0.0) for n in range(100)))
    assert found.jitter.percentile(50) == pytest.approx(0.1 * PERIOD / SECOND, rel=0.1)


def test_losses_are_those_of_one_writer():
    found = StampedInput()
    numbers = [*range(100, 200), *range(0, 50, 2), *range(5000, 5010), 5012]
    for n, number in enumerate(numbers):
        found.push(n * PERIOD if number != 5012 else (n + 2) * PERIOD, 0.0, number)
    # the second writer's every other sample was lost, the third one had sent 5000 before we came
    assert found.lost == 24 + 2


def test_a_clock_that_went_back_starts_afresh():
    found = StampedInput()
    found.push(100 * SECOND, 1.0)
    assert found.push(10 * SECOND, 2.0)
    assert found.over(10 * SECOND, float(PERIOD), TIMEOUT, 0.0) == (2.0, 0.0)


@pytest.mark.parametrize('rate', [200.0, 1000.0, 300.0, 1500.0, 7.3, 0.5])
def test_the_grid_neither_drifts_nor_loses_an_instant(rate):
    grid = TickGrid(rate)
    start = grid.after(1_790_000_000 * SECOND)
    for k in range(start, start + 1000):
        assert grid.index(grid.stamp(k)) == k
        assert grid.index(grid.stamp(k) - 1) == k - 1
        assert grid.stamp(k) == pytest.approx(k * SECOND / rate, rel=1e-15, abs=1.0)


def test_a_tally_is_right_to_five_per_cent():
    tally = DurationHistogram()
    for n in range(1, 10001):
        tally.add(n * 1e-6)
    assert tally.percentile(50) == pytest.approx(5e-3, rel=0.05)
    assert tally.percentile(99) == pytest.approx(9.9e-3, rel=0.05)
    assert tally.largest == 1e-2
    assert tally.take_recent() == 1e-2
    assert tally.take_recent() == 0.0
