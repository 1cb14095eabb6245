# SPDX-License-Identifier: Apache-2.0
"""Figures of event trains: by hand, against elephant, and for trains whose statistics are known."""

import math
import random

import numpy as np
import pytest

from eventreg_ros.analysis.trains import (
    Burst,
    bursts,
    coincidence,
    cv2,
    describe,
    lv,
    phase,
    settling_time,
)


def train(seed, n):
    draw = random.Random(seed)
    return sorted(round(draw.uniform(0.0, 100.0), 3) for _ in range(n))


# One train ----------------------------------------------------------------------------------------

# elephant 1.2.1, statistics.cv, cv2 and lv of the intervals of train(seed, n).
ELEPHANT = {
    (1, 4): (0.8087383311839093, 1.3339710717297326, 1.3422753554625015),
    (3, 40): (0.7426740514353366, 1.0845490098883117, 1.104310339981189),
    (9, 200): (0.9783860172535405, 1.044630875008981, 1.0676973014126505),
}


@pytest.mark.parametrize('which', ELEPHANT)
def test_elephant_agrees(which):
    found = describe(train(*which), 0.0, 100.0)
    assert (found.cv, found.cv2, found.lv) == pytest.approx(ELEPHANT[which], rel=1e-12)


def test_the_figures_by_hand():
    found = describe([5.0, 15.0, 20.0, 50.0, 99.0], 10.0, 60.0, [1.0, 2.0, 3.0, 7.0, 8.0])
    assert found.count == 3  # 15, 20, 50
    assert found.rate == 3 / 50.0
    assert (found.interval_mean, found.interval_min, found.interval_max) == (17.5, 5.0, 30.0)
    assert found.cv == pytest.approx(12.5 / 17.5)
    assert found.cv2 == pytest.approx(2.0 * 25.0 / 35.0)
    assert found.lv == pytest.approx(3.0 * (25.0 / 35.0) ** 2)
    assert found.width_median == 3.0
    assert found.bursts == ()


def test_both_ends_of_the_span_belong_to_it():
    assert describe([10.0, 60.0], 10.0, 60.0).count == 2


def test_a_clock_does_not_vary():
    found = describe(np.arange(0.0, 100.0, 4.0), 0.0, 100.0)
    assert (found.cv, found.cv2, found.lv) == (0.0, 0.0, 0.0)
    assert (found.rate, found.bursts) == (0.25, ())


def test_a_poisson_process_has_1_everywhere():
    n = 100_000
    t = np.cumsum(np.random.default_rng(1).exponential(2.0, n))
    found = describe(t, 0.0, float(t[-1]))
    # Standard errors: of cv 1 / sqrt(n), of the others below 2 / sqrt(n).
    assert (found.cv, found.cv2, found.lv) == pytest.approx((1.0, 1.0, 1.0), abs=6 / math.sqrt(n))
    assert found.rate == pytest.approx(0.5, rel=3 / math.sqrt(n))


def test_a_slow_change_of_the_rate_moves_cv_alone():
    intervals = np.geomspace(1.0, 100.0, 2001)
    assert describe(np.cumsum(intervals), 0.0, 1e6).cv > 0.9
    assert cv2(intervals) < 0.01
    assert lv(intervals) < 0.01


def test_too_few_events_define_nothing():
    empty, one, two = (describe([1.0, 2.0][:n], 0.0, 10.0) for n in range(3))
    assert (empty.count, empty.rate, empty.interval_mean, empty.width_median) == (
        0,
        0.0,
        None,
        None,
    )
    assert (one.rate, one.interval_mean, one.cv) == (0.1, None, None)
    assert (two.interval_mean, two.cv, two.cv2, two.lv) == (1.0, None, None, None)
    assert describe([], 5.0, 5.0).rate is None
    assert describe([3.0, 3.0, 3.0], 0.0, 10.0).cv is None  # a mean interval of 0
    assert describe([3.0, 3.0, 3.0], 0.0, 10.0).lv is None


def test_bursts():
    t = [0.0, 1.0, 2.0, 50.0, 100.0, 101.0, 150.0, 151.0, 151.5, 152.5]
    assert bursts(t, 1.0) == (Burst(0.0, 2.0, 3), Burst(150.0, 152.5, 4))
    assert bursts(t, 1.0, least=2) == (
        Burst(0.0, 2.0, 3), Burst(100.0, 101.0, 2), Burst(150.0, 152.5, 4),
    )  # fmt: skip
    assert bursts(t, 0.9) == ()
    assert bursts(t) == bursts(t, 0.25 * np.diff(t).mean()) == bursts(t, 1.0)
    assert bursts([]) == bursts([1.0]) == ()


# Two trains ---------------------------------------------------------------------------------------


def test_coincidence():
    found = coincidence([10.2, 19.5, 31.0, 70.0], [10.0, 20.0, 30.0, 40.0, 50.0], 2.0)
    assert (found.matched, found.precision, found.recall) == (3, 0.75, 0.6)
    assert found.latency == pytest.approx((0.2, -0.5, 1.0))
    assert found.latency_median == pytest.approx(0.2)


def test_coincidence_with_nothing():
    found = coincidence([], [1.0])
    assert (found.precision, found.recall, found.latency_median) == (None, 0.0, None)
    found = coincidence([1.0], [])
    assert (found.precision, found.recall) == (0.0, None)


def test_a_train_late_by_a_part_of_each_interval_has_that_phase():
    beats = np.cumsum([0.0, 8.0, 12.0, 10.0, 20.0, 6.0])
    for part in (-0.4, -0.25, 0.0, 0.1, 0.5):
        late = beats[:-1] + (part % 1.0) * np.diff(beats)
        found = phase(late, beats)
        assert found.t.tolist() == late.tolist()
        assert found.cycles == pytest.approx(part, abs=1e-12)
        assert found.locking == pytest.approx(1.0)
        assert abs(found.mean) == pytest.approx(abs(part), abs=1e-12)


def test_a_drifting_phase_turns_evenly_and_is_not_locked():
    beats = np.arange(0.0, 1001.0, 10.0)
    t = np.arange(0.0, 1000.0, 10.1)  # a hundredth of a cycle later each time
    found = phase(t, beats)
    turned = np.diff(found.cycles) % 1.0
    assert turned == pytest.approx(0.01, abs=1e-9)
    assert found.locking < 0.02  # a whole turn except one step


def test_only_events_between_two_beats_have_a_phase():
    found = phase([0.5, 1.0, 2.5, 3.0, 4.0], [1.0, 2.0, 3.0])
    assert found.t.tolist() == [1.0, 2.5]
    assert found.cycles.tolist() == [0.0, 0.5]
    assert phase([5.0], [1.0]).locking is phase([], [1.0, 2.0]).mean is None


def test_settling_time():
    w = [10.0, 20.0, 30.0, 40.0, 50.0]
    assert settling_time([5.0, 15.0], w) == 15.0
    assert settling_time([], w) == 0.0
    assert settling_time([20.0], w) == 20.0  # 30, 40 and 50 come after it
    assert settling_time([25.0, 30.0], w) is None
    assert settling_time([], w[:2]) is None
    assert settling_time([30.0], w, enough=2) == 30.0
