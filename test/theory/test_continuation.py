# SPDX-License-Identifier: Apache-2.0
"""Curves that are followed, against curves that are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.theory.continuation import LostError, Plane

HIGH = np.array([100.0, 80.0])


@dataclass
class Point:
    point: np.ndarray
    value: float
    slope: np.ndarray
    exact: bool = True


def circle(p, near):
    away = p - np.array([50.0, 40.0])
    return Point(p, away @ away - 400.0, 2 * away)


def waves(p, near):
    """Turns back and forth in x while y goes on."""
    return Point(p, p[0] - 50 - 45 * np.sin(p[1] / 8), np.array([1.0, -45 / 8 * np.cos(p[1] / 8)]))


def ending(p, near):
    """A line that nobody knows beyond x = 60."""
    if p[0] > 60.0:
        raise EventregError('nothing here')
    return Point(p, p[1] - 30.0, np.array([0.0, 1.0]))


def flat(p, near):
    return Point(p, 1.0, np.zeros(2))


def through(function, x, y):
    start = function(np.array([x, y]), None)
    return Plane(function, HIGH, 2.0).curve(start)


def test_a_closed_curve_is_followed_once():
    walk = through(circle, 73.0, 40.0)
    assert walk.closed
    points = np.array([each.point for each in walk.points])
    away = np.linalg.norm(points - [50.0, 40.0], axis=1)
    np.testing.assert_allclose(away, 20.0, atol=1e-9)
    assert np.array_equal(points[0], points[-1])
    turned = np.unwrap(np.arctan2(*(points[:-1] - [50.0, 40.0]).T[::-1]))
    assert 1.9 * np.pi < abs(turned[-1] - turned[0]) < 2 * np.pi
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 3.5


def test_an_open_one_from_edge_to_edge_through_its_folds():
    walk = through(waves, 8.0, 40.0)
    assert not walk.closed
    assert walk.ends == ('', '')
    points = np.array([each.point for each in walk.points])
    assert max(abs(waves(p, None).value) for p in points) < 1e-9
    assert sorted(points[[0, -1], 1].tolist()) == pytest.approx([0.0, 80.0], abs=1e-12)
    assert (np.diff(points[:, 1]) > 0.0).all() or (np.diff(points[:, 1]) < 0.0).all()
    assert (np.diff(np.sign(np.diff(points[:, 0]))) != 0).sum() == 3  # y / 8 from 0 to 10
    assert ((points >= 0.0) & (points <= HIGH)).all()
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 2.5


def test_where_it_is_lost_it_ends_and_says_why():
    walk = through(ending, 30.0, 33.0)
    points = np.array([each.point for each in walk.points])
    assert set(walk.ends) == {'', 'nothing here'}
    assert points[:, 0].min() == 0.0
    assert 59.9 < points[:, 0].max() <= 60.0


def test_what_has_no_slope_is_no_curve():
    with pytest.raises(LostError, match='does not change'):
        through(flat, 30.0, 30.0)
