# SPDX-License-Identifier: Apache-2.0
"""The verdict for CI: whole XML whatever the names hold, a case for each plant."""

from xml.etree import ElementTree

import numpy as np
import pytest

from eventreg_ros.analysis.junit import as_junit
from eventreg_ros.analysis.report_table import table
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.bags.finding import Finding

W = [110, 150, 190, 230]


def report(signals, scenario='made', findings=()):
    return judge(signals, subject_by_name(signals, scenario=scenario), findings=findings)


@pytest.mark.parametrize(
    ('events', 'counts', 'child'),
    [
        ({'w': W, 'y': []}, ('1', '0', '0'), None),
        ({'w': W, 'y': [130]}, ('1', '1', '0'), ('failure', 'not rejected')),
        ({'w': W[:2], 'y': []}, ('1', '0', '1'), ('error', 'undecided')),
    ],
)
def test_a_case_for_the_plant(loop_signals, events, counts, child):
    found = report(loop_signals(**events))
    root = ElementTree.fromstring(as_junit(found))
    (suite,) = root
    for element in (root, suite):
        assert tuple(element.get(n) for n in ('tests', 'failures', 'errors')) == counts
        assert element.get('time') == '26.000'
    (case,) = suite.findall('testcase')
    assert (case.get('classname'), case.get('name')) == ('made', 'events of y are rejected')
    assert [(c.tag, c.get('type')) for c in case] == ([child] if child else [])
    assert [c.get('message') for c in case] == ([found.reason] if child else [])
    assert suite.find('system-out').text == table(found)
    assert suite.find('system-err') is None


def test_several_plants_are_several_cases(loop_signals):
    found = report(loop_signals(w=W, y_left=[130], y_right=[]))
    (suite,) = ElementTree.fromstring(as_junit(found))
    assert (suite.get('tests'), suite.get('failures'), suite.get('errors')) == ('2', '1', '0')
    assert [len(case) for case in suite.findall('testcase')] == [1, 0]


def test_whatever_names_and_findings_hold_it_is_xml(loop_signals):
    hostile = ']]></x>&"\'<\x00\x1b\ud800\uffff'
    text = as_junit(
        report(loop_signals(w=W, y=[]), hostile, [Finding('checksum', None, None, hostile)])
    )
    (suite,) = ElementTree.fromstring(text.encode('utf-8'))
    shown = ']]></x>&"\'<????'
    assert suite.find('testcase').get('classname') == shown
    assert suite.find('system-err').text == shown
    assert np.all([ord(letter) >= 32 or letter == '\n' for letter in text])
