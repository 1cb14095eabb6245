# SPDX-License-Identifier: Apache-2.0
"""The timing of recorded signals, from stamps in nanoseconds."""

import numpy as np
import pytest

from eventreg_ros.analysis.timing import timing

KEYS = ['rate', 'period_p50', 'period_p99', 'period_max', 'gaps']  # as the contract lists them


def grid(n, period=5_000_000, start=1_795_304_457_727_915_003):
    return start + period * np.arange(n, dtype=np.int64)


def test_an_even_signal():
    result = timing(grid(2001))
    assert list(result._fields) == KEYS
    assert result.rate == pytest.approx(200.0, rel=1e-12)
    for key in ('period_p50', 'period_p99', 'period_max'):
        assert getattr(result, key) == pytest.approx(5e-3, rel=1e-9)
    assert result.gaps == 0
    assert {type(value) for value in result} == {float, int}


def test_percentiles_of_known_periods():
    stamps = np.cumsum(np.arange(0, 102)).astype(np.int64) * 1_000_000  # periods 1, 2, ..., 101 ms
    result = timing(stamps)
    assert result.period_p50 == pytest.approx(51e-3)
    assert result.period_p99 == pytest.approx(100e-3)
    assert result.period_max == pytest.approx(101e-3)
    assert result.rate == pytest.approx(101 / 5.151)


@pytest.mark.parametrize('n', [0, 1])
def test_too_few_samples_for_a_period(n):
    assert timing(grid(n)) == (None, None, None, None, 0)


def test_all_at_once():
    result = timing(np.array([7, 7, 7], dtype=np.int64))
    assert (result.rate, result.period_max, result.gaps) == (None, 0.0, 0)


def test_each_run_of_missing_samples_is_one_gap():
    stamps = grid(1000)
    for missing, gaps in (
        ([500], 1),
        ([500, 501, 502], 1),
        ([500, 700], 2),
        ([500, 502], 2),
        ([998], 1),
        ([0], 0),  # nothing shows that the signal should have begun earlier
        ([999], 0),
    ):
        assert timing(np.delete(stamps, missing)).gaps == gaps


def test_a_late_sample_is_no_gap():
    stamps = grid(1000)
    for late in (1_000_000, 2_600_000, 4_900_000):
        shifted = stamps.copy()
        shifted[[100, 400, 999]] += late
        assert timing(shifted).gaps == 0


def test_missing_samples_are_found_among_late_ones():
    rng = np.random.default_rng(6)
    for _ in range(50):
        stamps = grid(2000) + (rng.exponential(0.25, 2000).clip(0, 1.5) * 1e6).astype(np.int64)
        missing = 7 + 20 * rng.choice(90, 12, replace=False)
        assert timing(np.delete(stamps, missing)).gaps == 12
        assert timing(stamps).gaps == 0
