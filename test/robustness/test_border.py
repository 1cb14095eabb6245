# SPDX-License-Identifier: Apache-2.0
"""Borders found by refining, against the whole grid."""

from itertools import pairwise

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.border import border_csv, find_border, joined, refine
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets

SIZE = 300


def disc(i, j):
    return (i - 140) ** 2 + (j - 90) ** 2 < 55.5**2


def strip(i, j):
    """A narrow strip that runs from edge to edge, between most points of the coarse grid."""
    return abs(j - 0.7 * i - 13.2) < 3.0


def two(i, j):
    return disc(i, j) or (i > 250 and j > 200)


@pytest.mark.parametrize(('inside', 'closed', 'open_'), [(disc, 1, 0), (strip, 0, 2), (two, 1, 1)])
def test_the_border_is_that_of_the_whole_grid(inside, closed, open_):
    known = {}
    cells = refine(lambda points: [inside(*p) for p in points], (SIZE, SIZE), known)
    whole = np.array([[inside(i, j) for j in range(SIZE)] for i in range(SIZE)])
    corners = whole[:-1, :-1].astype(int) + whole[1:, :-1] + whole[:-1, 1:] + whole[1:, 1:]
    mixed = {(int(i), int(j)) for i, j in np.argwhere((corners > 0) & (corners < 4))}
    assert set(cells) == mixed
    assert len(known) <= SIZE * SIZE / 10
    curves = joined(cells, known)
    assert sum(curve[0] == curve[-1] for curve in curves) == closed
    assert sum(curve[0] != curve[-1] for curve in curves) == open_
    for curve in curves:
        for (a, b), (c, d) in pairwise(curve):
            assert max(abs(a - c), abs(b - d)) <= 1.0


def test_the_border_of_a_loop_lies_between_sets_that_differ():
    pytest.importorskip('numba')
    parameters = ['exosystem.tau:=0.04..0.2/100', 'controller.k:=0.5..2/100', '/**.rate:=50']
    plan = Plan.of(load('exact'), parameters, duration=300.0)
    border = find_border(plan, ['controller.k', 'exosystem.tau'])
    assert border.names == ('controller.k', 'exosystem.tau')
    assert border.runs <= border.grid / 10
    rejected = Sets(plan).run(plan.design.columns(0, 10000)).rows['verdict'] == 1
    tau, k = np.unravel_index(np.arange(10000), (100, 100))
    whole = dict(zip(zip(k.tolist(), tau.tolist(), strict=True), rejected.tolist(), strict=True))
    assert all(whole[place] == found for place, found in border.known.items())
    edges = sum(whole[i, j] != whole[i + 1, j] for i in range(99) for j in range(100))
    edges += sum(whole[i, j] != whole[i, j + 1] for i in range(100) for j in range(99))
    assert sum(map(len, border.curves)) == edges
    assert border_csv(border).splitlines()[0] == 'curve,controller.k,exosystem.tau'


@pytest.mark.parametrize(
    ('parameters', 'names'),
    [
        (['plant.k:=1..2/5'], 'plant.k,plant.tau'),
        (['plant.k:=1..2/5', 'plant.tau:=1..2/5'], 'plant.k,controller.k'),
        (['plant.k:=1..2/5', 'plant.hold:={zero,linear}'], 'plant.k,plant.hold'),
    ],
)
def test_a_border_needs_two_ranges(parameters, names):
    with pytest.raises(EventregError, match='--border X,Y takes'):
        find_border(Plan.of(load('exact'), parameters), names.split(','))
