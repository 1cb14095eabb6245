# SPDX-License-Identifier: Apache-2.0
"""Runs side by side: by hand, against the verdict's own matching, and as sets."""

import itertools
import random

import pytest

from eventreg_ros.analysis.comparison import (
    Occurrence,
    Trains,
    compare,
    group,
)
from eventreg_ros.analysis.differences import PRESENT, Difference, differences
from eventreg_ros.analysis.distances import spike_distance, van_rossum, victor_purpura
from eventreg_ros.analysis.rejection import match
from eventreg_ros.errors import EventregError

W = [10.0, 50.0, 90.0]


def run(name, stop=100.0, start=0.0, verdict=None, parameters=None, **events):
    return Trains(name, events, stop, start, verdict, parameters)


def test_two_runs():
    a = run('a', w=W, y=[], verdict='rejected', parameters={'controller.k': 2.0, 'plant.k': 1.0})
    b = run('b', w=W, y=[11.0, 51.0], verdict='not rejected',
            parameters={'controller.k': 3.0, 'plant.k': 1.0})  # fmt: skip
    found = compare([a, b])
    assert (found.runs, found.verdicts) == (('a', 'b'), ('rejected', 'not rejected'))
    assert found.parameters == (Difference('controller.k', (2.0, 3.0)),)
    w, y = found.signals
    assert (w.signal, w.counts, w.pairs[0].matched) == ('w', (3, 3), 3)
    assert w.pairs[0].distances.victor_purpura == w.pairs[0].distances.spike == 0.0
    (pair,) = y.pairs
    assert (pair.one, pair.other, pair.matched) == ('a', 'b', 0)
    assert (pair.only_one, pair.only_other) == ((), (11.0, 51.0))
    assert pair.distances.span == (0.0, 100.0)
    assert pair.distances.victor_purpura == victor_purpura([], [11.0, 51.0], 0.2)
    assert pair.distances.van_rossum == van_rossum([], [11.0, 51.0], 5.0)
    assert pair.distances.spike == spike_distance([], [11.0, 51.0], 0.0, 100.0)


def test_only_the_common_span_is_compared():
    long, short = run('long', 300.0, y=[10.0, 99.0, 200.0]), run('short', 100.0, 5.0, y=[10.0])
    (pair,) = compare([long, short]).signals[0].pairs
    assert (pair.only_one, pair.only_other) == ((99.0,), ())
    assert pair.distances.span == (5.0, 100.0)
    assert [o.time for o in compare([long, short]).signals[0].occurrences] == [10.0, 99.0]


def test_events_match_across_the_end_of_the_span():
    a, b = run('a', 100.0, y=[99.0]), run('b', 300.0, y=[101.0])
    (pair,) = compare([a, b]).signals[0].pairs
    assert (pair.matched, pair.only_one, pair.only_other) == (1, (), ())


def test_runs_that_share_no_time_have_no_distances():
    (pair,) = compare([run('a', 10.0, y=[5.0]), run('b', 20.0, 15.0, y=[16.0])]).signals[0].pairs
    assert (pair.distances, pair.only_one) == (None, ())


def test_the_window_decides_what_is_the_same():
    a, b = run('a', y=[50.0]), run('b', y=[53.0])
    assert compare([a, b]).signals[0].pairs[0].matched == 1
    assert compare([a, b], window=2.0).signals[0].pairs[0].matched == 0


def test_how_often_each_event_occurs():
    runs = [run('a', y=[10.0, 40.0]), run('b', y=[11.0]), run('c', y=[12.5, 80.0])]
    (y,) = compare(runs).signals
    assert y.occurrences == (
        Occurrence(11.0, 2.5, ('a', 'b', 'c')),
        Occurrence(40.0, 0.0, ('a',)),
        Occurrence(80.0, 0.0, ('c',)),
    )
    assert [y.share(o) for o in y.occurrences] == pytest.approx([1.0, 1 / 3, 1 / 3])


def test_a_signal_is_compared_where_it_is():
    runs = [run('a', w=W), run('b', w=W, y_r=[5.0], y=[6.0]), run('c', y=[6.5], extra=[])]
    found = {s.signal: s for s in compare(runs).signals}
    assert list(found) == ['w', 'y', 'y_r', 'extra']  # the paper's order, then the others
    assert found['w'].runs == ('a', 'b')
    assert [(p.one, p.other) for p in found['y'].pairs] == [('b', 'c')]
    assert found['y_r'].pairs == ()
    assert found['y'].share(found['y'].occurrences[0]) == 1.0


def trains(draw):
    return [
        sorted(draw.uniform(0.0, 40.0) for _ in range(draw.randint(0, 8)))
        for _ in range(draw.randint(2, 5))
    ]


def test_every_event_is_in_one_group_with_others_of_its_time():
    draw = random.Random(6)
    for _ in range(200):
        given, window = trains(draw), draw.choice([0.5, 3.0, 8.0])
        groups = group(given, window)
        members = sorted(itertools.chain(*groups))
        assert members == sorted((t, i) for i, times in enumerate(given) for t in times)
        for each in groups:
            assert each == sorted(each)
            assert each[-1][0] - each[0][0] <= window
            assert len({i for _, i in each}) == len(each)


def test_groups_of_two_trains_are_the_pairs_of_the_verdict():
    draw = random.Random(7)
    for _ in range(300):
        a, b = trains(draw)[:2]
        window = draw.choice([0.5, 3.0, 8.0])
        pairs = {(a[i], b[j]) for i, j in match(a, b, window)}
        both = [sorted(g, key=lambda member: member[1]) for g in group([a, b], window)]
        assert {(g[0][0], g[1][0]) for g in both if len(g) == 2} == pairs


def test_the_window_is_closed():
    assert group([[0.0], [5.0]], 5.0) == [[(0.0, 0), (5.0, 1)]]


def test_differences():
    a, b = {'p.k': 1.0, 'p.x': [1, 2], 'c.k': 2.0, 'c.tau': 3.0}, {'p.k': 1, 'p.x': [1, 3]}
    assert differences([a, a]) == differences([]) == differences([a]) == ()
    assert differences([a, b]) == (
        Difference('c', (PRESENT, None)),
        Difference('p.x', ([1, 2], [1, 3])),
    )
    assert differences([a, {**a, 'p.new': 5}]) == (Difference('p.new', (None, 5)),)


def test_unknown_parameters_differ_from_none():
    assert differences([None, {'p.k': 1}]) == differences([None, None]) == ()
    assert differences([None, {'p.k': 1}, {'p.k': 2}]) == (Difference('p.k', (None, 1, 2)),)


@pytest.mark.parametrize(
    ('names', 'window', 'rule'),
    [
        ([], 5.0, 'two runs or more'),
        (['a'], 5.0, 'two runs or more'),
        (['a', 'a'], 5.0, 'names of their own'),
        (['a', 'b'], 0.0, 'window must be > 0, got 0'),
    ],
)
def test_what_cannot_be_compared(names, window, rule):
    with pytest.raises(EventregError, match=rule) as caught:
        compare([run(name, y=[]) for name in names], window)
    assert '\n' not in str(caught.value)
