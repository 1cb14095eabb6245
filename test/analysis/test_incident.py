# SPDX-License-Identifier: Apache-2.0
"""The first unwanted event, and what happened around it."""

from dataclasses import replace

import pytest

from eventreg_ros.analysis.changes import Change
from eventreg_ros.analysis.incident import MOST, Neighbour, first_incident, words
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.bags.finding import Finding
from eventreg_ros.scenario import Criteria

W = [50, 110, 150, 190, 230]


def incident(signals, changes=(), findings=(), noted=(), **criteria):
    subject = subject_by_name(signals, Criteria(**criteria))
    report = judge(signals, subject, changes=changes, findings=findings)
    return first_incident(report, signals, noted)


def test_without_an_unwanted_event_there_is_none(loop_signals):
    assert incident(loop_signals(w=W, y=[60, 151], y_r=[150])) is None


@pytest.mark.parametrize(
    ('y', 'y_r', 'kind', 't'),
    [
        ([60, 130, 151, 200], [150], 'spurious', 130.0),
        ([60, 200], [150], 'missed', 150.0),
        ([130], [150, 210], 'spurious', 130.0),
    ],
)
def test_it_is_the_first_of_those_that_count(loop_signals, y, y_r, kind, t):
    found = incident(loop_signals(w=W, y=y, y_r=y_r))
    assert (found.kind, found.t) == (kind, pytest.approx(t))
    assert found.span == pytest.approx((t - 15.0, t + 15.0))


def test_of_several_plants_it_is_that_of_the_first_in_time(loop_signals):
    found = incident(loop_signals(w=W, y_left=[180], y_right=[125]))
    assert (found.plant.output, found.t) == ('y_right', pytest.approx(125.0))


def test_its_neighbours_are_the_nearest_events(loop_signals):
    found = incident(loop_signals(w=W, y=[130], u=[112]))
    near = {n.signal: n for n in found.neighbours}
    assert near['w'] == Neighbour('w', pytest.approx(20.0), pytest.approx(20.0))
    assert near['u'] == Neighbour('u', pytest.approx(18.0), None)
    assert near['y'] == Neighbour('y', None, None)
    assert words(found, 10.0)[-1] == (
        'The nearest other events: w 20.00 before and 20.00 after; u 18.00 before.'
    )


def test_missing_samples_are_counted_and_timed(loop_signals):
    signals = loop_signals(w=W, y=[130])
    t, y = signals['y']
    keep = (t < 126.0 - 1e-9) | (t > 127.0 + 1e-9)
    signals['y'] = (t[keep], y[keep])
    found = incident(signals)
    stream = next(s for s in found.streams if s.signal == 'y')
    assert (stream.missing, stream.at) == (6, pytest.approx(125.8))
    assert (stream.longest, stream.usual) == (pytest.approx(1.4), pytest.approx(0.2))
    said = words(found, 10.0)
    assert (
        '6 samples of y missing: the longest interval is 1.4 (140 ms) from t = 125.80, the usual '
        'one 0.2.'
    ) in said
    whole = words(incident(loop_signals(w=W, y=[130])), 10.0)
    assert 'No sample is missing around it.' in whole
    assert not any('missing:' in line for line in whole)


def test_changes_within_and_the_last_before_are_named(loop_signals):
    changes = [Change(t, 'controller', f'k:={t:g}') for t in (20.0, 40.0, 128.0, 140.0, 200.0)]
    found = incident(loop_signals(w=W, y=[130]), changes)
    assert [change.at for change in found.changes] == [40.0, 128.0, 140.0]
    said = words(found, 10.0)
    assert said[0] == 'y has an event at t = 130.0000 that nothing asks for.'
    assert said[1:4] == [
        'controller.k:=40 at t = 40.0, 90.0 before it.',
        'controller.k:=128 at t = 128.0, 2.0 before it.',
        'controller.k:=140 at t = 140.0, 10.0 after it.',
    ]


def test_findings_near_it_are_reported_the_nearest_of_many(loop_signals):
    here = [Finding('lone-sample', 'y', 128.0, 'odd'), Finding('damaged', None, None, 'cut')]
    late = [Finding('node-warning', 'plant', 116.0 + i, f'late {i}') for i in range(12)]
    found = incident(loop_signals(w=W, y=[130]), (), here, late)
    assert len(found.findings) == MOST
    assert [f.at for f in found.findings] == [123.0, 124.0, 125.0, 126.0, 127.0, 128.0]
    assert 'At t = 128.0: odd.' in words(found, 10.0)


def test_a_window_of_no_length_still_shows_something(loop_signals):
    signals = loop_signals(w=W, y=[130])
    found = incident(signals, window=0.0)
    assert found.span == pytest.approx((130.0 - 13.0, 130.0 + 13.0))


def test_signals_too_short_to_say_are_left_out(loop_signals):
    signals = loop_signals(w=W, y=[130])
    signals['u'] = tuple(a[:2] for a in signals['w'])
    assert {s.signal for s in incident(signals).streams} == {'w', 'y'}
    report = judge(signals, subject_by_name(signals))
    assert first_incident(replace(report, plants=()), signals) is None
