# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from eventreg_ros.simulation.hold import HORIZON, drive, drives, horizon_in_steps, line


@pytest.mark.parametrize('age', [-0.5, 0.0, 1.0, 2.5])
@pytest.mark.parametrize('gap', [0.5, 1.0, 3.0])
def test_a_line_goes_through_both_samples(age, gap):
    base, slope = line(0.7, 0.6, age, gap, 4.0)
    assert base + -age * slope == pytest.approx(0.7, abs=1e-15)
    assert base + (-age - gap) * slope == pytest.approx(0.6, abs=1e-15)


def test_zero_holds_the_newest():
    assert line(0.7, 0.4, 2.0, 1.0, 0.0) == (0.7, 0.0)


@pytest.mark.parametrize(('age', 'gap'), [(4.1, 1.0), (0.0, 4.1)])
def test_beyond_the_horizon_and_after_a_gap_it_holds(age, gap):
    assert line(0.7, 0.4, age, gap, 4.0) == (0.7, 0.0)


def test_the_first_sample_passed_twice_is_held():
    assert line(0.7, 0.7, 0.0, 1.0, 4.0) == (0.7, 0.0)


@pytest.mark.parametrize('theta', [0.0, 0.5, 1.0])
def test_drive_is_the_signed_sum_along_the_step(theta):
    sign, base, slope = (1.0, 1.0, -1.0), (0.5, 0.25, 2.0), (1.0, 0.0, -4.0)
    assert drive(sign, base, slope, theta) == 0.5 + theta + 0.25 - 2.0 + 4.0 * theta


def test_no_input_drives_nothing():
    assert drive((), (), (), 0.5) == 0.0


@pytest.mark.parametrize('h', [0.01, 0.05, 0.4])
def test_the_horizon_is_a_model_time(h):
    bridged = round(HORIZON / h)
    assert line(0.7, 0.69, float(bridged), 1.0, horizon_in_steps('linear', h))[1] != 0.0
    assert line(0.7, 0.69, bridged + 1.0, 1.0, horizon_in_steps('linear', h))[1] == 0.0


def test_a_step_longer_than_the_horizon_is_still_bridged():
    assert line(0.7, 0.4, 0.0, 1.0, horizon_in_steps('linear', 2.0 * HORIZON))[1] != 0.0


def test_the_zero_hold_has_no_horizon():
    assert horizon_in_steps('zero', 0.01) == 0.0


def test_a_late_jump_is_held_and_a_punctual_one_drawn_on():
    assert line(0.0, -1.9, 1.0, 1.0, 8.0) == (0.0, 0.0)
    assert line(0.0, -1.9, 0.0, 1.0, 8.0) == (0.0, 1.9)
    assert line(0.1, 0.05, 6.0, 1.0, 8.0) == (pytest.approx(0.4), pytest.approx(0.05))


def test_drives_are_the_drive_at_start_middle_and_end():
    rng = np.random.default_rng(4)
    for inputs in range(4):
        sign = rng.choice([-1.0, 1.0], inputs).tolist()
        base, slope = rng.normal(size=(2, inputs)).tolist()
        expected = tuple(drive(sign, base, slope, theta) for theta in (0.0, 0.5, 1.0))
        assert drives(sign, base, slope) == expected
