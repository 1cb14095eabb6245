# SPDX-License-Identifier: Apache-2.0
"""Nodes whose output is coded: which messages go out, and what listeners make of them."""

import math
import time
from functools import partial

import numpy as np
import pytest
from std_msgs.msg import Float64

from eventreg_ros import load, simulate
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.control.spikes import Spikes
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.nodes.pace import Tick
from eventreg_ros.nodes.spike_input import SpikeInput
from eventreg_ros.nodes.spike_monitor import SpikeMonitor
from eventreg_ros.runtime.cdr import packed, with_age
from eventreg_ros.runtime.tick_grid import SECOND
from eventreg_ros.simulation.coding import Coder

CONTROLLER, PLANT, EXOSYSTEM = (
    partial(BlockNode, kind) for kind in ('controller', 'plant', 'exosystem')
)
PERIOD, H = 5_000_000, 0.05


def test_on_delta_only_what_differs_goes_out_and_a_heartbeat(bench):
    heard = bench.heard_with_stamps(Float64, 'w')
    node = bench.add(EXOSYSTEM, 'send_on_delta:=0.5', 'input_timeout:=0.2')
    bench.until(lambda: len(heard) > 12)
    small = np.abs(np.diff([value for _, value in heard])) < 0.5
    passed = (heard[-1][0] - heard[0][0]) / SECOND
    assert small.sum() <= passed / 0.1 + 2, 'no more of them than heartbeats'
    assert node.pace.n > 8 * len(heard)
    figures = node.report().values
    assert figures['w.sent'] == node.sent
    assert float(figures['w.sent_per_second']) > 0.0
    assert float(figures['w.energy']) == pytest.approx(node.squares * H, rel=1e-3)


def test_the_monitor_counts_messages_a_second_and_per_event_of_the_disturbance(bench):
    node = bench.add(SpikeMonitor, "signals:=[w, 'y', u]")
    w, u = (bench.peer.create_publisher(Float64, name, 100) for name in 'wu')
    bench.until(lambda: w.get_subscription_count() == u.get_subscription_count() == 1)
    for value in (-1.0, 2.0, -1.0, 2.0):
        w.publish(Float64(data=value))
    for _ in range(6):
        u.publish(Float64(data=0.0))
    bench.until(lambda: node.heard == {'w': 4, 'y': 0, 'u': 6})
    values = node.report().values
    assert (values['w.messages'], values['u.messages']) == (4, 6)
    assert (values['w.messages_per_event'], values['u.messages_per_event']) == ('2', '3')
    assert float(values['u.messages_per_second']) > 0.0


def test_spikes_go_out_twice_a_period_and_the_plant_makes_u_of_them(bench):
    scale = ('time_scale:=100.0', 'rate:=400.0')
    heard = bench.heard(Float64, 'u')
    plant = bench.add(PLANT, "spike_inputs:=['u:0.0833']", 'lead:=10.0', *scale)
    coded = ('predict:=true', 'coding:=spikes', 'lead:=10.0')
    node = bench.add(CONTROLLER, *coded, *scale)
    bench.until(lambda: len(heard) > 5)
    messages = [message.data for message in heard[:6]]
    assert [math.copysign(1.0, m) for m in messages] == [-1.0, 1.0] * 3
    assert all(abs(m) >= 1.0 for m in messages)
    (u,) = (s for s in plant.inputs.samples if isinstance(s, SpikeInput))
    bench.until(lambda: abs(u._value) > 1.0)
    node.trigger_deactivate()
    bench.until(lambda: heard[-1].data == 0.0)
    bench.until(lambda: u._receiver.silent)


def spikes(steps):
    """Messages of a neuron's x1 by number, and what the sender thinks that is made of them."""
    coder, sent, made = Coder(Spikes(1 / 12), 200.0, H), [], []
    for n in range(steps):
        made.append(coder(2.0 * math.sin(2.0 * math.pi * n * H / 36.0)))
        sent += [(n, message) for message in coder.take()]
    return sent, made


@pytest.mark.parametrize('late', [0, 30])
def test_the_input_makes_of_spikes_what_the_sender_thinks(late):
    """By stamps: of each sample's instant, and a little after; played after a lead, or too late."""
    sent, made = spikes(2000)
    samples, lead = SpikeInput(1 / 12), 40
    samples.lead, samples.h = lead * PERIOD, H
    waiting, found = list(sent), []
    for n in range(2000):
        while waiting and waiting[0][0] + lead + late <= n:
            number, message = waiting.pop(0)
            samples.push(round((number + 0.1) * PERIOD), message)
        line = samples.over(n * PERIOD, float(PERIOD), 0.1 * SECOND, 8.0)
        found.append(line[0] if line else 0.0)
    first = sent[0][0] + lead + late
    expected = np.concatenate((np.zeros(lead), made))[first:2000]
    same = slice(None) if not late else slice(-20, None)  # a while after the last one came
    np.testing.assert_allclose(found[first:][same], expected[same], rtol=0.0, atol=1e-6)
    assert (samples.late > 0) == (late > 0)
    assert samples.gaps == 0


CODED = ('controller.coding:=spikes', 'plant.send_on_delta:=0.05', 'exosystem.send_on_delta:=0.1')
ON_DELTA = ('/**.send_on_delta:=0.1', '/**.input_timeout:=0.2')


@pytest.mark.parametrize(
    ('name', 'overrides', 'more', 'delay'),
    [
        ('late', CODED, ['--composed'], 1.5),
        ('open', ON_DELTA, [], 0.3),
    ],
    ids=['spikes, composed', 'on delta, processes'],
)
def test_lockstep_has_the_bits_of_the_sampled_simulation(
    eventreg, tmp_path, name, overrides, more, delay
):
    late = [f'--link={signal}:delay={delay / 10.0}' for signal in 'yu']
    run = eventreg(
        'run', name, '--lockstep', *more, *late, *(word for p in overrides for word in ('-p', p)),
        '--at', '3:controller:deactivate', '--at', '4:controller:activate',
        '--settle', '0', '--duration', '8', '--bag', tmp_path / 'bag',
    )  # fmt: skip
    assert run.returncode in (0, 1, 3), run.stderr
    at = ['30:controller:deactivate', '40:controller:activate']
    truth = simulate(load(name, *overrides), 80.0, sampled=True, delay=delay, on='yu', at=at)
    recorded = read_bag(tmp_path / 'bag').signals
    assert sorted(recorded) == sorted(truth.signals)
    for signal, values in truth.signals.items():
        assert np.asarray(recorded[signal][1]).tobytes() == values.tobytes(), signal


def test_a_silence_of_more_than_the_timeout_is_a_gap_and_less_is_none(bench):
    plant = bench.add(PLANT, "held_inputs:=['u']", 'input_timeout:=0.4')
    (u,) = (s for s, name in zip(plant.inputs.samples, plant.inputs.signals, strict=True)
            if name == 'u')  # fmt: skip
    for stamp in (0.0, 0.01, 0.02, 0.03, 0.3, 0.6, 0.605, 1.1):
        u.push(round(stamp * SECOND), 0.0)
    assert u.gaps == 1


@pytest.mark.parametrize(
    ('signal', 'given'),
    [('w', "held_inputs:=['w']"), ('u', 'lead:=2.0')],
    ids=['on delta', 'a lead that is too short'],
)
def test_what_travels_for_longer_than_the_timeout_is_no_silence(bench, signal, given):
    """Two samples a timeout, each 0.9 s under way, are held; then nothing comes for a timeout."""
    plant = bench.add(PLANT, given, start=False)
    plant.trigger_configure()
    plant.values |= {'start_time': 9e9}  # its own pace never ticks
    plant.trigger_activate()
    inputs, start, quarter, quiet = plant.inputs, time.time_ns(), SECOND // 4, []
    i = inputs.signals.index(signal)
    receive = inputs.receiver(i, lambda: None)
    for n in range(8):
        now = start + n * quarter
        if n < 5:
            info = {'source_timestamp': now, 'received_timestamp': now}
            info['publication_sequence_number'] = n + 1
            receive(with_age(packed(0.5), round(0.9 * SECOND)), info)
        line = inputs.over(Tick(n, now + PERIOD, PERIOD, now + PERIOD))
        quiet.append(line.base[i] == 0.0)
    assert quiet == [False] * 6 + [True] * 2
    assert inputs.silent[i]
