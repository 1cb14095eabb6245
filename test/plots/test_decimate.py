# SPDX-License-Identifier: Apache-2.0
"""Signals as lines: broken in gaps, thinned without losing a spike."""

import numpy as np
import pytest

from eventreg_ros.plots.decimate import broken, min_max_decimate


def test_short_signals_are_drawn_as_they_are():
    t = np.arange(1000.0)
    x = np.sin(t)
    assert [a.tolist() for a in min_max_decimate(t, x)] == [t.tolist(), x.tolist()]
    for n in (0, 1, 2):
        assert [len(a) for a in min_max_decimate(*broken(t[:n], x[:n]))] == [n, n]


def test_thinning_keeps_every_extreme_and_the_order():
    rng = np.random.default_rng(9)
    t = np.cumsum(rng.uniform(0.5, 1.5, 100_003))
    x = rng.normal(0.0, 1.0, len(t))
    spikes = rng.choice(len(t), 50, replace=False)
    x[spikes] = np.where(rng.random(50) < 0.5, 50.0, -50.0) + rng.random(50)
    kept_t, kept_x = min_max_decimate(t, x, 500)
    assert len(kept_t) <= 4 * 500 + 500
    assert np.all(np.diff(kept_t) > 0.0)
    points = set(zip(t.tolist(), x.tolist(), strict=True))
    assert points >= set(zip(kept_t.tolist(), kept_x.tolist(), strict=True))
    for part in range(500):
        inside = slice(200 * part, 200 * (part + 1))
        shown = kept_x[(kept_t >= t[inside][0]) & (kept_t <= t[inside][-1])]
        assert (shown.min(), shown.max()) == (x[inside].min(), x[inside].max())
    assert (kept_t[0], kept_t[-1]) == (t[0], t[-1])


def test_thinning_keeps_gaps():
    t = np.arange(20_000.0)
    x = np.ones(len(t))
    x[[3000, 7777, 12345]] = np.nan
    x[15000:16000] = np.nan
    kept_t, kept_x = min_max_decimate(t, x, 1000)
    gaps = kept_t[np.isnan(kept_x)]
    assert set(gaps[:3]) == {3000.0, 7777.0, 12345.0}
    assert (gaps[3], gaps[-1] - gaps[3]) == (15000.0, pytest.approx(1000.0, abs=20.0))


def test_a_line_is_broken_where_nothing_came():
    t = np.concatenate([np.arange(0.0, 50.0), np.arange(80.0, 100.0)])
    broken_t, broken_x = broken(t, np.ones(len(t)))
    assert broken_t[np.isnan(broken_x)].tolist() == [80.0]
    assert broken_t[~np.isnan(broken_x)].tolist() == t.tolist()
    late = np.concatenate([np.arange(0.0, 50.0), np.arange(55.0, 70.0)])
    assert not np.isnan(broken(late, np.ones(len(late)))[1]).any()


def test_values_that_cannot_be_drawn_break_the_line():
    x = np.array([0.0, np.inf, 1.0, -np.inf, np.nan, 1e308])
    t = np.arange(6.0)
    assert np.isnan(broken(t, x)[1]).tolist() == [False, True, False, True, True, True]
