# SPDX-License-Identifier: Apache-2.0
"""The margins of loops that predict: how far is looked, and with which lead."""

import json
from itertools import pairwise

import pytest

from eventreg_ros import judge, load, simulate
from eventreg_ros.cli.main import main
from eventreg_ros.robustness.evaluator import Evaluator, Setting
from eventreg_ros.robustness.margins import FOLLOWS, limit, to_and_fro
from eventreg_ros.robustness.scans import FARTHEST_PREDICTED, further, search_on

PREDICT = 'controller.predict:=true'


def test_beyond_the_usual_scan_it_goes_on_to_100_by_tenths_of_a_decade():
    delays = [k * 0.05 for k in further(0.05)]
    assert delays[0] == pytest.approx(2.5, abs=0.05)
    assert delays[-1] == pytest.approx(FARTHEST_PREDICTED)
    ratios = [b / a for a, b in pairwise(delays)]
    assert max(ratios) < 1.3


def test_it_looks_no_further_than_the_first_failure():
    for edge in (41, 47, 63, 64, 65, 900):
        asked = []
        found = search_on(lambda k, e=edge, a=asked: a.append(k) or k < e, [40, 50, 64, 1000])
        assert found == (edge - 1, edge)
        assert max(asked) == next(k for k in (50, 64, 1000) if k >= edge)
    assert search_on(lambda k: True, [40, 50, 64]) == (64, None)


def led(name, hold, setting, *overrides):
    scenario = load(name, PREDICT, *overrides)
    on = tuple(to_and_fro(scenario.loop))
    assert on == ('y', 'u')
    return limit(Evaluator(scenario, hold, 200.0, setting, on, led=True), 'delay')


@pytest.mark.slow
def test_a_wrong_model_tolerates_0_80_with_the_lead_set_to_the_delay():
    found = led('mismatch', 'linear', Setting())
    assert (found.largest, found.fails_at, found.lead) == (0.8, 0.85, FOLLOWS)


@pytest.mark.slow
def test_where_nothing_fails_before_it_is_looked_for_beyond_2():
    found = led('exact', 'linear', Setting(duration=260.0))
    assert found.largest > 30.0
    assert found.fails_at == pytest.approx(found.largest + 0.05)
    for delay, wanted in ((found.largest, 'rejected'), (found.fails_at, 'not rejected')):
        scenario = load('exact', PREDICT, f'/**.lead:={delay}')
        assert simulate(scenario, 260.0, sampled=True, delay=delay, on='yu').verdict == wanted
    learned = load('mismatch', PREDICT, '/**.lead:=20', 'controller.adapt:=0.04')
    run = simulate(learned, 800.0, sampled=True, delay=20.0, on='yu')
    assert judge(run, settle=300.0).verdict == 'rejected', 'and one that learns goes as far'


@pytest.mark.slow
def test_the_command_has_both_the_lead_that_follows_and_the_one_that_is_set(tmp_path, capsys):
    overrides = ['-p', PREDICT, '-p', '/**.lead:=0.4', '-p', 'controller.tau:=1/17']
    quick = ['--duration', '240', '--seeds', '1', '--rate', '50', '--json', tmp_path / 'm.json']
    assert main(['margin', 'mismatch', *overrides, *map(str, quick)]) == 0
    hold = json.loads((tmp_path / 'm.json').read_text())['holds']['linear']
    assert hold['delay']['lead'] == 'delay'
    assert hold['delay']['on'] == hold['delay_at_lead']['on'] == ['y', 'u']
    assert {hold[key]['lead'] for key in ('delay_at_lead', 'loss', 'jitter')} == {0.4}
    assert hold['delay_of'].keys() == {'w', 'y', 'u'}
    out = capsys.readouterr().out
    assert '\nat lead 0.4 ' in out
    assert 'delay: of y and u, with the lead raised to it; at lead 0.4: ' in out
