# SPDX-License-Identifier: Apache-2.0
"""Searches that are kept: stopped anywhere, they go on and find the same."""

import pytest

from eventreg_ros import load
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness import sweep as module
from eventreg_ros.robustness.border import find_border
from eventreg_ros.robustness.evaluations import kept
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.worst import search

RANGES = ['exosystem.tau:=0.05..0.1/17', 'controller.k:=0.4..1.2/17', '/**.rate:=25']


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch):
    monkeypatch.setattr(module, 'FIRST', 7)
    monkeypatch.setattr(module, 'MOST', 7)


def plan(question, **more):
    return Plan.of(load('exact'), RANGES, duration=200.0, settle=60.0, question=question, **more)


def border(of, progress=lambda done, count: None, store=None):
    return find_border(of, ['exosystem.tau', 'controller.k'], progress, store)


def worst(of, progress=lambda done, count: None, store=None):
    return search(of, 100, progress, store)


@pytest.mark.parametrize(
    ('ask', 'of'),
    [(border, plan('border')), (worst, plan('worst', sets=1, sampling='random', seed=2))],
)
def test_a_search_that_was_stopped_goes_on_where_it_was(tmp_path, ask, of):
    """It is stopped twice; what was run before is not run again."""
    expected, stopped = ask(of), 0
    for _ in range(2):
        done = []

        def progress(count, total, done=done):
            done.append(count)
            if len(done) == 4:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt), kept(of, tmp_path / 'a') as store:
            ask(of, progress, store)
        assert done[0] > stopped
        stopped = done[-1]
    done = []
    with kept(of, tmp_path / 'a') as store:
        found = ask(of, lambda count, total: done.append(count), store)
    assert done[0] > stopped
    assert found.runs == expected.runs == done[-1]
    if ask is border:
        assert found.known == expected.known
    else:
        assert found == expected
    assert sorted(path.name for path in (tmp_path / 'a').iterdir()) == [
        'scenario.yaml', 'sweep.json'
    ]  # fmt: skip


def test_another_question_in_the_same_place_is_refused(tmp_path):
    with kept(plan('border'), tmp_path / 'a'):
        pass
    for question, words in (('worst 9', 'not worst 9'), ('', 'not none')):
        with (
            pytest.raises(EventregError, match=f'its question was border, {words}; name another'),
            kept(plan(question), tmp_path / 'a'),
        ):
            pass
