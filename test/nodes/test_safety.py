# SPDX-License-Identifier: Apache-2.0
"""In front of a real plant: outliers, limits, faults, QoS and clocks that do not fit."""

import math
import re
from functools import partial

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from eventreg_ros import simulate
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.nodes.managed import IDENTITY
from eventreg_ros.nodes.spike_monitor import SpikeMonitor
from eventreg_ros.runtime.figures import MARGIN_USED

CONTROLLER = partial(BlockNode, 'controller')
WARN = DiagnosticStatus.WARN


@pytest.fixture
def plant(bench):
    """A foreign plant: it sends y = 0 every 5 ms, by default; u is kept."""

    class Plant:
        def __init__(self):
            self.u = bench.heard(Float64, 'u')
            self.publisher = bench.peer.create_publisher(Float64, 'y', 100)
            self.bad, self.sent = [], 0
            self.timer = bench.peer.create_timer(0.005, self.send)

        def send(self):
            value = self.bad.pop(0) if self.bad else 0.0
            self.sent += 1
            self.publisher.publish(Float64(data=value))

    return Plant()


@pytest.fixture
def status(bench):
    said = bench.heard(DiagnosticArray, '/diagnostics')

    def all_of_them():
        return [s for array in said for s in array.status if 'controller' in s.name]

    return all_of_them


def warned(statuses, words):
    """Whether a warning in these words has come, not necessarily last.

    On a busy machine late ticks may add an error to it.
    """
    return any(s.level >= WARN and words in s.message for s in statuses)


@pytest.mark.parametrize('bad', [1000.0, 60.0, 1e308, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize('times', [1, 7])
def test_what_no_plant_sends_is_dropped_and_u_stays_as_it_was(bench, plant, status, bad, times):
    node = bench.add(CONTROLLER)
    bench.until(lambda: node.inputs.samples[0].received > 20 and status())
    lone = abs(bad) <= 100.0
    for _ in range(times):
        plant.bad += [bad] if lone or times == 1 else [bad, bad]
        sent = plant.sent
        bench.until(lambda sent=sent: plant.sent > sent + 5)
    dropped = node.inputs.samples[0].dropped
    bench.until(lambda: sum(node.inputs.samples[0].dropped) >= times)
    assert dropped.outliers == 0 or lone
    # Without an input the oscillator never exceeds 2.2: u shows nothing of what was sent.
    assert max(abs(m.data) for m in plant.u) < 2.5
    assert node.stage == 'active'
    bench.until(lambda: warned(status(), 'samples dropped'))
    bench.until(lambda: 'samples dropped' not in status()[-1].message)


def test_a_jump_that_stays_is_believed_with_the_second_sample(bench, plant):
    node = bench.add(CONTROLLER)
    bench.until(lambda: node.inputs.samples[0].received > 20)
    plant.bad += [8.0] * 40
    bench.until(lambda: node.inputs.samples[0]._kept[-1][1] == 8.0)
    assert node.inputs.samples[0].dropped.outliers == 0


def test_the_limit_may_be_set_while_it_runs(bench, plant):
    node = bench.add(CONTROLLER)
    bench.until(lambda: node.inputs.samples[0].received > 5)
    assert node.set_parameters([Parameter('input_limit', value=0.5)])[0].successful
    plant.bad += [0.7] * 3
    bench.until(lambda: node.inputs.samples[0].dropped.out_of_range == 3)


def test_the_output_is_cut_off_and_it_is_reported(bench, plant, status):
    node = bench.add(CONTROLLER, 'output_limit:=1.0', 'time_scale:=100.0')
    bench.until(lambda: node.cut_off > 3)
    assert max(abs(m.data) for m in plant.u) == 1.0
    bench.until(lambda: warned(status(), 'cut off at 1'))


def test_simulations_cut_the_output_off_alike():
    limited = [simulate_limited(sampled).signals['u'] for sampled in (True, False)]
    for u in limited:
        assert np.abs(u).max() == 1.5
        assert (np.abs(u) == 1.5).sum() > 100


def simulate_limited(sampled):
    from eventreg_ros import load

    return simulate(load('exact', 'controller.output_limit:=1.5'), 100.0, sampled=sampled)


def test_a_fault_recovers_by_itself_where_that_is_wanted(bench, plant):
    node = bench.add(CONTROLLER, 'recover:=0.2')
    bench.until(lambda: node.n > 5)
    node.block.x = (1e200, 0.0, 0.0, 0.0)
    bench.until(lambda: node.fault is not None)
    bench.until(lambda: node.stage == 'active')
    assert node.fault is None
    assert max(abs(x) for x in node.block.x) < 3.0
    stays = bench.add(partial(BlockNode, 'reference'), 'x0:=[1.0e200, 0.0]')
    bench.until(lambda: stays.fault is not None)
    bench.spin(0.3)
    assert stays.stage == 'unconfigured'


def test_a_best_effort_publisher_is_named_with_the_cure(bench, status):
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    bench.peer.create_publisher(Float64, 'y', qos)
    bench.add(CONTROLLER)
    cure = 'qos_overrides./y.subscription.reliability:=best_effort'
    bench.until(lambda: warned(status(), cure))


def test_without_a_clock_simulation_time_is_a_warning(bench, status):
    bench.add(CONTROLLER, 'use_sim_time:=true')
    bench.until(lambda: warned(status(), 'waits for /clock'))


def test_a_clock_that_stops_is_a_warning(bench, status):
    clock = bench.peer.create_publisher(Clock, '/clock', 10)
    node = bench.add(CONTROLLER, 'use_sim_time:=true')
    for n in range(1, 40):
        clock.publish(Clock(clock=Time(nanoseconds=n * 10**7).to_msg()))
        bench.spin(0.01)
    assert node.n > 10
    bench.until(lambda: warned(status(), '/clock stands still'))


def test_every_second_sample_broken_is_a_warning_every_second(bench, plant, status):
    bench.add(CONTROLLER)
    bench.until(lambda: warned(status(), 'not finite') if plant.bad else plant.bad.extend(
        [math.nan, 0.0] * 2000))  # fmt: skip
    n = len(status())
    bench.until(lambda: len(status()) == n + 2)
    assert all(warned([s], 'not finite') for s in status()[n:])


def test_a_participant_of_another_rate_is_a_warning(bench, plant, status):
    plant.timer.cancel()
    plant.timer = bench.peer.create_timer(0.01, plant.send)
    bench.add(CONTROLLER)
    words = 'times a second, this node steps 200 times; give both the same rate'
    bench.until(lambda: warned(status(), words))
    found = re.findall(r'y comes (\S+) times', ' '.join(s.message for s in status()))
    assert float(found[-1]) == pytest.approx(100.0, rel=0.06)  # the bins of the histogram


def test_the_same_rate_is_none(bench, plant, status):
    node = bench.add(CONTROLLER)
    bench.until(lambda: node.inputs.samples[0].period.count > 150)
    n = len(status())
    bench.until(lambda: len(status()) > n)
    assert not warned(status(), 'times a second')


@pytest.mark.parametrize(
    ('version', 'words'), [('eventreg_ros 9.9.9', 'eventreg_ros 9.9.9'), ('', 'an older eventreg')]
)
def test_a_node_of_another_version_is_a_warning_until_it_is_gone(bench, version, words):
    monitor = bench.add(SpikeMonitor)
    publisher = bench.peer.create_publisher(DiagnosticArray, '/diagnostics', 10)
    values = [KeyValue(key='state', value='active'), KeyValue(key=MARGIN_USED, value='nonsense')]

    def say(version):
        status = DiagnosticStatus(name='/plant: plant', values=values, hardware_id=version)
        publisher.publish(DiagnosticArray(status=[status]))

    bench.until(lambda: say(version) or monitor.report().level == WARN)
    assert f'/plant ({words}' in monitor.report().message
    bench.until(lambda: say(IDENTITY) or monitor.report().level != WARN)
