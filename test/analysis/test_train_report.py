# SPDX-License-Identifier: Apache-2.0
"""What the trains of a run say: of made signals whose answer is known, and of the paper's loop."""

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.train_report import train_report
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.scenario.criteria import Criteria


def test_made_signals(loop_signals):
    # A pulse rises through 1 at its time, and falls through 0 at 1.25 after it.
    w = [10, 50, 90, 130, 170, 210]
    signals = loop_signals(w=w, u=[t + 4 for t in w], y=[20, 111, 150], y_r=[110, 190])
    found = train_report(signals)
    assert list(found.trains) == ['w', 'y', 'y_r', 'u']
    assert [found.trains[name].count for name in found.trains] == [3, 2, 2, 3]  # from 100 on
    assert found.trains['w'].cv == pytest.approx(0.0, abs=1e-12)
    assert found.trains['w'].rate == pytest.approx(3 / 160.0)
    assert found.trains['w'].width_median == pytest.approx(1.25)
    assert (found.answer.matched, found.answer.precision, found.answer.recall) == (1, 0.5, 0.5)
    assert found.answer.latency_median == pytest.approx(1.0)
    assert found.following.mean == pytest.approx(0.1)  # 4 of 40 late
    assert found.following.locking == pytest.approx(1.0)
    assert found.settling is None  # the last unwanted is the missed one at 190: one w follows
    assert not any(noise.noisy for noise in found.noise.values())


def test_the_settling_time_is_that_of_the_last_unwanted_event(loop_signals):
    signals = loop_signals(w=[10, 50, 90, 130, 170, 210], y=[20, 61], y_r=[60])
    assert train_report(signals).settling == pytest.approx(20.0)
    assert train_report(signals, Criteria(window=0.5)).settling == pytest.approx(61.0)


def test_signals_that_are_not_there(loop_signals):
    found = train_report(loop_signals(w=[110], y=[]))
    assert (found.answer, found.following, found.settling) == (None, None, None)
    empty = train_report({'y': (np.empty(0), np.empty(0))})
    assert (empty.trains['y'].count, empty.trains['y'].rate) == (0, None)


def test_the_limits_of_the_detector_are_used(loop_signals):
    signals = loop_signals(w=[], y=[110, 112, 150])
    assert train_report(signals).trains['y'].count == 3
    assert train_report(signals, Criteria(refractory=3.0)).trains['y'].count == 2
    assert train_report(signals, Criteria(min_width=1.3)).trains['y'].count == 0


@pytest.mark.slow
def test_the_papers_loop_locks_to_the_disturbance_and_settles():
    run = simulate('exact', 400.0)
    found = train_report({name: (run.fine.t, x) for name, x in run.fine.signals.items()})
    assert found.settling == 0.0
    assert found.trains['w'].interval_mean == pytest.approx(37.5467, abs=1e-4)
    assert found.following.locking == pytest.approx(1.0, abs=1e-9)
    assert found.following.mean == pytest.approx(0.0, abs=1e-4)
    free = simulate('uncontrolled', 400.0)
    signals = {name: (free.fine.t, x) for name, x in free.fine.signals.items()}
    report = judge(signals, subject_by_name(signals))
    found = train_report(signals)
    assert found.settling is None
    assert found.trains['y'].count == report.rejection.spurious
