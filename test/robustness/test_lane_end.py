# SPDX-License-Identifier: Apache-2.0
"""Sets that diverge, looked at in lanes: the rows and reasons of runs one by one."""

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.robustness import lane_run
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets

WILD = [
    'controller.gain[0]:=-3..3',
    'plant.x0[0]:=-2..2',
    'controller.k_y:=-3..3',
    'noise.y:=0..0.1',
]


@pytest.fixture
def runs_alone(monkeypatch):
    """How many runs were made one by one."""
    pytest.importorskip('numba')
    monkeypatch.setattr(lane_run, 'MANY', 1)
    made, alone = [], lane_run.one_by_one
    monkeypatch.setattr(lane_run, 'one_by_one', lambda case: made.append(case) or alone(case))
    return made


@pytest.mark.slow
def test_sets_that_diverge_have_the_rows_of_runs_one_by_one(runs_alone, monkeypatch):
    plan = Plan.of(load('linear'), WILD, sets=48, settle=5.0)
    columns = plan.design.columns(0, 48)
    found = Sets(plan).run(columns)
    assert not runs_alone
    monkeypatch.setattr(lane_run, 'lanes_can', lambda *_: False)
    monkeypatch.setattr('eventreg_ros.robustness.sets.lanes_can', lambda *_: False)
    alone = Sets(plan).run(columns)
    assert len(runs_alone) == 48
    assert found.rows.tobytes() == alone.rows.tobytes()
    assert found.reasons == alone.reasons
    assert set(found.rows['verdict'].tolist()) == {0, 1, 2, 3}
    # some end far above, where no event can begin, and some far below
    undecided = found.rows['peak'][found.rows['verdict'] == 3]
    assert (undecided > 1e6).any()
    assert (undecided < 1e6).any()


def test_few_sets_that_diverge_need_no_code_of_their_own(runs_alone, monkeypatch):
    monkeypatch.setattr(lane_run, 'MANY', 128)
    plan = Plan.of(load('exact'), ['controller.k:={1,50}'], duration=150.0)
    found = Sets(plan).run([np.array([1.0, 50.0])])
    assert len(runs_alone) == 1
    assert 'stops being finite at t = ' in found.reasons[1]
