# SPDX-License-Identifier: Apache-2.0
"""Distances of event trains: against elephant and PySpike, the definitions, and as metrics."""

import itertools
import math
import random

import numpy as np
import pytest

from eventreg_ros.analysis.distances import (
    isi_distance,
    spike_distance,
    van_rossum,
    victor_purpura,
)
from eventreg_ros.errors import EventregError

SPAN = 100.0


def train(seed, n):
    draw = random.Random(seed)
    return sorted(round(draw.uniform(0.0, SPAN), 3) for _ in range(n))


TRAINS = {
    'few': (train(1, 4), train(2, 6)),
    'many': (train(3, 40), train(4, 35)),
    'one': (train(5, 1), train(6, 3)),
    'empty': ([], train(7, 5)),
}

# elephant 1.2.1, spike_train_dissimilarity.victor_purpura_distance and van_rossum_distance of
# TRAINS in seconds, by cost in Hz and time constant in s; PySpike 0.9.0, spike_distance and
# isi_distance of SpikeTrain(times, (0, 100)).
ELEPHANT_COST = {
    'few': {0.05: 3.4387000000000003, 0.2: 5.7844, 1.0: 9.192999999999998},
    'many': {0.05: 9.768550000000005, 0.2: 19.546799999999994, 1.0: 38.92600000000001},
    'one': {0.05: 2.68935, 0.2: 4.0, 1.0: 4.0},
    'empty': {0.05: 5.0, 0.2: 5.0, 1.0: 5.0},
}
ELEPHANT_TIME = {
    'few': {1.0: 3.201852808976101, 5.0: 2.971758430228879, 20.0: 2.479452324442514},
    'many': {1.0: 7.21745270169028, 5.0: 6.374698779483893, 20.0: 5.773596891945168},
    'one': {1.0: 2.028403534470075, 5.0: 2.2146611529992764, 20.0: 1.9840713432443255},
    'empty': {1.0: 2.236248370149678, 5.0: 2.392910625023582, 20.0: 3.276268676840717},
}
PYSPIKE = {
    'few': (0.20814147530748875, 0.4002648902492511),
    'many': (0.20596731690343867, 0.3833085281323612),
    'one': (0.3681539905108685, 0.3284978848255089),
    'empty': (0.40735149939650156, 0.7781982012),
}


def by_spike(a, b):
    return spike_distance(a, b, 0.0, SPAN)


def by_isi(a, b):
    return isi_distance(a, b, 0.0, SPAN)


ALL = [lambda a, b: victor_purpura(a, b, 0.2), lambda a, b: van_rossum(a, b, 5.0), by_spike, by_isi]


# Others' code -------------------------------------------------------------------------------------


@pytest.mark.parametrize('name', TRAINS)
def test_elephant_and_pyspike_agree(name):
    a, b = TRAINS[name]
    for cost, value in ELEPHANT_COST[name].items():
        assert victor_purpura(a, b, cost) == pytest.approx(value, rel=1e-12)
    for time_constant, value in ELEPHANT_TIME[name].items():
        assert van_rossum(a, b, time_constant) == pytest.approx(value, rel=1e-12)
    spike, isi = PYSPIKE[name]
    assert by_spike(a, b) == pytest.approx(spike, rel=1e-12)
    assert by_isi(a, b) == pytest.approx(isi, rel=1e-12)


# The definitions ----------------------------------------------------------------------------------


def cheapest(a, b, cost):
    """Try every way of keeping some events of a, moved in order onto events of b."""
    if len(a) > len(b):
        a, b = b, a
    return min(
        len(a) + len(b) - 2 * n + cost * sum(abs(x - y) for x, y in zip(kept, onto, strict=True))
        for n in range(len(a) + 1)
        for kept in itertools.combinations(a, n)
        for onto in itertools.combinations(b, n)
    )


def test_victor_purpura_is_the_cheapest_way():
    draw = random.Random(1)
    for _ in range(60):
        a, b = (sorted(draw.uniform(0.0, 10.0) for _ in range(draw.randint(0, 5))) for _ in 'ab')
        cost = draw.choice([0.0, 0.1, 0.5, 2.0])
        assert victor_purpura(a, b, cost) == pytest.approx(cheapest(a, b, cost), abs=1e-12)


def test_van_rossum_is_the_distance_of_the_filtered_trains():
    a, b, constant = [3.0, 8.0, 9.0, 30.0], [4.0, 8.0, 20.0], 2.0
    # Between the events (all on the grid) the difference is an exponential: integrated exactly.
    edges = [*np.arange(0.0, 60.0), np.inf]
    total = level = 0.0
    for left, right in itertools.pairwise(edges):
        level += a.count(left) - b.count(left)
        decay = math.exp(-(right - left) / constant)
        total += level**2 * constant / 2.0 * (1.0 - decay**2)
        level *= decay
    assert van_rossum(a, b, constant) == pytest.approx(math.sqrt(2.0 / constant * total), rel=1e-12)


def profile(a, b, t):
    """Return SPIKE and ISI dissimilarity at one instant that is inside both trains."""
    local = []
    for own, other in ((a, b), (b, a)):
        before = max(x for x in own if x <= t)
        after = min(x for x in own if x > t)
        gap = after - before
        d_before, d_after = (min(abs(x - y) for y in other) for x in (before, after))
        local.append((gap, (d_before * (after - t) + d_after * (t - before)) / gap))
    (gap_a, s_a), (gap_b, s_b) = local
    spike = (s_a * gap_b + s_b * gap_a) / (2.0 * ((gap_a + gap_b) / 2.0) ** 2)
    return spike, abs(gap_a - gap_b) / max(gap_a, gap_b)


def test_spike_and_isi_are_the_means_of_their_profiles():
    # Events at both edges, so that nothing outside the span counts.
    a, b = [0.0, 4.0, 5.0, 9.0, 16.0, 20.0], [0.0, 3.0, 6.0, 7.0, 17.0, 20.0]
    n = 20000  # midpoints; all events lie between them, and SPIKE is a line between the events
    points = (np.arange(n) + 0.5) * (20.0 / n)
    means = np.mean([profile(a, b, t) for t in points], axis=0)
    assert spike_distance(a, b, 0.0, 20.0) == pytest.approx(means[0], rel=1e-9)
    assert isi_distance(a, b, 0.0, 20.0) == pytest.approx(means[1], rel=1e-9)


# As metrics ---------------------------------------------------------------------------------------


@pytest.mark.parametrize('distance', ALL)
def test_equal_trains_are_0_apart_and_order_does_not_matter(distance):
    for a, b in TRAINS.values():
        assert distance(a, a) == distance(b, b) == 0.0
        assert distance(a, b) == pytest.approx(distance(b, a), rel=1e-12)
        assert distance(a, b) > 0.0
    assert distance([], []) == 0.0


@pytest.mark.parametrize('distance', ALL[:2])
def test_a_detour_is_no_shorter(distance):
    for seed in range(30):
        a, b, c = (train(3 * seed + i, 2 + (seed + i) % 6) for i in range(3))
        assert distance(a, c) <= distance(a, b) + distance(b, c) + 1e-12


def test_the_limits():
    a, b = [10.0, 20.0, 30.0], [10.0, 20.5]
    assert victor_purpura(a, b, 0.0) == 1.0  # moving costs nothing: the numbers differ
    assert victor_purpura(a, b, 1e9) == 3.0  # moving costs too much: one is common
    assert van_rossum(a, [*a, 25.0], 5.0) == pytest.approx(1.0)
    assert van_rossum(a, b, 1e-9) == pytest.approx(math.sqrt(3.0))
    assert van_rossum(a, b, 1e9) == pytest.approx(1.0)
    assert 0.0 < by_spike(a, b) < 1.0
    assert by_isi([50.0], [25.0, 50.0, 75.0]) == 0.5


def test_events_at_one_time():
    assert victor_purpura([5.0, 5.0], [5.0], 1.0) == 1.0
    assert van_rossum([5.0, 5.0], [5.0], 1.0) == 1.0
    assert math.isfinite(by_spike([5.0, 5.0], [5.0]))
    assert by_isi([0.0, 0.0, SPAN], [0.0, SPAN]) == 0.0


def test_ten_thousand_events():
    # Against a coarser computation: far from each other, a pair is moved or replaced on its own.
    a = np.arange(10_000) * 100.0
    b = a + np.resize([1.0, 3.0, 20.0], 10_000)
    expected = np.minimum(2.0, 0.2 * (b - a)).sum()
    assert victor_purpura(a, b, 0.2) == pytest.approx(expected, rel=1e-12)
    expected = 2.0 * (1.0 - np.exp(-(b - a) / 5.0)).sum()
    assert van_rossum(a, b, 5.0) ** 2 == pytest.approx(expected, rel=1e-6)  # neighbours: e^-16


@pytest.mark.parametrize(
    ('call', 'rule'),
    [
        (lambda: victor_purpura([], [], -1.0), 'cost must be finite and >= 0, got -1'),
        (lambda: victor_purpura([], [], math.nan), 'cost must be finite and >= 0, got nan'),
        (lambda: victor_purpura([], [], math.inf), 'cost must be finite and >= 0, got inf'),
        (lambda: van_rossum([], [], 0.0), 'time_constant must be > 0, got 0'),
        (lambda: spike_distance([], [], 5.0, 5.0), r'stop must be > start \(5\), got 5'),
        (lambda: isi_distance([1.0, 12.0], [], 0.0, 10.0), 'between start 0 and stop 10, got 1 to'),
    ],
)
def test_bad_arguments(call, rule):
    with pytest.raises(EventregError, match=rule) as caught:
        call()
    assert '\n' not in str(caught.value)
