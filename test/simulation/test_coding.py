# SPDX-License-Identifier: Apache-2.0
"""Outputs of which not every sample is sent: what receivers make of them, and how many are."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.errors import EventregError
from eventreg_ros.simulation.coding import Coder, Delta

PREDICT = 'controller.predict:=true'


def by_rule(values, delta, beat):
    """What is sent by the rule in words: (number, value) of each message."""
    sent = [(0, values[0])]
    for n, value in enumerate(values[1:], 1):
        if abs(value - sent[-1][1]) >= delta or n - sent[-1][0] >= beat:
            sent.append((n, value))
    return sent


def test_what_differs_by_delta_is_sent_and_every_half_timeout():
    values = np.sin(np.arange(400) * 0.02) * np.linspace(0.0, 1.0, 400)
    coder, received, sent = Coder(Delta(0.1, 0.25), 200.0, 0.05), [], []
    for n, value in enumerate(values.tolist()):
        received.append(coder(value))
        sent += [(n, message) for message in coder.take()]
    assert sent == by_rule(values.tolist(), 0.1, 50)
    numbers = [n for n, _ in sent]
    assert received == [
        values[numbers[np.searchsorted(numbers, n, 'right') - 1]] for n in range(400)
    ]
    assert max(np.abs(np.array(received) - values)) < 0.1
    assert max(np.diff(numbers)) == 50


def test_messages_that_could_not_go_out_at_once_go_out_together_with_the_next():
    coder = Coder(Delta(0.1, 10.0), 200.0, 0.05)
    for value in (0.0, 0.05, 0.2, 0.25, 0.4):
        coder(value)
    assert coder.take() == [0.0, 0.2, 0.4]
    assert coder.take() == []


def test_what_differs_by_exactly_delta_is_sent():
    coder = Coder(Delta(0.5, 10.0), 200.0, 0.05)
    for value in (0.0, 0.25, 0.5, 0.75, 0.0):
        coder(value)
    assert coder.take() == [0.0, 0.5, 0.0]


def messages(x):
    return 1 + np.count_nonzero(np.diff(x))


@pytest.mark.parametrize(('name', 'most'), [('exact', 1.9), ('mismatch', 1.9), ('open', 2.3)])
def test_u_sent_on_delta_rejects_with_a_tenth_of_the_messages(name, most):
    run = simulate(load(name, 'controller.send_on_delta:=0.1'), 400.0, sampled=True)
    assert run.verdict == 'rejected'
    assert messages(run['u']) / 400.0 < most
    assert messages(run['y']) == 8001, 'the others send every sample'


@pytest.mark.slow
def test_it_can_be_too_coarse():
    assert simulate(load('open', 'controller.send_on_delta:=0.3'), 800.0, sampled=True).verdict == (
        'not rejected'
    )


def test_receivers_hold_what_was_sent_and_draw_no_line():
    lines = simulate(load('exact', 'controller.send_on_delta:=0.1'), 60.0, sampled=True)
    listens = ['controller.send_on_delta:=0.1', "plant.held_inputs:=['u']"]
    told = simulate(load('exact', *listens), 60.0, sampled=True)
    assert told['y'].tobytes() == lines['y'].tobytes(), 'the scenario says it to the listeners'
    blocks = load('open', '/**.send_on_delta:=0.1').blocks
    assert blocks['plant'].held == {'w', 'u'}
    assert blocks['controller'].held == {'y', 'y_r'}
    assert blocks['reference'].held == set()


def test_switched_off_nothing_is_sent_and_u_is_0():
    at = ['20:controller:deactivate', '30:controller:activate']
    run = simulate(load('exact', 'controller.send_on_delta:=0.1'), 40.0, sampled=True, at=at)
    assert not run['u'][401:600].any()
    assert run['u'][601] == 0.5, 'the first sample after that is sent whatever it is'


def test_the_messages_of_a_simulation_are_counted_by_the_rule():
    at = ['20:controller:deactivate', '30:controller:activate']
    scenario = load('exact', 'controller.send_on_delta:=0.1', 'exosystem.send_on_delta:=0.05')
    w = len(by_rule(simulate('exact', 40.0, sampled=True)['w'].tolist(), 0.05, 50))
    whole, switched = (simulate(scenario, 40.0, sampled=True, at=each) for each in ([], at))
    assert whole.messages == {'w': w, 'y': 801, 'u': whole.messages['u']}
    assert whole.report.signals['w'].messages == w
    runs = np.flatnonzero(np.diff(whole['u'], prepend=np.nan))  # where a message differs
    beats = int(((np.diff(runs, append=801) - 1) // 50).sum())
    assert whole.messages['u'] == len(runs) + beats
    off = simulate(scenario, 20.0, sampled=True).messages['u']
    assert off + 2 < switched.messages['u']
    assert simulate(scenario, 30.0, sampled=True, at=at[:1]).messages['u'] == off + 1
    assert simulate(scenario, 5.0).messages == {}, 'a continuous system sends nothing'


def test_what_goes_beside_an_output_goes_when_it_does():
    scenario = load('late', 'controller.coding:=spikes')
    run = simulate(scenario, 200.0, sampled=True)
    assert run.messages['u/tau'] == run.messages['u'] < 12


def test_without_it_the_bits_are_those_of_ever():
    plain = simulate('exact', 60.0, sampled=True)
    zero = simulate(load('exact', '/**.send_on_delta:=0.0'), 60.0, sampled=True)
    assert plain['y'].tobytes() == zero['y'].tobytes()


@pytest.mark.parametrize(
    ('overrides', 'words'),
    [
        (['controller.coding:=spikes'], 'coding must be samples without predict'),
        (['controller.coding:=morse'], 'one of samples, spikes'),
        (
            [
                'controller.predict:=true',
                'controller.coding:=spikes',
                'controller.send_on_delta:=1',
            ],
            'send_on_delta must be 0 with coding spikes',
        ),
        (
            [PREDICT, 'controller.coding:=spikes', 'controller.tau:=1.2'],
            'tau must be .* <= 0.8 with coding spikes',
        ),
        (["plant.spike_inputs:=['u:2']"], r'plant\.spike_inputs must be SIGNAL:TAU'),
        (['plant.send_on_delta:=-1'], 'send_on_delta must be a finite number >= 0'),
    ],
)
def test_codes_that_do_not_fit_are_refused(overrides, words):
    with pytest.raises(EventregError, match=words):
        load('exact', *overrides)
