# SPDX-License-Identifier: Apache-2.0
"""A comparison as a table and as JSON: everything that it found is there."""

import json

from eventreg_ros.analysis.comparison import Trains, compare, distinct
from eventreg_ros.analysis.comparison_words import MOST, as_json, listed, table, value_in_words


def made():
    w = [10.0, 50.0, 90.0]
    return compare(
        [
            Trains('a', {'w': w, 'y': []}, 100.0, 0.0, 'rejected', {'c.k': 2.0}),
            Trains('b', {'w': w, 'y': [11.0]}, 100.0, 0.0, 'not rejected', {'c.k': 3.0}),
            Trains('long', {'w': w[:2], 'y': [11.5, 70.0]}, 99.0),
        ]
    )


def test_the_table():
    lines = table(made()).splitlines()
    words = [' '.join(line.split()) for line in lines]
    assert words[:4] == [
        'run verdict w y events', 'a rejected 3 0', 'b not rejected 3 1', 'long - 2 2',
    ]  # fmt: skip
    (pair,) = made().signals[1].pairs[:1]
    d = pair.distances
    assert f'y a / b 0 0 1 1 1 {d.spike:.3g} {d.isi:.3g}' in words
    assert 'y in b, not in a: 11.0' in words
    assert 'w in a, not in long: 90.0' in words
    assert 'y, not in all 3 runs: 11.2 in 2, 70.0 in 1' in words
    assert words[-1] == 'c.k: 2 | 3 | -'
    assert all(len(line) < 120 for line in lines)


def test_the_json_has_it_all():
    found = json.loads(json.dumps(as_json(made()), allow_nan=False))
    assert list(found) == ['runs', 'verdicts', 'window', 'signals', 'parameters']
    assert found['runs'] == ['a', 'b', 'long']
    assert found['verdicts'] == ['rejected', 'not rejected', None]
    assert found['parameters'] == {'c.k': [2.0, 3.0, None]}
    y = found['signals']['y']
    assert list(y) == ['runs', 'counts', 'pairs', 'events']
    assert y['events'][0] == {'time': 11.25, 'spread': 0.5, 'runs': ['b', 'long'], 'share': 2 / 3}
    pair = y['pairs'][0]
    assert (pair['one'], pair['other'], pair['only_other']) == ('a', 'b', [11.0])
    assert list(pair['distances']) == ['span', 'victor_purpura', 'van_rossum', 'spike', 'isi']


def test_nothing_differs():
    same = [Trains(name, {}, 10.0) for name in 'ab']
    assert 'no difference known' in table(compare(same))
    assert as_json(compare(same))['signals'] == {}


def test_long_lists_are_cut():
    assert listed([float(t) for t in range(MOST + 5)]).endswith(f'{MOST - 1:.1f} and 5 more')
    assert listed([1.0, 2.25]) == '1.0, 2.2'


def test_values():
    values = (None, 0.1 + 0.2, 2, True, 'linear', [1.0, 0.5], 'present')
    assert [value_in_words(v) for v in values] == [
        '-', '0.3', '2', 'True', 'linear', '[1, 0.5]', 'present',
    ]  # fmt: skip


def test_names_of_their_own():
    assert distinct(['a', 'b', 'a', 'a']) == ['a', 'b', 'a (2)', 'a (3)']
