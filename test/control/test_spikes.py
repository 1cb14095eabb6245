# SPDX-License-Identifier: Apache-2.0
"""u in two spikes a period: the sender's events, the receiver's generator, the loop with both."""

import math

import numpy as np
import pytest

from eventreg_ros import judge, load, simulate
from eventreg_ros.control.spikes import Receiver, Spikes, template
from eventreg_ros.models import NEURON
from eventreg_ros.simulation.coding import Coder
from eventreg_ros.simulation.step import make_step

H = 0.05
PERIODS = {1 / 16: 46.7, 1 / 12: 37.5, 1 / 8: 28.2}
"""Of the oscillator in antiphase; its conductance cancels."""


def generator(tau, steps, phase=0.0):
    """x1 of a neuron alone, from its limit cycle on."""
    step, x, found = make_step(NEURON.rhs, 2), (2.0, 0.0), []
    for n in range(round(4 * template(tau).period / H + phase / H) + steps):
        found.append(x[0])
        x = step(x, 0.0, 0.0, 0.0, (0.0, tau), H)
        del n
    return np.array(found[-steps:])


@pytest.mark.parametrize('tau', PERIODS)
def test_the_template_is_the_limit_cycle_of_a_half_of_the_oscillator(tau):
    period, recovery = template(tau)[1:]
    assert period == pytest.approx(PERIODS[tau], abs=0.1)
    run = simulate(load('uncontrolled', f'exosystem.tau:={tau}'), 5.0 * period)
    w, first = run['w'], round(3.0 * period / H)
    rise = first + np.flatnonzero((w[first:-1] < 0.0) & (w[first + 1 :] >= 0.0))[0]
    mine = Receiver(tau)
    mine([(1.0, 0.0)], 0.0)
    ago = H * w[rise + 1] / (w[rise + 1] - w[rise])
    made = [mine([], ago)] + [mine([], H) for _ in range(400)]
    np.testing.assert_allclose(made, w[rise + 1 :][:401], atol=2e-3)
    assert recovery < 0.0


def coded(values, tau):
    coder, made, sent = Coder(Spikes(tau), 1.0 / H, H), [], []
    for n, value in enumerate(values):
        made.append(coder(value))
        sent += [(n, message) for message in coder.take()]
    return np.array(made), sent


def test_two_messages_a_period_carry_the_signal():
    values = generator(1 / 12, 3000)
    made, sent = coded(values.tolist(), 1 / 12)
    assert len(sent) == 8  # four periods
    assert [math.copysign(1.0, m) for _, m in sent] == [
        (-1.0) ** (k + (sent[0][1] < 0)) for k in range(8)
    ]
    for n, message in sent:
        before, after = values[n - 1], values[n]
        ago = abs(message) - 1.0
        assert before + (1.0 - ago / H) * (after - before) == pytest.approx(0.0, abs=1e-12)
    first = sent[0][0]
    assert not made[:first].any()
    np.testing.assert_allclose(made[first:], values[first:], atol=5e-3)


def test_a_spike_that_is_heard_late_is_made_up_for_in_the_senders_time():
    prompt, late = Receiver(1 / 12), Receiver(1 / 12)
    for hears in (prompt, late):
        for _ in range(3):  # rises every 28: the sender is faster than the template
            hears([(1.0, 0.0)], 14.0)
            hears([(-1.0, 0.0)], 14.0)
    prompt([(1.0, 0.0)], 14.0)
    for _ in range(359):
        late([], H)
    made = [prompt([], H) for _ in range(80)]
    assert late([(1.0, 4.0)], H) == pytest.approx(made[-1], abs=1e-4)


def test_spikes_that_go_out_late_and_together_say_how_long_ago_they_were():
    values = generator(1 / 12, 1500).tolist()
    _, sent = coded(values, 1 / 12)
    coder = Coder(Spikes(1 / 12), 1.0 / H, H)
    for value in values:
        coder(value)
    ago = [abs(message) - 1.0 + (1499 - n) * H for n, message in sent]
    late = coder.take()
    assert [abs(message) - 1.0 for message in late] == pytest.approx(ago, abs=1e-9)
    assert [m > 0.0 for m in late] == [m > 0.0 for _, m in sent]
    assert len(late) > 2


def test_a_receiver_with_another_tau_takes_over_the_senders_period():
    values = generator(1 / 12, 6000)
    made, sent = coded(values.tolist(), 1 / 16)
    settled = sent[3][0]
    for sign in (-1.0, 1.0):  # both pass 0 at the same times
        theirs, mine = (np.flatnonzero((sign * x[settled:-1] < 0) & (sign * x[settled + 1 :] >= 0))
                        for x in (values, made))  # fmt: skip
        assert len(theirs) == len(mine)
        assert np.abs(theirs - mine).max() <= 1


def test_a_signal_that_trembles_about_0_sends_one_event():
    values = [-1.0, -0.3, 0.1, -0.1, 0.2, -0.05, 0.3, 1.0, 0.2, -0.1, 0.1, -0.2, -1.0]
    _, sent = coded(values, 1 / 12)
    assert [(n, math.copysign(1.0, m)) for n, m in sent] == [(2, 1.0), (9, -1.0)]


def heard(sent, steps, tau, lost=()):
    """What a receiver makes of messages by number, without those ``lost``."""
    receiver, made = Receiver(tau), []
    kept = {n: m for k, (n, m) in enumerate(sent) if k not in lost}
    for n in range(steps):
        events = [(math.copysign(1.0, kept[n]), abs(kept[n]) - 1.0)] if n in kept else []
        made.append(receiver(events, H))
    return np.array(made), receiver


def test_the_receiver_makes_what_the_sender_thinks_it_makes():
    values = generator(1 / 12, 4000).tolist()
    made, sent = coded(values, 1 / 16)
    found, _ = heard(sent, 4000, 1 / 16)
    np.testing.assert_allclose(found, made, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize('lost', [(5,), (5, 6), (4, 7)])
def test_lost_messages_are_bridged_by_the_generator(lost):
    values = generator(1 / 12, 6000)
    _, sent = coded(values.tolist(), 1 / 12)
    made, _ = heard(sent, 6000, 1 / 12, lost)
    settled = sent[2][0]
    assert np.abs(made - values)[settled:].max() < 0.25
    assert np.abs(made - values)[sent[9][0] :].max() < 0.05


def test_late_messages_set_the_phase_of_now():
    values = generator(1 / 12, 3000).tolist()
    made, sent = coded(values, 1 / 12)
    receiver, late, found = Receiver(1 / 12), 20, []
    due = {n + late: (math.copysign(1.0, m), abs(m) - 1.0 + late * H) for n, m in sent}
    for n in range(3000):
        found.append(receiver([due[n]] if n in due else [], H))
    first = sent[0][0] + late
    np.testing.assert_allclose(found[first:], made[first:], atol=5e-3)


def test_silence_is_0_after_three_periods_and_an_event_brings_it_back():
    values = generator(1 / 12, 1200)
    _, sent = coded(values.tolist(), 1 / 12)
    made, receiver = heard(sent, 4000, 1 / 12)
    last = sent[-1][0]
    quiet = last + round(3.0 * template(1 / 12).period / H)
    assert made[last : quiet - 2].any()
    assert not made[quiet + 2 :].any()
    assert receiver.silent
    receiver([(1.0, 0.01)], H)
    assert not receiver.silent
    receiver.stop()
    assert receiver([], H) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize('delay', [0.0, 2.0])
@pytest.mark.parametrize('name', ['exact', 'mismatch'])
def test_the_loop_rejects_with_two_messages_of_u_a_period(name, delay):
    overrides = ['controller.predict:=true', 'controller.coding:=spikes', f'/**.lead:={delay}']
    overrides += ['controller.adapt:=0.04'] if name == 'mismatch' else []
    run = simulate(load(name, *overrides), 450.0, sampled=True, delay=delay, on='yu')
    assert judge(run, settle=300.0).verdict == 'rejected'
    crossings = np.count_nonzero(np.diff(run['u'] > 0.0))
    assert crossings / 450.0 < 0.06
