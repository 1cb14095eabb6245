# SPDX-License-Identifier: Apache-2.0
"""Whatever the library returns for a run is compared and judged alike."""

import pytest

from eventreg_ros import analyze, compare, judge, open_run, simulate
from eventreg_ros.errors import EventregError
from eventreg_ros.session.bag import Recorded
from eventreg_ros.session.live import LiveRun

W = [20, 112, 190, 205]


@pytest.fixture
def bag(make_bag):
    return make_bag(w=W, y=[112, 190], u=W)


@pytest.fixture
def recorded(bag):
    return analyze(bag)


@pytest.fixture
def live(bag, recorded):
    return LiveRun(recorded.scenario, bag, recorded.analysis)


def test_a_bag_opened_is_a_bag_analyzed(bag, recorded):
    opened = open_run(bag)
    assert type(opened) is Recorded
    assert (opened.verdict, opened.events) == (recorded.verdict, recorded.events)
    assert open_run(recorded) is recorded


def test_whatever_is_a_run_is_compared(bag, recorded, live):
    simulated = simulate('exact', 150.0)
    found = compare(simulated, recorded, live, bag)
    assert found == compare(simulated, *[bag] * 3, names=found.runs)


def test_whatever_is_a_run_is_judged(bag, recorded, live):
    for run in (recorded, live, open_run(bag)):
        assert judge(run).verdict == recorded.verdict == 'not rejected'
        report = judge(run, settle=195.0, until=250.0)
        assert report == analyze(bag, settle=195.0, until=250.0).report
        assert report.rejection != recorded.report.rejection
        with pytest.raises(EventregError, match='settle must lie within the run'):
            judge(run, settle=1e4)


@pytest.mark.parametrize('what', [None, 3, ['exact']])
def test_what_is_no_run_is_refused(what):
    with pytest.raises(EventregError, match='judge takes a run'):
        judge(what)
    with pytest.raises(EventregError, match='a run is a bag, a scenario or a result'):
        compare(what, what)


def test_a_path_that_is_too_long_is_no_file():
    with pytest.raises(EventregError, match='is neither a bag nor a scenario'):
        open_run('x' * 5000)


def test_one_intervention_may_be_one_text():
    text = '50:controller:deactivate'
    one, listed = (simulate('exact', 60.0, at=at) for at in (text, [text]))
    assert one.changes == listed.changes != ()


def test_errors_of_the_library_name_no_options():
    for arguments, more in ((('exact', 'oops'), {}), (('exact',), {'at': 'oops'})):
        with pytest.raises(EventregError, match='must be') as caught:
            simulate(*arguments, **more)
        assert '-p' not in str(caught.value)
        assert '--at' not in str(caught.value)
