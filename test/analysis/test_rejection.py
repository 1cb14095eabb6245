# SPDX-License-Identifier: Apache-2.0
"""Matching, counting, and the verdict that follows."""

import itertools
import random

import pytest

from eventreg_ros.analysis.rejection import ENOUGH, Outcomes, Rejection, match, outcomes, reject

THREE = [200.0, 240.0, 280.0]


# Matching ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('a', 'b', 'pairs'),
    [
        ([], [], []),
        ([1.0], [], []),
        ([1.0], [1.0], [(0, 0)]),
        ([0.0, 1.0], [0.5], [(0, 0)]),  # one to one: the other stays alone
        ([0.5], [0.0, 1.0], [(0, 0)]),
        ([0.0, 2.0], [1.5, 3.5], [(0, 0), (1, 1)]),  # nearest first would find one pair
        ([0.0, 10.0, 20.0], [10.5], [(1, 0)]),
        ([10.5], [0.0, 10.0, 20.0], [(0, 1)]),
    ],
)
def test_match(a, b, pairs):
    assert match(a, b, 2.0) == pairs


def test_the_window_is_closed():
    assert match([100.0], [105.0], 5.0) == [(0, 0)]
    assert match([105.0], [100.0], 5.0) == [(0, 0)]
    assert match([100.0], [105.000001], 5.0) == []
    assert match([105.000001], [100.0], 5.0) == []
    assert match([1.0], [1.0], 0.0) == [(0, 0)]


def most_pairs(a, b, window):
    """Try every way of pairing."""
    if len(a) > len(b):
        a, b = b, a
    return max(
        sum(abs(x - y) <= window for x, y in zip(a, chosen, strict=True))
        for chosen in itertools.permutations(b, len(a))
    )


def test_match_finds_as_many_pairs_as_there_can_be():
    rng = random.Random(4)
    for _ in range(400):
        a, b = (sorted(rng.uniform(0.0, 12.0) for _ in range(rng.randint(0, 5))) for _ in 'ab')
        window = rng.choice([0.3, 1.0, 2.5, 6.0])
        pairs = match(a, b, window)
        assert len(pairs) == most_pairs(a, b, window)
        assert all(abs(a[i] - b[j]) <= window for i, j in pairs)
        for side in (0, 1):  # one to one
            used = [pair[side] for pair in pairs]
            assert used == sorted(set(used))


# Counting ---------------------------------------------------------------------------------------


def test_what_is_counted():
    rejection = reject(THREE, [150.0, 200.0, 300.0], [151.0, 250.0], settle=100.0, window=5.0)
    assert rejection == Rejection(
        disturbance_events=3, reference_events=2, preserved=1, spurious=2, missed=1
    )
    assert rejection.ratio == pytest.approx(1 / 3)
    assert outcomes([150.0, 200.0, 300.0], [151.0, 250.0], 100.0, 5.0) == (
        Outcomes(preserved=[150.0], spurious=[200.0, 300.0], missed=[250.0])
    )


def test_every_event_is_counted_once():
    rng = random.Random(5)
    for _ in range(200):
        w, y, y_r = (sorted(rng.uniform(0, 50) for _ in range(rng.randint(0, 9))) for _ in 'wyr')
        settle, window = rng.uniform(0, 30), rng.uniform(0, 5)
        rejection, found = reject(w, y, y_r, settle, window), outcomes(y, y_r, settle, window)
        late = [[t for t in times if t >= settle] for times in (w, y, y_r)]
        assert rejection.disturbance_events == len(late[0])
        assert rejection.preserved + rejection.spurious == len(late[1])
        assert rejection.preserved + rejection.missed == len(late[2])
        assert sorted(found.preserved + found.spurious) == late[1]
        assert len(found.missed) == rejection.missed


def test_without_a_reference_every_event_is_spurious():
    assert reject(THREE, THREE, []).spurious == 3
    assert reject(THREE, THREE, []).preserved == 0


def test_settling_ends_with_an_event_that_counts():
    assert reject([99.999, 100.0], [], [], settle=100.0).disturbance_events == 1
    assert reject([], [100.0], [], settle=100.0).spurious == 1
    assert reject([], [99.999], [], settle=100.0).spurious == 0


def test_an_event_before_settling_answers_none_after_it():
    assert reject([], [99.0], [101.0], settle=100.0).missed == 1
    assert reject([], [101.0], [99.0], settle=100.0).spurious == 1


def test_equal_times_are_two_events():
    assert outcomes([200.0, 200.0], [200.0]) == Outcomes([200.0], [200.0], [])
    assert reject([], [200.0, 200.0], [200.0]).spurious == 1


def test_the_contracts_defaults():
    w, y = [100.0, 150.0, 200.0], [120.0]
    assert reject([99.0, *w], y, [125.0]) == reject(w, y, [125.0], settle=100.0, window=5.0)
    assert reject(w, y, [125.0]).preserved == 1
    assert reject(w, y, [125.1]).preserved == 0


# The verdict ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('disturbance', 'spurious', 'missed', 'verdict'),
    [
        (3, 0, 0, 'rejected'),
        (3, 1, 0, 'not rejected'),
        (3, 0, 1, 'not rejected'),
        (3, 1, 1, 'not rejected'),
        (2, 0, 0, 'undecided'),
        (2, 5, 5, 'undecided'),  # too few to judge, whatever y does
        (0, 0, 0, 'undecided'),
    ],
)
def test_the_verdict(disturbance, spurious, missed, verdict):
    assert ENOUGH == 3
    assert Rejection(disturbance, 9, 9, spurious, missed).verdict == verdict


def test_the_ratio():
    assert Rejection(8, 0, 0, 2, 0).ratio == 0.75
    assert Rejection(8, 0, 0, 0, 0).ratio == 1.0
    assert Rejection(4, 0, 0, 6, 0).ratio == -0.5
    assert Rejection(0, 0, 0, 6, 0).ratio is None
