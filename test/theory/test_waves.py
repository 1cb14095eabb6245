# SPDX-License-Identifier: Apache-2.0
"""Periods and peaks of waves that are known."""

import numpy as np
import pytest

from eventreg_ros.theory.waves import OrbitError, last_rise, peak_of


def test_the_peak_of_a_wave_is_found_between_its_samples():
    for shift in (*np.linspace(0.0, 1.0, 7), 49.6, 50.4):  # also where a period ends
        wave = np.sin(2 * np.pi * (np.arange(200) + shift) / 200)
        found, places, weights = peak_of(wave)
        assert found == pytest.approx(1.0, abs=1e-9)
        assert found == weights @ wave[places]


def test_the_period_of_a_wave_may_have_several_rises():
    t = np.arange(5000.0)
    once, twice = np.sin(2 * np.pi * t / 333.3), 0.5 * np.sin(2 * np.pi * t / 1111.1)
    assert last_rise(once)[1] == pytest.approx(333.3, rel=1e-4)
    assert last_rise(np.sin(2 * np.pi * t / 300) + 0.7 * np.sin(1 + np.pi * t / 300))[1] == (
        pytest.approx(600.0, rel=1e-4)
    )
    with pytest.raises(OrbitError, match='not periodic'):
        last_rise(once + np.sin(t**2 / 1e6) + twice)
