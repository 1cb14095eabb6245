# SPDX-License-Identifier: Apache-2.0
"""What a report says of controllers that learn: values, generators, locking, and warnings."""

import math

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis import learning
from eventreg_ros.analysis.changes import Change
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.analysis.report_table import table
from eventreg_ros.analysis.signal import ordered, with_events
from eventreg_ros.analysis.subject import subject_by_name, subject_of
from eventreg_ros.bags.writer import write_bag

LEARNS = 'controller.adapt:=0.04'


@pytest.fixture(scope='module')
def unknown():
    """The bank of two, sampled."""
    return simulate('unknown', sampled=True)


@pytest.fixture(scope='module')
def twins():
    """The same, but both controllers start alike: they stay together for ever."""
    return simulate(load('unknown', 'controller_2.tau:=0.1'), sampled=True)


def codes(run):
    return [finding.code for finding in run.report.evidence.warnings]


@pytest.mark.slow
def test_it_names_the_generator_that_each_controller_came_to(unknown):
    first, second = unknown.report.learned
    assert (first.signal, first.generator, first.value) == ('u/tau', 'exosystem', 1 / 12)
    assert (second.signal, second.generator, second.value) == ('u_2/tau', 'exosystem_2', 1 / 19)
    assert (first.first, second.first) == (0.1, 1 / 22)
    for each in (first, second):
        tau = unknown[each.signal]
        assert each.last == tau[-1]
        wrong = unknown.t[np.abs(np.log(tau / each.value)) >= 0.05]
        assert each.locked_at == pytest.approx(wrong[-1] + 0.05)
    assert codes(unknown) == []


@pytest.mark.slow
def test_it_is_in_the_json_and_in_the_table(unknown):
    found = as_json(unknown.report)['learned']
    assert list(found) == ['u/tau', 'u_2/tau']
    assert found['u/tau']['generator'] == 'exosystem'
    assert found['u/tau']['locked_at'] == unknown.report.learned[0].locked_at
    assert 'u/tau went from 1/10.0000 to 1/11.99' in table(unknown.report)
    assert 'learned' not in as_json(simulate('exact', 150.0).report)


@pytest.mark.slow
def test_two_that_follow_the_same_generator_are_reported(twins):
    assert twins.verdict == 'not rejected'
    assert codes(twins) == ['same-generator']
    (finding,) = twins.report.evidence.warnings
    assert 'u/tau and u_2/tau are within 1 % of each other' in finding.text
    assert len(finding.text) < 300


def test_without_events_of_y_they_may_agree():
    """Two generators that are alike are served by two controllers that are."""
    found = [learning.Learned(signal, 'tau', 0.1, 0.08) for signal in ('u/tau', 'u_2/tau')]
    assert learning.findings([], found, spurious=0) == []
    assert len(learning.findings([], found, spurious=1)) == 1
    apart = [found[0], learning.Learned('u_2/tau', 'tau', 0.1, 0.08 * 1.011)]
    assert learning.findings([], apart, spurious=1) == []


@pytest.mark.slow
def test_a_gain_that_need_not_converge_and_no_generator_are_warnings():
    large = simulate(load('exact', 'controller.adapt:=0.09'), 150.0)
    assert codes(large) == ['large-gain']
    assert 'above 0.08 it need not converge' in large.report.evidence.warnings[0].text
    alone = simulate(load('quiescent', LEARNS), 150.0)
    assert codes(alone) == ['no-generator']
    assert alone.report.learned[0].value is None
    assert codes(simulate(load('exact', LEARNS), 150.0)) == []


def test_a_generator_that_was_changed_is_known_as_it_is_now():
    slow = load('exact', 'controller.k:=1', LEARNS)
    run = simulate(slow, 700.0, sampled=True, at=['300:exosystem.tau:=0.05'])
    (found,) = run.report.learned
    assert found.value == 0.05
    assert 300.0 < found.locked_at < 500.0
    again = learning.after(learning.learners_of(slow), [Change(1.0, '/exosystem', 'tau:=0.04')])
    assert again[0].generators == (('exosystem', 0.04),)
    assert learning.after(again, [Change(1.0, 'exosystem', 'deactivate')]) == again


def test_what_is_judged_can_be_a_key():
    """Runs that are judged alike are run together."""
    subject = subject_of(load('unknown'))
    assert subject.learners[1].generators == (('exosystem', 1 / 12), ('exosystem_2', 1 / 19))
    assert hash(subject) == hash(subject_of(load('unknown')))


def test_the_time_of_locking():
    t = np.arange(6.0)
    tau = np.array([0.1, 0.09, 0.11, 0.2, 0.1, 0.099])
    assert learning.locked_at(t, tau, 0.1) == 4.0
    assert learning.locked_at(t[4:], tau[4:], 0.1) == 4.0
    assert learning.locked_at(t[:4], tau[:4], 0.1) is None
    edge = 0.1 * math.exp(0.0499)
    assert learning.locked_at(t[:1], np.array([edge]), 0.1) == 0.0


@pytest.mark.slow
def test_a_bag_says_the_same_and_may_lack_it(unknown, stamped, tmp_path):
    signals = stamped({name: (unknown.t, x) for name, x in unknown.signals.items()})
    text = unknown.scenario.to_yaml()
    write_bag(tmp_path / 'whole', signals, 'unknown', text)
    whole = analyze(tmp_path / 'whole').report
    assert [each.generator for each in whole.learned] == ['exosystem', 'exosystem_2']
    assert whole.learned[0].locked_at == pytest.approx(unknown.report.learned[0].locked_at)
    plain = {name: each for name, each in signals.items() if '/' not in name}
    write_bag(tmp_path / 'plain', plain, 'unknown', text)
    assert analyze(tmp_path / 'plain').report.learned == ()
    assert analyze(tmp_path / 'plain').report.verdict == 'rejected'


def test_they_are_shown_after_the_signals_that_have_events():
    names = {'u_2/tau', 'u', 'u/tau', 'w', 'u_2', 'y', 'r1/y', 'lab/noise'}
    assert ordered(names) == [
        'w', 'y', 'u', 'u_2', 'lab/noise', 'r1/y', 'u/tau', 'u_2/tau',
    ]  # fmt: skip
    assert subject_by_name(names).plants[0].controls == ('u', 'u_2')
    assert with_events(names) == ['w', 'y', 'u', 'u_2', 'lab/noise', 'r1/y']
