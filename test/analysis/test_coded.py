"""Signals that came in few messages, as their receivers knew them; how many messages there were."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.coded import as_received, held
from eventreg_ros.analysis.messages import messages, words
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.runtime.tick_grid import TickGrid
from eventreg_ros.scenario.blocks import coding_of
from eventreg_ros.simulation.coding import Coder

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
    assert f'w {few / 24.0:.3g} ({few / count:.3g})' in words(report)


def test_where_nothing_came_for_longer_than_is_meant_nothing_is_known():
    signal = Signal(np.array([0.0, 1.0, 9.0, 9.1]), np.array([1.0, 2.0, 3.0, 4.0]))
    t, x = held(signal, 5.0, 0.25)
    assert t.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 9.0, 9.1]
    assert x.tolist() == [1.0] * 4 + [2.0, 3.0, 4.0]


def test_spikes_become_the_signal_that_the_plant_makes_of_them():
    scenario = load('late', 'controller.coding:=spikes')
    run = simulate(scenario, 300.0, sampled=True)
    # the messages are where the decoded u passes 0
    u, t = run['u'], run.t
    passes = np.flatnonzero((u[:-1] < 0.0) != (u[1:] < 0.0))
    passes = passes[u[passes] != 0.0]
    ago = H * u[passes + 1] / (u[passes + 1] - u[passes])
    sent = Signal(t[passes + 1], np.copysign(1.0 + ago, u[passes + 1]))
    found = as_received({'u': sent, 'y': Signal(t, run['y'])}, scenario)
    made = found['u']
    late = made.t > 150.0
    expected = np.interp(made.t[late], t, u)
    assert np.sqrt(np.mean((made.x[late] - expected) ** 2)) < 0.05
    assert found['y'].x is run['y']


def test_what_came_sample_by_sample_stays_as_it_is():
    scenario = load('exact', 'controller.send_on_delta:=0.1')
    run = simulate(scenario, 20.0, sampled=True)
    signals = {'u': Signal(run.t, run['u'])}
    assert as_received(signals, scenario)['u'] is signals['u']


def test_the_lead_counts_when_w_and_u_are_compared(tmp_path):
    scenario = load('exact', 'controller.predict:=true', '/**.lead:=2.0')
    run = simulate(scenario, 400.0, sampled=True, delay=2.0, on='yu')
    assert run.report.synchronisation.max_abs < 0.02
