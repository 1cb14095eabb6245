# SPDX-License-Identifier: Apache-2.0
"""The verdict on a run that goes on: at every moment that on what was recorded until then."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.events import EventDetector
from eventreg_ros.analysis.evidence import UNSEEN
from eventreg_ros.analysis.live import LiveJudge
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_by_name, subject_of
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.scenario import Criteria, parse

SCALE = 10.0


class Monitor:
    """What the spike monitor does: detectors in seconds, and the judge."""

    def __init__(self, live, criteria):
        self.live, self.criteria = live, criteria
        self.detectors = {}

    @property
    def risen(self):
        return {signal: detector.risen for signal, detector in self.detectors.items()}

    def push(self, signal, seconds, value):
        detector = self.detectors.setdefault(
            signal, EventDetector(self.criteria.threshold, self.criteria.reset)
        )
        self.live.saw(signal, seconds, value)
        event = detector.push(seconds, value)
        if event is not None:
            self.live.event(signal, event)


def played(live, criteria, signals, asked):
    """Play signals to a monitor in the order of time; yield (t, verdict) at each of ``asked``."""
    monitor = Monitor(live, criteria)
    samples = sorted(
        (t, name, x)
        for name, s in signals.items()
        for t, x in zip(*map(np.ndarray.tolist, s), strict=True)
    )
    asked = list(asked)
    for t, name, x in samples:
        while asked and t > asked[0]:
            yield asked[0], live.verdict(asked[0] / SCALE, monitor.risen)
            asked.pop(0)
        monitor.push(name, t / SCALE, x)
    for t in asked:
        yield t, live.verdict(t / SCALE, monitor.risen)


def broken(signal, draw):
    """The signal with a few stretches gone and a few samples without a value."""
    t, x = signal
    keep, x = np.ones(len(t), dtype=bool), x.copy()
    for _ in range(draw.integers(0, 4)):
        start, length = draw.uniform(0.0, 260.0), draw.choice([1.0, 4.0, 6.0, 30.0])
        keep &= (t < start) | (t > start + length)
    x[draw.random(len(x)) < draw.choice([0.0, 0.05])] = np.nan
    return Signal(t[keep], x[keep])


@pytest.mark.parametrize('seed', range(30))
def test_at_every_moment_it_is_the_verdict_on_what_was_recorded_until_then(loop_signals, seed):
    draw = np.random.default_rng(seed)
    events = {
        name: sorted(draw.uniform(5.0, 250.0, draw.integers(0, high)).tolist())
        for name, high in (('w', 20), ('y', 3), ('y_r', 3))
    }
    signals = {n: broken(s, draw) for n, s in loop_signals(**events).items()}
    signals['w'] = Signal(np.append(0.0, signals['w'].t), np.append(-1.0, signals['w'].x))
    criteria = Criteria(settle=80.0, blind=5.0)
    live = LiveJudge.of(list(signals), criteria, SCALE)
    subject = subject_by_name(signals, criteria)
    for t, found in played(live, criteria, signals, [50.0, 100.0, 170.0, 260.0]):
        until = {n: Signal(s.t[s.t <= t], s.x[s.t <= t]) for n, s in signals.items()}
        if not len(until['y'].t):
            continue
        offline = judge(until, subject, until=max(t, 80.001))
        assert found.decision.rejection == offline.rejection
        assert (found.decision.verdict, found.t) == (offline.verdict, pytest.approx(t))
        if t > 80.0:
            assert found.evidence.seen == pytest.approx(offline.evidence.seen, abs=1e-9)
            assert found.decision.reason == offline.reason


def test_the_papers_loop():
    run = simulate('exact', 300.0, sampled=True)
    criteria = run.scenario.criteria
    live = LiveJudge.of(['w', 'y', 'u'], criteria, SCALE, run.scenario.to_yaml())
    signals = {name: Signal(run.t, x) for name, x in run.signals.items()}
    found = dict(played(live, criteria, signals, [150.0, 300.0]))
    assert found[150.0].decision.verdict == 'undecided'
    assert found[300.0].decision.verdict == 'rejected'
    assert found[300.0].decision.reason == run.reason
    assert found[300.0].decision.rejection == run.report.rejection


def test_several_plants_by_the_scenario():
    text = (
        'exosystem: {ros__parameters: {}}\nexosystem_2: {ros__parameters: {tau: 0.05}}\n'
        'plant_left: {ros__parameters: {excitatory: [w], inhibitory: []}}\n'
        'plant_right: {ros__parameters: {excitatory: [w_2], inhibitory: []}}\n'
    )
    scenario = parse(text, 'two')
    run = simulate(scenario, 250.0, sampled=True)
    live = LiveJudge.of(list(run.signals), scenario.criteria, SCALE, text)
    signals = {name: Signal(run.t, x) for name, x in run.signals.items()}
    ((_, found),) = played(live, scenario.criteria, signals, [250.0])
    assert [p.rejection for p in found.plants] == [p.rejection for p in run.report.plants]
    assert found.decision.reason == run.reason
    assert found.values()['y_right.spurious'] == str(run.report.plants[1].rejection.spurious)


def test_a_silent_signal_is_unseen_while_time_goes_on():
    live = LiveJudge.of(['w', 'y'], Criteria(settle=0.0), SCALE)
    for i in range(100):
        for name in ('w', 'y'):
            live.saw(name, 5.0 + 0.1 * i, 0.0)
    assert live.verdict(15.0).evidence.warnings == ()
    later = live.verdict(20.0)
    assert {w.code for w in later.evidence.warnings} == {UNSEEN}
    assert later.evidence.unseen['y'] == ((pytest.approx(99.0), 150.0),)


def test_model_time_begins_with_the_first_sample_and_goes_on_when_its_scale_changes():
    live = LiveJudge.of(['w', 'y'], Criteria(settle=0.0), SCALE)
    assert live.verdict(3.0).t == 0.0
    live.saw('other', 4.0, 0.0)
    live.saw('w', 5.0, 0.0)
    assert live.model_time(7.0) == 20.0
    live.rescale(7.0, 2.0)
    assert live.model_time(9.0) == 24.0
    live.event('w', 8.0)
    assert live.verdict(9.0).plants[0].rejection.disturbance_events == 1


def test_the_largest_part_of_the_margin_is_kept():
    live = LiveJudge.of(['w', 'y'], Criteria(), SCALE)
    assert live.verdict(0.0).margin_used is None
    for part in (0.1, 0.4, 0.2):
        live.note_margin(part)
    assert live.verdict(0.0).values()['margin_used'] == '0.400'


def test_without_an_output_there_is_nothing_to_judge():
    found = LiveJudge.of(['w'], Criteria(), SCALE).verdict(1.0)
    assert (found.decision.verdict, found.decision.reason) == (
        'undecided',
        'there is no plant to judge',
    )


def test_a_robot_in_its_namespace():
    text = ''.join(
        f'/r1/{n}: {{ros__parameters: {{}}}}\n' for n in ('exosystem', 'plant', 'reference')
    )
    whole, inside = parse(text, 'robots'), parse(text, 'robots').within('/r1')
    assert list(inside.nodes) == ['exosystem', 'plant', 'reference']
    assert subject_of(inside).plants[0].reference == 'y_r'
    assert subject_of(whole.within('/lab')) == subject_of(whole)
    live = LiveJudge.of(['w', 'y', 'y_r'], Criteria(), SCALE, text, '/r1')
    assert set(live.verdict(0.0).evidence.seen) == {'w', 'y', 'y_r'}
    assert load('exact').within('') == load('exact')
