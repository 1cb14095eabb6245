# SPDX-License-Identifier: Apache-2.0
"""What was changed during a run, in model time, in the report, its JSON and its table."""

import json

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.changes import Change, changes_of, words
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.analysis.report_table import table
from eventreg_ros.bags.changes import Changed
from eventreg_ros.bags.recording import Recording, Stamped

SECOND = 10**9
START = 1_795_304_457 * SECOND


def recording(*changes):
    y = Stamped(START + np.arange(3) * SECOND, np.zeros(3))
    found = tuple(Changed(START + int(t * SECOND), node, what) for t, node, what in changes)
    return Recording({'y': y}, (), None, None, 'publish', {'y': '/y'}, changes=found)


def test_changes_in_model_time_but_for_the_start_of_nodes():
    found = changes_of(
        recording(
            (-1.0, 'plant', 'start_time:=7'),
            (-0.5, 'plant', 'configure'),
            (0.01, 'controller', 'activate'),
            (0.02, 'controller', 'k:=1'),
            (0.5, 'reference', 'activate'),
            (0.6, 'reference', 'deactivate'),
            (0.8, 'reference', 'activate'),
            (2.0, 'controller', 'k:=3'),
            (4.0, 'plant', 'deactivate'),
            (5.0, 'plant', 'activate'),
        ),
        10.0,
    )
    assert found == (
        Change(pytest.approx(0.2), 'controller', 'k:=1'),
        Change(6.0, 'reference', 'deactivate'),
        Change(8.0, 'reference', 'activate'),
        Change(20.0, 'controller', 'k:=3'),
        Change(40.0, 'plant', 'deactivate'),
        Change(50.0, 'plant', 'activate'),
    )


def test_in_words():
    assert words(()) == ''
    one = Change(20.0, 'controller', 'k:=3')
    assert words([one]) == 'changed: controller.k:=3 at 20.0'
    assert words([Change(20.04, 'plant', 'deactivate')]) == 'changed: plant: deactivate at 20.0'
    assert words([one] * 9).endswith('at 20.0 and 3 more')


def test_a_simulation_reports_what_was_asked_for():
    at = ['20:controller.k:=3', '30:plant:deactivate']
    run = simulate(load('exact'), 60.0, sampled=True, at=at)
    assert run.report.changes == (
        Change(20.0, 'controller', 'k:=3'), Change(30.0, 'plant', 'deactivate'),
    )  # fmt: skip
    assert json.loads(json.dumps(as_json(run.report)))['changes'] == [
        {'at': 20.0, 'node': 'controller', 'what': 'k:=3'},
        {'at': 30.0, 'node': 'plant', 'what': 'deactivate'},
    ]
    text = table(run.report)
    assert '\nchanged: controller.k:=3 at 20.0, plant: deactivate at 30.0\n' in text
    assert 'changes' not in as_json(simulate('exact', 20.0).report)
