# SPDX-License-Identifier: Apache-2.0
"""No verdict without evidence: what was not seen is never called rejected, and what was stays."""

import random

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.evidence import (
    ENDS_EARLY,
    NOT_FINITE,
    STUCK,
    THIN,
    UNSEEN,
    coverage_of,
    gather,
)
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import JudgedPlant, Subject, subject_by_name
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.bags.finding import IMPAIRING, Finding
from eventreg_ros.scenario import Criteria

W = [110, 150, 190, 230]
Y = Subject(plants=(JudgedPlant('y'),))


@pytest.fixture
def loop(loop_signals):
    """Signals with events at the given times; w has four after 100."""

    def make(**events):
        return loop_signals(**{'w': W, 'y': [], **events})

    return make


def report(signals, findings=(), lenient=False, until=None, **criteria):
    subject = subject_by_name(signals, Criteria(**criteria))
    return judge(signals, subject, findings=findings, lenient=lenient, until=until)


def without(signals, name, *stretches):
    """The signals with the samples of one of them gone from within the stretches."""
    t, x = signals[name]
    gone = np.any([(t > a) & (t < b) for a, b in stretches], axis=0)
    return {**signals, name: Signal(t[~gone], x[~gone])}


def nan(signals, name, *stretches):
    t, x = signals[name]
    gone = np.any([(t > a) & (t < b) for a, b in stretches], axis=0)
    return {**signals, name: Signal(t, np.where(gone, np.nan, x))}


# What is unseen -----------------------------------------------------------------------------------


def brute_force(t, span, blind, at):
    """Say of each time of ``at`` whether no sample says what was then: the contract, by points."""
    before = np.array([max((s for s in t if s <= x), default=-np.inf) for x in at])
    after = np.array([min((s for s in t if s >= x), default=np.inf) for x in at])
    edge = np.where(np.isinf(before), span[0], before), np.where(np.isinf(after), span[1], after)
    return (edge[1] - edge[0] > blind) & (after > before)


@pytest.mark.slow
def test_unseen_is_what_no_two_samples_enclose():
    draw = random.Random(2)
    for _ in range(300):
        t = np.array(sorted(draw.uniform(-20, 120) for _ in range(draw.randrange(1, 40))))
        start = draw.uniform(0, 50)
        span, blind = (start, start + draw.uniform(1, 60)), draw.uniform(0.5, 30)
        subject = Subject(plants=(JudgedPlant('y'),), criteria=Criteria(blind=blind))
        coverage = coverage_of(Signal(t, np.zeros(len(t))), blind)
        found = gather(subject, {'y': coverage}, span, span[1])
        at = np.linspace(*span, 400)[1:-1]
        inside = [any(a < x < b for a, b in found.unseen.get('y', ())) for x in at]
        assert inside == brute_force(t, span, blind, at).tolist()
        share = 1.0 - sum(b - a for a, b in found.unseen.get('y', ())) / (span[1] - span[0])
        assert found.seen['y'] == pytest.approx(share)


@pytest.mark.parametrize('signal', ['y', 'w', 'y_r'])
@pytest.mark.parametrize('lose', [without, nan])
@pytest.mark.parametrize('where', [(120, 130), (-1, 106), (254, 261), (97, 103)])
def test_a_signal_that_decides_must_be_seen_throughout(loop, signal, lose, where):
    signals = loop(w=[*W, 240, 245], y_r=[])
    assert report(signals).verdict == 'rejected'
    found = report(lose(signals, signal, where))
    assert found.verdict == 'undecided'
    (warning,) = found.evidence.warnings
    assert (warning.code, warning.signal) == (UNSEEN, signal)
    assert warning.at >= 100.0
    assert f'{signal} was not seen' in found.reason
    assert found.evidence.seen[signal] < 1.0 == found.evidence.seen[{'y': 'w'}.get(signal, 'y')]


@pytest.mark.parametrize('signal', ['y', 'w', 'y_r'])
def test_a_signal_without_a_finite_sample_was_not_seen_at_all(loop, signal):
    found = report(nan(loop(y_r=[]), signal, (-1, 261)))
    assert found.verdict == 'undecided'
    assert found.reason.endswith(f'{signal} was not seen at all')
    assert found.evidence.seen[signal] == 0.0


@pytest.mark.parametrize('where', [(120, 125), (-1, 95), (-1, 104.7), (255.1, 261), (20, 80)])
def test_what_is_shorter_than_blind_or_outside_of_the_span_is_seen(loop, where):
    found = report(without(loop(), 'y', where))
    assert (found.verdict, found.evidence.warnings) == ('rejected', ())
    assert found.evidence.seen == {'w': 1.0, 'y': 1.0}


def test_blind_may_be_set(loop):
    signals = without(loop(), 'y', (120, 123))
    assert report(signals).verdict == 'rejected'
    assert report(signals, blind=2.0).verdict == 'undecided'
    assert report(without(loop(), 'y', (120, 140)), blind=25.0).verdict == 'rejected'


def test_a_few_samples_that_are_not_finite_are_worth_a_word(loop):
    found = report(nan(loop(), 'y', (120, 121)))
    (warning,) = found.evidence.warnings
    assert (found.verdict, warning.code) == ('rejected', NOT_FINITE)
    assert warning.text == '4 samples of y are not finite'


def test_the_control_need_not_be_seen(loop):
    signals = without(loop(u=W), 'u', (120, 200))
    assert report(signals).verdict == 'rejected'


def test_the_stretches_are_counted_and_the_first_is_named(loop):
    found = report(without(loop(), 'y', (120, 130), (160, 180), (200, 210)))
    (warning,) = found.evidence.warnings
    assert warning.at == pytest.approx(120.0)
    assert warning.text == (
        'y was not seen for 40.0 of 160.0 units of model time: from 120.0 to 130.0 and 2 more such '
        'stretches'
    )
    assert found.evidence.seen['y'] == pytest.approx(120 / 160)


# What was seen stays ------------------------------------------------------------------------------


def test_a_spurious_event_that_was_seen_stays(loop):
    signals = without(loop(y=[200]), 'y', (120, 130))
    found = report(signals)
    assert found.verdict == 'not rejected'
    assert len(found.evidence.warnings) == 1
    assert found.reason == 'after t = 100 y had 1 event that nothing asks for, the first at 200.0'
    damaged = report(loop(y=[200]), [Finding('checksum', None, None, 'a chunk is broken')])
    assert damaged.verdict == 'not rejected'


def test_an_event_is_missed_only_where_y_was_seen(loop):
    signals = loop(y_r=[170], y=[170])
    assert report(without(signals, 'y', (165, 180))).verdict == 'undecided'
    assert report(without(loop(y_r=[170], y=[]), 'y', (200, 220))).verdict == 'not rejected'


def test_too_few_events_of_w_say_what_was_not_seen_of_it(loop):
    found = report(without(loop(w=W[:2]), 'w', (180, 240)))
    assert found.verdict == 'undecided'
    assert found.reason == (
        '2 events of w after 100, 3 are needed: run longer; w was not seen for 60.0 of 160.0 units '
        'of model time: from 180.0 to 240.0'
    )


def test_lenient_judges_what_was_seen(loop):
    signals = without(loop(), 'y', (120, 130))
    found = report(signals, lenient=True)
    assert found.verdict == 'rejected'
    assert 'as far as it was seen: y was not seen for 10.0' in found.reason
    assert len(found.evidence.warnings) == 1
    assert report(without(loop(w=W[:2]), 'y', (120, 130)), lenient=True).verdict == 'undecided'
    missed = without(loop(y_r=[170], y=[170]), 'y', (165, 180))
    assert report(missed, lenient=True).verdict == 'not rejected'


# Thin, short, damaged -----------------------------------------------------------------------------


def sparse(signals, name, every):
    t, x = signals[name]
    return {**signals, name: Signal(t[::every], x[::every])}


def slow(period, name='y'):
    """Spikes of 12 units every 40; one signal comes every ``period`` only."""
    t = np.arange(0.0, 400.0, 0.05)
    w = np.where(t % 40.0 < 12.0, 2.0, -1.0)
    signals = {'w': Signal(t, w), 'y': Signal(t, np.full(len(t), -1.0))}
    return sparse(signals, name, round(period / 0.05))


@pytest.mark.parametrize('name', ['w', 'y'])
@pytest.mark.parametrize(('period', 'verdict'), [(2.9, 'rejected'), (4.5, 'undecided')])
def test_a_spike_must_hold_four_samples(name, period, verdict):
    found = report(slow(period, name))
    assert found.verdict == verdict
    assert [w.code for w in found.evidence.warnings] == ([] if verdict == 'rejected' else [THIN])
    if verdict == 'undecided':
        assert f'{name} is sampled too thinly: one sample every {period:g}' in found.reason


def test_no_sample_in_blind_is_too_thin_whatever_the_spikes_are():
    assert report(slow(2.0), blind=1.5).verdict == 'undecided'


def up(signals, name, start, stop, value=2.0):
    """The signals with one of them held at ``value`` from ``start`` to ``stop``."""
    t, x = signals[name]
    return {**signals, name: Signal(t, np.where((t >= start) & (t < stop), value, x))}


@pytest.mark.parametrize(
    ('stretch', 'verdict', 'codes'),
    [
        ((50.0, 999.0), 'undecided', [STUCK]),
        ((0.0, 999.0), 'undecided', [STUCK]),  # above from the start
        ((0.0, 99.0), 'rejected', []),
        ((90.0, 120.0), 'rejected', []),  # it came back, and then could be seen to rise
        ((105.0, 999.0), 'not rejected', []),  # its rise is an event
        ((50.0, 999.0, 0.9), 'rejected', []),  # above reset only
    ],
)
def test_an_output_that_stays_up_is_not_called_rejected(loop, stretch, verdict, codes):
    found = report(up(loop(), 'y', *stretch))
    assert (found.verdict, [w.code for w in found.evidence.warnings]) == (verdict, codes)
    assert report(up(loop(), 'y', *stretch), lenient=True).verdict != 'undecided'
    if codes:
        assert f'above its threshold all the time since {stretch[0]:.1f}, so' in found.reason


@pytest.mark.parametrize(
    ('end', 'verdict', 'codes'),
    [(-1.1e6, 'undecided', [STUCK]), (-0.9e6, 'rejected', []), (-1e300, 'undecided', [STUCK])],
)
def test_an_output_that_fell_out_of_all_bounds_is_not_called_rejected(loop, end, verdict, codes):
    found = report(up(loop(y_r=[]), 'y', 150.0, 999.0, end))
    assert (found.verdict, [w.code for w in found.evidence.warnings]) == (verdict, codes)
    back = report(up(loop(), 'y', 150.0, 200.0, end))
    assert back.verdict == 'rejected', 'it came back, and then could be seen to rise'
    larger = report(up(loop(w=[]), 'y', 150.0, 999.0, end), threshold=9.0)
    assert not larger.evidence.warnings or end < -9e6


def test_an_output_that_stays_up_as_its_reference_does_is_judged(loop):
    signals = up(loop(y_r=[]), 'y', 50.0, 999.0)
    assert report(signals).verdict == 'undecided'
    assert report(up(signals, 'y_r', 60.0, 999.0)).verdict == 'rejected'
    assert report(up(signals, 'y_r', 60.0, 150.0)).verdict == 'undecided'


@pytest.mark.slow
def test_a_loop_that_diverges_at_once_is_not_called_rejected():
    for plant, up in ([0.0], True), ([-1.0], False):
        run = simulate('linear', {'controller.gain': [-3.0, 2.0], 'plant.x0': plant})
        assert (run['y'][-1] > 1e200) == up
        assert run['y'].max() < 1.0 or up
        assert run.verdict == 'undecided'


def test_an_event_of_y_is_spurious_only_where_its_reference_was_seen(loop):
    signals = loop(y=[130.0, 170.0], y_r=[130.0, 170.0])
    assert report(signals).verdict == 'rejected'
    assert report(without(signals, 'y_r', (160.0, 185.0))).verdict == 'undecided'
    assert report(without(signals, 'y_r', (200.0, 215.0))).verdict == 'undecided'
    alone = loop(y=[130.0, 170.0], y_r=[130.0])
    assert report(alone).verdict == 'not rejected'
    assert report(without(alone, 'y_r', (200.0, 215.0))).verdict == 'not rejected'


def test_a_recording_that_ends_before_the_scenario_asks_for_is_undecided(loop):
    signals = loop()
    subject = subject_by_name(signals)
    for duration, verdict in ((260.0, 'rejected'), (264.0, 'rejected'), (300.0, 'undecided')):
        wanted = Subject(plants=subject.plants, duration=duration)
        found = judge(signals, wanted)
        assert found.verdict == verdict
        assert [w.code for w in found.evidence.warnings] == (
            [ENDS_EARLY] if verdict == 'undecided' else []
        )
    assert (
        found.reason == 'the recording ends at 260.0, and the scenario asks for 300 of model time'
    )


@pytest.mark.parametrize('code', sorted(IMPAIRING))
def test_samples_known_to_be_lost_or_wrong_withhold_the_verdict(loop, code):
    for signal, verdict in ((None, 'undecided'), ('y', 'undecided'), ('u', 'rejected')):
        finding = Finding(code, signal, 14.2, 'something is wrong')
        found = report(loop(u=W), [finding])
        assert found.verdict == verdict
        assert found.evidence.warnings == (finding,)
        assert as_json(found)['evidence']['warnings'] == [
            {'code': code, 'signal': signal, 'at': 14.2, 'text': 'something is wrong'}
        ]


def test_a_finding_that_costs_no_sample_is_only_a_word(loop):
    found = report(loop(), [Finding('no-end', None, 26.0, 'the writer was killed')])
    assert (found.verdict, len(found.evidence.warnings)) == ('rejected', 1)


# The span -----------------------------------------------------------------------------------------


def test_only_the_span_is_judged(loop):
    signals = loop(w=[110, 150, 190, 230], y=[105, 245])
    assert report(signals).rejection.spurious == 2
    found = report(signals, settle=108.0, until=240.0)
    assert (found.verdict, found.evidence.span) == ('rejected', (108.0, 240.0))
    assert found.rejection.disturbance_events == 4
    assert found.signals['y'].events == pytest.approx((105, 245))
    assert report(signals, until=200.0).rejection.disturbance_events == 3
    t = signals['y'][0]
    quiet = {**signals, 'y': Signal(t, np.where(t > 150.0, 3.0, -1.0))}
    assert report(quiet, until=140.0).residual == (1.0, pytest.approx(1.0))


def test_an_end_beyond_the_recording_was_not_seen(loop):
    found = report(loop(), until=280.0)
    assert found.verdict == 'undecided'
    assert found.evidence.unseen == {name: ((pytest.approx(260.0), 280.0),) for name in ('w', 'y')}


def test_a_run_that_ends_before_settling(loop):
    found = report(loop(), settle=600.0)
    assert (found.verdict, found.evidence.span) == ('undecided', (600.0, 600.0))
    assert found.reason == 'there is nothing after 600, from when on events count: run longer'
    assert found.evidence.seen == {'w': 0.0, 'y': 0.0}


# Reasons ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('events', 'reason'),
    [
        ({}, 'after t = 100 w had 4 events; none made y spike'),
        ({'y': [130, 170], 'y_r': [131, 171]},
         'after t = 100 w had 4 events; y had the 2 events of y_r and no other'),
        ({'w': [110, 150]}, '2 events of w after 100, 3 are needed: run longer'),
        ({'w': [110], 'w_2': [111]}, '2 events of w and w_2 after 100, 3 are needed: run longer'),
        ({'y': [130], 'y_r': [170]},
         'after t = 100 y had 1 event that nothing asks for, the first at 130.0; '
         'y missed 1 event of y_r, the first at 170.0'),
        ({'y': [130], 'v': []},
         'after t = 100 y had 1 event that nothing asks for, the first at 130.0; stimulus without '
         'reference: events that v asks for count as spurious; add `reference:` to the file'),
    ],
)  # fmt: skip
def test_every_verdict_has_its_reason_in_words(loop, events, reason):
    assert report(loop(**events)).reason == reason


def test_json_gives_span_shares_and_warnings(loop):
    found = as_json(report(without(loop(), 'y', (120, 130))))
    assert list(found['evidence']) == ['span', 'seen', 'warnings']
    assert found['evidence']['span'] == [100.0, pytest.approx(260.0)]
    assert found['evidence']['seen'] == {'w': 1.0, 'y': pytest.approx(150 / 160)}
    (warning,) = found['evidence']['warnings']
    assert list(warning) == ['code', 'signal', 'at', 'text']
