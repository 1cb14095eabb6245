# SPDX-License-Identifier: Apache-2.0
"""Signals that came in few messages, as their receivers knew them; how many messages there were."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.coded import as_received, codings, held
from eventreg_ros.analysis.events import EventDetector
from eventreg_ros.analysis.live import LiveJudge
from eventreg_ros.analysis.messages import messages, words
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.timing import timing
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.runtime.tick_grid import TickGrid
from eventreg_ros.scenario import Scenario
from eventreg_ros.scenario.blocks import coding_of
from eventreg_ros.simulation.coding import Coder, Delta

H = 0.05


def recorded(scenario, run, path):
    """A bag of the run, in which coded outputs are the messages that real nodes would send."""
    stamps = TickGrid(scenario.rate).stamps(len(run.t))
    signals = {name: (stamps, x) for name, x in run.signals.items()}
    for node, values in scenario.nodes.items():
        coding, output = coding_of(values), scenario.output_of(node)
        if coding is not None:
            raw = simulate(scenario.with_given({node: {'send_on_delta': 0.0}}), float(run.t[-1]),
                           sampled=True)[output]  # fmt: skip
            coder, sent = Coder(coding, scenario.rate, H), []
            for stamp, value in zip(stamps, raw.tolist(), strict=True):
                coder(value)
                sent += [(stamp, message) for message in coder.take()]
            signals[output] = tuple(map(np.array, zip(*sent, strict=True)))
    write_bag(path, signals, scenario.name, scenario.to_yaml())
    return path


def test_what_was_sent_on_delta_is_held_and_no_silence_is_a_gap(tmp_path):
    # the exosystem alone is coded, so that what it sends does not depend on who listens
    scenario = load('exact', 'exosystem.send_on_delta:=0.2', '/**.input_timeout:=2.0')
    run = simulate(scenario, 240.0, sampled=True)
    analysis = analyze(recorded(scenario, run, tmp_path / 'bag'))
    report = analysis.report
    assert report.verdict == 'rejected', report.reason
    assert report.evidence.seen['w'] == 1.0
    few = report.signals['w'].samples
    assert few < 300
    assert report.signals['w'].timing.gaps == 0
    signal = analysis.signals['w']
    np.testing.assert_array_equal(signal.x[: len(run['w'])], run['w'][: len(signal.x)])
    count = len(report.signals['w'].events)
    assert messages(report)['w'] == (few, pytest.approx(few / 24.0), pytest.approx(few / count))
    assert f'w {few / 24.0:.3g} ({few / count:.3g})' in words(report)[0]
    energy = np.trapezoid(run['u'] ** 2, run.t)
    assert report.signals['u'].energy == pytest.approx(energy, rel=1e-9)
    assert f'u {energy:.3g} ({energy / count:.3g})' in words(report)[1]


def test_where_nothing_came_for_longer_than_is_meant_nothing_is_known():
    signal = Signal(np.array([0.0, 1.0, 9.0, 9.1]), np.array([1.0, 2.0, 3.0, 4.0]))
    t, x = held(signal, 5.0, 0.25, 9.6)
    assert t.tolist() == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0, 9.0, 9.1, 9.35])
    assert x.tolist() == [1.0] * 4 + [2.0, 3.0, 4.0, 4.0]
    assert len(held(signal, 5.0, 0.25, 30.0).t) == 7, 'nor at the end'


def test_a_silence_longer_than_the_heartbeat_is_a_gap():
    stamps = np.cumsum([0, 5, 250, 300, 600, 5, 5]) * 1_000_000
    assert timing(stamps, 0.375).gaps == 1
    assert timing(stamps, 0.275).gaps == 2


@pytest.mark.slow
def test_spikes_become_the_signal_that_the_plant_makes_of_them():
    scenario = load('late', 'controller.coding:=spikes')
    run = simulate(scenario, 300.0, sampled=True)
    # the messages are where the decoded u passes 0
    u, t = run['u'], run.t
    passes = np.flatnonzero((u[:-1] < 0.0) != (u[1:] < 0.0))
    passes = passes[u[passes] != 0.0]
    ago = H * u[passes + 1] / (u[passes + 1] - u[passes])
    sent = Signal(t[passes + 1], np.copysign(1.0 + ago, u[passes + 1]))
    found = as_received({'u': sent, 'y': Signal(t, run['y'])}, codings(scenario))
    made = found['u']
    late = made.t > 150.0
    expected = np.interp(made.t[late], t, u)
    assert np.sqrt(np.mean((made.x[late] - expected) ** 2)) < 0.05
    assert found['y'].x is run['y']


def test_a_single_spike_is_one_too():
    known = codings(load('late', 'controller.coding:=spikes'))
    t = np.arange(0.0, 30.0, H)
    sent = Signal(np.array([5.0]), np.array([-1.0]))
    made = as_received({'u': sent, 'y': Signal(t, np.zeros_like(t))}, known)['u']
    assert made.t[-1] > 29.0
    assert made.x[0] == 0.0
    assert -2.1 < made.x.min() < -1.5, 'a period of the generator, from where it falls through 0'


def test_after_the_message_that_the_sender_is_off_the_signal_is_0():
    known = codings(load('late', 'controller.coding:=spikes'))
    t = np.arange(0.0, 30.0, H)
    sent = Signal(np.array([5.0, 12.0]), np.array([-1.0, 0.0]))
    made = as_received({'u': sent, 'y': Signal(t, np.zeros_like(t))}, known)['u']
    assert np.abs(made.x[(made.t > 6.0) & (made.t < 11.9)]).min() > 0.5
    assert not made.x[made.t > 12.0].any()


def test_what_came_sample_by_sample_stays_as_it_is():
    scenario = load('exact', 'controller.send_on_delta:=0.1')
    run = simulate(scenario, 20.0, sampled=True)
    signals = {'u': Signal(run.t, run['u'])}
    found = as_received(signals, codings(scenario))['u']
    np.testing.assert_allclose(found.t, run.t, rtol=0.0, atol=1e-9)
    assert found.x.tobytes() == run['u'].tobytes()
    spikes = load('late', 'controller.coding:=spikes')
    assert as_received(signals, codings(spikes))['u'] is signals['u']


# The verdict while it runs: that on the recording


def messages_of(x, delta, beat):
    """(number, value) of what is sent."""
    coder, sent = Coder(Delta(delta, beat), 200.0, H), []
    for n, value in enumerate(x.tolist()):
        coder(value)
        sent += [(n, message) for message in coder.take()]
    return sent


def live_and_recorded(scenario, sent, path, until):
    """Verdict, shares seen and events of y of a monitor that hears ``sent``, and of a bag of it."""
    judge = LiveJudge.of(['w', 'y'], scenario.criteria, 10.0, scenario.to_yaml())
    detectors = {name: EventDetector(1.0, 0.0) for name in sent}
    heard = sorted((n, name, value) for name, each in sent.items() for n, value in each)
    found = {name: [] for name in sent}
    for n, name, value in heard:
        judge.saw(name, n / 200.0, value)
        for t, x in judge.points(name, n / 200.0, value):
            event = detectors[name].push(t, x)
            if event is not None:
                judge.event(name, event)
                found[name].append(event * 10.0)
    live = judge.verdict(until / 10.0)
    grid = TickGrid(200.0)
    signals = {name: (np.array([grid.stamp(n) for n, _ in each]), np.array([x for _, x in each]))
               for name, each in sent.items()}  # fmt: skip
    write_bag(path, signals, scenario.name, scenario.to_yaml())
    return live, found, analyze(path).report


@pytest.mark.parametrize('beat', [0.25, 1.0], ids=['2.5 of model time', '10, more than blind'])
def test_live_and_recorded_verdicts_on_messages_sent_on_delta_agree(tmp_path, beat):
    scenario = load('exact', '/**.send_on_delta:=0.1', f'/**.input_timeout:={2 * beat}')
    alone = {node: v for node, v in scenario.given.items() if node != 'controller'}
    scenario = Scenario.of('exact', alone)  # u is not recorded
    run = simulate('exact', 300.0, sampled=True)
    whole = {name: messages_of(run[name], 0.1, beat) for name in ('w', 'y')}
    live, events, report = live_and_recorded(scenario, whole, tmp_path / 'whole', 300.0)
    assert (live.decision.verdict, report.verdict) == ('rejected', 'rejected'), report.reason
    assert live.evidence.seen == report.evidence.seen == {'w': 1.0, 'y': 1.0}
    np.testing.assert_allclose(events['w'], report.signals['w'].events, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(events['w'], run.events['w'], rtol=0.0, atol=0.3)

    def silent(n, first=160.0, length=20.0):
        return first < n * H < first + length

    gap = {'w': whole['w'], 'y': [each for each in whole['y'] if not silent(each[0])]}
    live, _, report = live_and_recorded(scenario, gap, tmp_path / 'gap', 300.0)
    assert (live.decision.verdict, report.verdict) == ('undecided', 'undecided')
    assert live.evidence.unseen.keys() == report.evidence.unseen.keys() == {'y'}
    spans = (each.evidence.unseen['y'] for each in (live, report))
    np.testing.assert_allclose(*spans, rtol=0.0, atol=1e-6)
    assert report.signals['y'].timing.gaps == 1


@pytest.mark.slow
def test_the_lead_counts_when_w_and_u_are_compared(tmp_path):
    scenario = load('exact', 'controller.predict:=true', '/**.lead:=2.0')
    run = simulate(scenario, 400.0, sampled=True, delay=2.0, on='yu')
    assert run.report.synchronisation.max_abs < 0.02
