# SPDX-License-Identifier: Apache-2.0
"""The report: its shape to the letter, and its figures against analytic ones."""

import json
import math

import numpy as np
import pytest

from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.analysis.report_table import table
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.verdict import EXIT_CODES, judge
from eventreg_ros.errors import EventregError
from eventreg_ros.scenario import Criteria

NOTHING = {'max_abs': None, 'rms': None}


def judged(signals, scenario='made', **criteria):
    there = [name for name, (t, _) in signals.items() if len(t)]
    return judge(signals, subject_by_name(there, Criteria(**criteria), scenario=scenario))


def report(signals, **criteria):
    return as_json(judged(signals, **criteria))


def uneven(end=400.0, n=20000, seed=7):
    """Model times from 0 to ``end``, some nine times as far apart as others."""
    shift = np.random.default_rng(seed).uniform(-0.4, 0.4, n - 1)
    return np.concatenate([[0.0], (np.arange(1, n) + shift) * (end / n), [end]])


@pytest.fixture
def rejected(loop_signals):
    return loop_signals(w=[110, 150, 190, 230], y=[], u=[111, 151, 191, 231])


def test_the_shape_is_the_contract(rejected):
    result = report(rejected)
    assert list(result) == [
        'scenario', 'time_scale', 'duration', 'settle', 'verdict', 'reason', 'evidence',
        'rejection', 'residual', 'synchronisation', 'signals',
    ]  # fmt: skip
    assert list(result['rejection']) == [
        'disturbance_events', 'reference_events', 'preserved', 'spurious', 'missed', 'ratio',
    ]  # fmt: skip
    for key in ('residual', 'synchronisation'):
        assert list(result[key]) == ['max_abs', 'rms']
    assert list(result['signals']) == ['w', 'y', 'u']
    for entry in result['signals'].values():
        assert list(entry) == ['samples', 'min', 'max', 'events']


def test_the_values_of_a_run_that_is_known(rejected):
    result = report(rejected, settle=120.0)
    assert result['scenario'] == 'made'
    assert (result['time_scale'], result['duration'], result['settle']) == (10.0, 260.0, 120.0)
    assert result['verdict'] == 'rejected'
    assert result['rejection'] == {
        'disturbance_events': 3, 'reference_events': 0, 'preserved': 0, 'spurious': 0, 'missed': 0,
        'ratio': 1.0,
    }  # fmt: skip
    w = result['signals']['w']
    assert (w['samples'], w['min'], w['max']) == (1301, -1.0, pytest.approx(2.6))
    assert w['events'] == pytest.approx([110, 150, 190, 230], abs=1e-9)  # of the whole run
    assert result['residual'] == {'max_abs': 1.0, 'rms': pytest.approx(1.0)}  # y rests at -1


def test_json_without_nan(rejected):
    t = rejected['w'][0]
    rough = {
        **rejected,
        'v': (t, np.full(len(t), np.nan)),
        'y_r': (t, np.where(t > 50.0, np.inf, 0.0)),
        'extra': (np.empty(0), np.empty(0)),
        'huge': (t, np.where(t > 200.0, 1e308, -1e308)),
    }
    text = json.dumps(report(rough), allow_nan=False)
    signals = json.loads(text)['signals']
    assert (signals['v']['min'], signals['v']['samples']) == (None, len(t))
    assert signals['y_r']['max'] == 0.0
    assert signals['extra'] == {'samples': 0, 'min': None, 'max': None, 'events': []}
    assert signals['huge']['max'] == 1e308


def test_differences_that_overflow_are_none_or_finite():
    t = np.arange(300.0)
    big = np.full(300, 1e308)
    assert report({'y': (t, big), 'y_r': (t, -big)})['residual'] == NOTHING
    result = report({'y': (t, big)})['residual']
    assert result == {'max_abs': 1e308, 'rms': pytest.approx(1e308)}


def test_signals_stand_in_the_papers_order_then_by_name():
    t = np.arange(3.0)
    names = ['zeta', 'u', 'y_r', 'alpha', 'y', 'v', 'w']
    result = report(dict.fromkeys(names, (t, t)))
    assert list(result['signals']) == ['w', 'v', 'y', 'y_r', 'u', 'alpha', 'zeta']


# Residual and synchronisation -------------------------------------------------------------------


def test_residual_and_synchronisation_of_uneven_samples_against_integrals():
    t, s = uneven(seed=7), uneven(seed=8)
    signals = {
        'y': (t, 0.3 * np.sin(t)),
        'y_r': (s, 0.1 * np.sin(s)),
        'w': (t, np.cos(t) + 0.05),
        'u': (s, np.cos(s)),
    }
    for settle in (0.0, 100.0, 250.0):
        result = report(signals, settle=settle)
        mean = 0.5 - (math.sin(800.0) - math.sin(2 * settle)) / (4 * (400.0 - settle))  # of sin^2
        assert result['residual']['max_abs'] == pytest.approx(0.2, abs=2e-4)
        assert result['residual']['rms'] == pytest.approx(0.2 * math.sqrt(mean), rel=1e-3)
        assert result['synchronisation']['max_abs'] == pytest.approx(0.05, abs=2e-4)
        assert result['synchronisation']['rms'] == pytest.approx(0.05, rel=1e-3)


def test_the_rms_weighs_time_not_samples():
    t = np.concatenate([np.linspace(100.0, 101.0, 10001), np.linspace(101.0, 200.0, 100)[1:]])
    y = np.where(t <= 101.0, 1.0, 0.0)
    rms = report({'y': (t, y)})['residual']['rms']
    assert rms == pytest.approx(math.sqrt(1.5 / 100.0), rel=1e-6)  # 1, then down within 1


def test_the_second_signal_is_a_line_between_its_samples():
    t = np.linspace(0.0, 200.0, 4001)
    s = np.linspace(0.0, 200.0, 11)
    result = report({'y': (t, 2.0 * t), 'y_r': (s, 2.0 * s + 0.5)})
    assert result['residual'] == pytest.approx({'max_abs': 0.5, 'rms': 0.5})


def test_where_the_second_signal_is_unknown_nothing_is_compared():
    t = np.linspace(0.0, 200.0, 2001)
    s = t[(t > 120.0) & (t < 150.0)]
    result = report({'y': (t, np.where((t > 120) & (t < 150), 0.25, 9.0)), 'y_r': (s, 0.0 * s)})
    assert result['residual'] == pytest.approx({'max_abs': 0.25, 'rms': 0.25})


def test_settling_is_left_out():
    t = np.linspace(0.0, 200.0, 2001)
    y = np.where(t < 100.0, 7.0, 0.5)
    assert report({'y': (t, y)})['residual'] == pytest.approx({'max_abs': 0.5, 'rms': 0.5})
    assert report({'y': (t, y)}, settle=300.0)['residual'] == NOTHING


def test_samples_that_are_not_finite_are_left_out_of_differences():
    t = np.linspace(0.0, 200.0, 2001)
    y, y_r = np.full(2001, 0.5), np.zeros(2001)
    y[1500], y_r[1600] = np.nan, np.inf
    result = report({'y': (t, y), 'y_r': (t, y_r)})
    assert result['residual'] == pytest.approx({'max_abs': 0.5, 'rms': 0.5})


def test_a_single_sample_after_settling():
    t = np.array([0.0, 100.0])
    assert report({'y': (t, np.array([3.0, -0.5]))})['residual'] == {'max_abs': 0.5, 'rms': 0.5}


# Missing signals --------------------------------------------------------------------------------


def test_without_a_reference_the_residual_is_y():
    t = np.linspace(0.0, 200.0, 2001)
    alone = {'y': (t, np.full(2001, 0.5))}
    empty = {**alone, 'y_r': (np.empty(0), np.empty(0))}  # announced, but nothing came
    for signals in (alone, empty):
        assert report(signals)['residual'] == pytest.approx({'max_abs': 0.5, 'rms': 0.5})


@pytest.mark.parametrize('present', ['w', 'u', ''])
def test_without_w_or_u_there_is_no_synchronisation(rejected, present):
    signals = {name: s for name, s in rejected.items() if name in ('y', present)}
    assert report(signals)['synchronisation'] == NOTHING
    empty = {**signals, 'u': (np.empty(0), np.empty(0))}
    assert report(empty)['synchronisation'] == NOTHING


def test_without_w_nothing_is_decided(loop_signals):
    result = report(loop_signals(y=[150, 200, 250]))
    assert (result['verdict'], result['rejection']['ratio']) == ('undecided', None)
    assert result['rejection']['spurious'] == 3


@pytest.mark.parametrize('empty', [True, False])
def test_without_y_there_is_nothing_to_judge(rejected, empty):
    signals = {**rejected, 'y': (np.empty(0), np.empty(0))}
    if not empty:
        del signals['y']
    with pytest.raises(EventregError) as caught:
        report(signals)
    assert '(signals found: w, u); record or remap it' in str(caught.value)


# The verdict and the table ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('y', 'y_r', 'verdict'),
    [
        ([], [], 'rejected'),
        ([150], [], 'not rejected'),
        ([150], [153], 'rejected'),
        ([150], [156], 'not rejected'),
        ([], [150], 'not rejected'),
        ([50], [], 'rejected'),
    ],
)
def test_the_verdict_follows_from_events_after_settling(loop_signals, y, y_r, verdict):
    signals = loop_signals(w=[110, 160, 210], y=y, y_r=y_r, u=[])
    assert report(signals)['verdict'] == verdict


def test_threshold_reset_and_window_are_used(loop_signals):
    signals = loop_signals(w=[110, 160, 210], y=[150], y_r=[156])
    assert report(signals, window=6.0)['verdict'] == 'rejected'
    assert report(signals, threshold=3.5)['verdict'] == 'undecided'
    assert len(report(signals, reset=-0.5)['signals']['w']['events']) == 3
    assert len(report(signals, reset=-1.5)['signals']['w']['events']) == 1  # at rest at -1


def test_exit_codes_are_the_contract():
    assert EXIT_CODES == {'rejected': 0, 'not rejected': 1, 'undecided': 3}


def test_the_table_says_what_the_report_says(rejected):
    text = table(judged(rejected))
    lines = text.splitlines()
    assert lines[0] == 'made: 260.0 model time units, counted after 100'
    assert [line.split()[0] for line in lines[2:5]] == ['w', 'y', 'u']
    assert lines[2].split()[-2:] == ['4', '4']
    assert 'disturbance events 4, spurious 0, rejection ratio 1.00' in lines
    assert 'residual y: max 1, rms 1' in lines
    assert lines[-2:] == ['after t = 100 w had 4 events; none made y spike', 'verdict: rejected']


def test_the_table_speaks_of_a_reference_only_where_there_is_one(loop_signals):
    text = table(judged(loop_signals(w=[110, 150, 190], y=[131], y_r=[130, 200], u=[])))
    assert 'disturbance events 3, reference events 2, preserved 1, spurious 0, missed 1, ' in text
    assert 'rejection ratio 1.00' in text
    assert 'residual y - y_r: max' in text
    assert 'synchronisation w - u: max' in text


def test_the_table_has_no_words_for_what_is_missing(loop_signals):
    lines = table(judged(loop_signals(y=[]))).splitlines()
    assert lines[-1] == 'verdict: undecided'
    assert lines[-4:-1] == [
        'disturbance events 0, spurious 0', 'residual y: max 1, rms 1',
        'nothing disturbs y: there is no w; add an exosystem',
    ]  # fmt: skip
