# SPDX-License-Identifier: Apache-2.0
"""Observer, prediction and lead as nodes: in lockstep to the bit, in real time over late links."""

from functools import partial

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Float64

from eventreg_ros import load, simulate
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.nodes.link import LinkNode
from eventreg_ros.nodes.managed import ManagedNode
from eventreg_ros.nodes.pace import Tick

PERIOD = 5_000_000.0
CONTROLLER, PLANT = partial(BlockNode, 'controller'), partial(BlockNode, 'plant')
LATE = ('--link', 'y:delay=0.15', '--link', 'u:delay=0.15')


def test_lockstep_with_stated_delays_is_the_sampled_simulation_bit_for_bit(eventreg, tmp_path):
    lead = 1.7  # more than the delay, so that samples wait
    run = eventreg(
        'run', 'late', '--lockstep', '--composed', '-p', f'/**.lead:={lead}', *LATE,
        '--at', '3:controller:deactivate', '--at', '5:controller:activate',
        '--settle', '0', '--duration', '8', '--bag', tmp_path / 'bag',
    )  # fmt: skip
    assert run.returncode in (0, 1, 3), run.stderr
    at = ['30:controller:deactivate', '50:controller:activate']
    scenario = load('late', f'/**.lead:={lead}')
    truth = simulate(scenario, 80.0, sampled=True, delay=1.5, on='yu', at=at)
    recorded = read_bag(tmp_path / 'bag').signals
    assert sorted(recorded) == sorted(truth.signals)
    for name, values in truth.signals.items():
        assert np.asarray(recorded[name][1]).tobytes() == values.tobytes(), name


def test_over_real_links_that_are_late_and_jitter_it_rejects(eventreg, tmp_path):
    # D = 2 of model time and a jitter of 0.4: 67 and 13 ms at this scale; three events of w
    late = ['--link', 'y:delay=0.067,jitter=0.013', '--link', 'u:delay=0.067,jitter=0.013']
    scale = ['-p', '/**.time_scale:=30', '-p', '/**.rate:=300', '-p', '/**.lead:=3.0']
    run = eventreg(
        'run', 'exact', '--composed', '-p', 'controller.predict:=true', *late, *scale,
        '--settle', '60', '--duration', '5.6', '--bag', tmp_path / 'bag',
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    assert 'verdict: rejected' in run.stdout


class Fed:
    """A controller that is fed and stepped by hand, by time stamps in steps."""

    def __init__(self, bench, *parameters):
        self.node = bench.add(CONTROLLER, 'predict:=true', *parameters, start=False)
        self.node.trigger_configure()
        self.node.values |= {'start_time': 9e9}  # its own pace never ticks
        self.node.trigger_activate()

    def step(self, n, shift=0):
        start = round((n + shift) * PERIOD)
        return self.node._next(Tick(n, start, start, PERIOD))

    def hear(self, stamp, value):
        self.node.inputs.samples[0].push(round(stamp * PERIOD), value)

    @property
    def at(self):
        """The step at which the observer is, and whether y is known there."""
        return self.node.block.x[-4], self.node.block.x[-2]


def test_samples_of_y_belong_to_the_instant_before_their_stamp(bench):
    fed = Fed(bench)
    for n in range(20):
        late = {3: 0.0, 4: 0.4, 5: 0.9, 6: -0.1}.get(n, 0.02)
        fed.hear(n + late, 0.1 * n)
        fed.step(n)
    # 5.9 was heard too late for step 5 and is a little early for 6: it is 6, and 5 is missing
    assert fed.at == (19.0, 1.0)
    assert fed.node.block._past.numbers[0][5] == -1
    assert fed.node.block._past.numbers[0][4] == 4


def test_y_that_does_not_come_is_skipped_after_lead_and_timeout(bench):
    fed = Fed(bench, 'lead:=0.5', 'input_timeout:=0.1')  # 10 and 20 steps
    for n in range(100):
        if n < 40:
            fed.hear(n, 0.01 * n)
        fed.step(n)
        assert fed.at == ((float(min(n, 39)), 1.0) if n < 70 else (n - 30.0, 0.0))
    assert fed.node.inputs.quiet == ['y']
    assert 'silent, it is skipped: y' in fed.node.report().message
    fed.hear(100, 0.0)
    fed.step(100)
    assert fed.at == (100.0, 1.0)


@pytest.mark.parametrize('jump', [500, -500], ids=['a pause', 'the clock set back'])
def test_after_a_pause_or_another_clock_observer_and_record_begin_anew(bench, jump):
    fed, fresh = Fed(bench, 'lead:=0.5'), Fed(bench, 'lead:=0.5')
    for n in range(60):
        fed.hear(n, 0.3)
        fed.step(n)
    fed.step(60, shift=jump)
    assert fed.at == (61.0, 0.0)
    assert fed.node.block.y == fresh.node.block.y
    fed.hear(60 + jump, 0.3)
    assert fed.step(61, shift=jump) == fresh.step(0)


def test_activated_again_it_begins_anew_but_with_what_it_has_learned(bench):
    fed = Fed(bench, 'lead:=0.5', 'adapt:=0.04')
    for n in range(60):
        fed.hear(n, 0.3)
        fed.step(n)
    learned, block = fed.node.block.learned['tau'], fed.node.block
    assert fed.at == (59.0, 1.0)
    fed.node.trigger_deactivate()
    fed.node.trigger_activate()
    assert fed.node.block is not block
    assert fed.at == (0.0, 0.0)
    assert fed.node.block.newest == [-1, -1]
    assert fed.node.block.learned == {'tau': learned} != {'tau': 1 / 12}
    assert not any(fed.node.block._past.own[1:])


def test_a_late_u_is_reported_with_the_lead_that_would_have_covered_it(bench):
    plant = bench.add(PLANT, 'inhibitory:=[u_late]', 'excitatory:=[w]', 'lead:=0.5')
    bench.add(LinkNode, 'input:=u', 'output:=u_late', 'delay:=0.1')
    controller = bench.add(CONTROLLER, 'predict:=true', 'lead:=0.5')
    assert isinstance(controller, ManagedNode)
    samples = plant.inputs.samples[1]
    bench.until(lambda: samples.late > 20)
    status = plant.report()
    assert status.level == DiagnosticStatus.WARN
    assert int(status.values['u_late.late']) > 20
    words = status.message
    assert 'samples of u_late came after their time' in words
    wanted = float(words.split('set -p /**.lead:=')[1].split(';')[0])
    assert 1.0 < wanted < 2.0, 'a delay of 100 ms is 1.0 of model time, and what DDS adds'


def test_a_lead_that_covers_the_delay_plays_every_sample_in_time(bench):
    plant = bench.add(PLANT, 'inhibitory:=[u_late]', 'excitatory:=[w]', 'lead:=6.0')
    bench.add(LinkNode, 'input:=u', 'output:=u_late', 'delay:=0.02')
    publisher = bench.peer.create_publisher(Float64, 'u', 100)
    bench.until(lambda: publisher.get_subscription_count() == 1)
    samples = plant.inputs.samples[1]
    bench.until(lambda: publisher.publish(Float64(data=1.0)) or samples.received > 50)
    plant.poll()
    assert samples.late == 0
    delays = plant.inputs.delays[1]
    assert delays.percentile(50) > 0.02, 'the time on the link counts, though it stamps anew'
