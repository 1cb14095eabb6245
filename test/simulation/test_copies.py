# SPDX-License-Identifier: Apache-2.0
"""Messages that are lost on the way in a simulation: what receivers make of those that come."""

from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import judge, load, simulate
from eventreg_ros.simulation.block import Block
from eventreg_ros.simulation.copies import copies_of
from eventreg_ros.simulation.impairment import Impairment, received
from eventreg_ros.simulation.sampled import SampledLoop

ONE_WAY = ('exosystem.send_on_delta:=0.1', '/**.hold:=zero')
SPIKES = ('controller.coding:=spikes',)


def kept(link, steps, loss, seed):
    """Which messages of a link come, by the random numbers that the impairment promises."""
    return np.random.default_rng((seed, link, 0)).random(steps + 1) >= loss


def test_on_delta_a_receiver_holds_the_last_message_that_came():
    scenario = load('uncontrolled', *ONE_WAY)
    sent = simulate(scenario, 60.0, sampled=True)['w']
    numbers = np.flatnonzero(np.diff(sent, prepend=np.nan))
    beats = [n + k for n, m in zip(numbers, [*numbers[1:], 1201], strict=True)
             for k in range(50, m - n, 50)]  # fmt: skip
    messages = sorted([*numbers, *beats])
    loop = SampledLoop(scenario.loop)
    link = loop.links.index(('plant', 'w'))
    comes = kept(link, 1200, 0.5, seed=3)
    received, last = [], 0.0
    for n in range(1200):
        last = sent[n] if n in messages and comes[n] else last
        received.append(last)
    assert 0.1 < np.abs(received - sent[:-1]).max() < 2.0
    found = simulate(scenario, 60.0, sampled=True, loss=0.5, seed=3, on='w')
    np.testing.assert_array_equal(found['w'], sent)
    plant = scenario.blocks['plant']
    block, y = Block(plant), [0.0]
    for value in received:
        zeros = [value if signal == 'w' else 0.0 for signal, _ in plant.inputs]
        y.append(block.advance(zeros, [0.0] * len(zeros)))
    np.testing.assert_allclose(found['y'], y, rtol=0.0, atol=1e-12)


@pytest.mark.slow
def test_of_spikes_that_are_lost_the_receiver_knows_nothing_and_the_sender_does_not_know_it():
    scenario = load('late', *SPIKES, '/**.lead:=1')
    loop = SampledLoop(scenario.loop)
    link = loop.links.index(('plant', 'u'))
    clean = loop.run(200.0)
    u = clean.signals['u']
    passes = np.flatnonzero((u[:-1] <= 0.0) != (u[1:] <= 0.0)) + 1
    comes = kept(link, 4000, 0.4, seed=2)
    assert 0 < sum(comes[passes]) < len(passes)
    lossy = loop.run(200.0, Impairment(loss=0.4, seed=2, on=frozenset('u')))
    first = passes[~comes[passes]][0]
    same = slice(0, first + 20)  # the lead, and the line that is drawn from it
    np.testing.assert_array_equal(lossy.signals['y'][same], clean.signals['y'][same])
    assert not np.array_equal(lossy.signals['y'], clean.signals['y'])
    own = lossy.signals['u']
    np.testing.assert_array_equal(own[: first + 20], u[: first + 20])
    assert np.abs(own[passes[0] :]).max() > 1.5, 'the sender goes on as if it were heard'


@pytest.mark.slow
@pytest.mark.parametrize(('name', 'settle'), [('exact', 300.0), ('late', 450.0)])
def test_a_fifth_of_the_spikes_may_be_lost(name, settle):
    overrides = [*SPIKES, 'controller.predict:=true', '/**.lead:=2']

    def lost(loss):
        return simulate(
            load(name, *overrides), 700.0, sampled=True, delay=2.0, loss=loss, seed=1, on='u'
        )

    assert judge(lost(0.2), settle=settle).verdict == 'rejected'
    assert judge(lost(0.9), settle=settle).verdict == 'not rejected', 'with nearly all it fails'


def test_links_that_are_named_lose_messages_but_no_samples_and_are_late_as_ever():
    scenario = load('late', *SPIKES, 'plant.send_on_delta:=0.05')
    signals = [signal for _, signal in SampledLoop(scenario.loop).links]
    lossy = Impairment(delay=1.0, jitter=2.0, loss=0.4, seed=3, on=frozenset('y'))
    copies = copies_of(list(scenario.blocks.values()), signals, lossy, 9, 400)
    (link,) = copies.of
    assert signals[link] == 'y'
    leads = [0] * len(signals)
    found, whole, still = (
        received(signals, 400, 0.05, each, leads)
        for each in (lossy, replace(lossy, loss=0.0), replace(lossy, loss=0.0, jitter=0.0))
    )
    found = copies.received(found, signals, 400, 0.05, lossy, leads)
    for have, expected in zip(found, whole, strict=True):
        np.testing.assert_array_equal(have[link], expected[link])
    assert not np.array_equal(whole.newest[link], still.newest[link])


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    scenario = load('late', *SPIKES, 'plant.send_on_delta:=0.05', '/**.lead:=1.5')
    loop = SampledLoop(scenario.loop)
    impairment = Impairment(delay=1.0, jitter=0.5, loss=0.4, seed=3)
    plain, fast = (loop.run(100.0, impairment, compiled=each) for each in (False, True))
    for name, values in plain.signals.items():
        assert values.tobytes() == fast.signals[name].tobytes(), name


def test_switched_off_the_receivers_forget():
    at = ['60:controller:deactivate']
    scenario = load('late', *SPIKES, '/**.lead:=1')
    run, clean = (
        simulate(scenario, 80.0, sampled=True, at=at, loss=loss, seed=1, on='u')
        for loss in (0.01, 0)
    )
    assert not run['u'][1201:].any()
    np.testing.assert_array_equal(run['y'], clean['y'])
