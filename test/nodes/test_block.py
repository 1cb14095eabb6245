# SPDX-License-Identifier: Apache-2.0
"""The block node: what it publishes, when, and what it does with its inputs."""

import math
import time
from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from eventreg_ros import scenario as scenarios
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.simulation.block import Block

EXOSYSTEM, PLANT, CONTROLLER = (
    partial(BlockNode, kind) for kind in ('exosystem', 'plant', 'controller')
)


def offline(role, steps, inputs=0):
    """The samples of the block alone, its inputs silent, stepped without ROS."""
    block = Block(scenarios.load('exact').blocks[role])
    zero = [0.0] * inputs
    return [block.y] + [block.advance(zero, zero) for _ in range(steps)]


def test_samples_are_those_of_the_block_stepped_offline_at_the_pace_of_the_clock(bench):
    heard = bench.heard_with_stamps(Float64, 'w')
    node = bench.add(EXOSYSTEM, start=False)
    node.trigger_configure()
    bench.until(lambda: node.publisher.get_subscription_count() == 1)
    node.trigger_activate()
    bench.until(lambda: len(heard) >= 200)
    truth = offline('exosystem', 2000)
    n = -1
    for stamp, value in heard:  # a late tick publishes only the newest sample
        n = truth.index(value, n + 1)
        tick = node.pace.grid.stamp(node.pace.origin + n)
        assert 0 <= stamp - tick < 1e9, 'sample n belongs to instant n of the grid'
    assert truth.index(heard[0][1]) <= node.pace.grid.index(heard[0][0]) - node.pace.origin


def test_remapped_and_in_a_namespace(bench):
    heard = bench.heard(Float64, '/lab/noise')
    bench.add(EXOSYSTEM, arguments=['-r', '__ns:=/lab', '-r', 'w:=noise'])
    bench.until(lambda: len(heard) > 3)


def test_whole_numbers_are_doubles_and_the_last_override_wins(bench):
    node = bench.add(PLANT, 'k:=3', 'k:=2', 'x0:=[1, 2]')
    assert node.get_parameter('k').value == 2.0
    assert node.block.spec.params[0] == 2.0
    assert node.values['x0'] == [1.0, 2.0]
    assert node.set_parameters([Parameter('k', value=5)])[0].successful
    assert node.get_parameter('k').type_ == Parameter.Type.DOUBLE
    assert node.block.spec.params[0] == 5.0


@pytest.mark.parametrize(
    ('name', 'value', 'word'),
    [
        ('k', -1.0, 'range'),
        ('k', 'much', 'type'),
        ('tau', 0.0, '> 0'),
        ('tau', math.nan, 'range'),
        ('gain', [1.0], 'length 2'),
        ('time_scale', 0.0, 'range'),
        ('x0', [1.0, 0.0], 'inactive'),
        ('rate', 100.0, 'inactive'),
        ('output', 'z', 'unconfigured'),
    ],
)
def test_a_refused_value_says_why_and_changes_nothing(bench, name, value, word):
    node = bench.add(PLANT)
    before, spec = dict(node.values), node.block.spec
    result = node.set_parameters([Parameter(name, value=value)])[0]
    assert not result.successful
    assert word in result.reason
    assert node.values == before
    assert node.block.spec == spec
    assert node.get_parameter(name).value == pytest.approx(before[name])


def test_parameters_are_described(bench):
    node = bench.add(PLANT)
    tau = node.describe_parameter('tau')
    assert tau.description
    assert '> 0' in tau.additional_constraints
    assert tau.floating_point_range[0].from_value == 0.0


def test_k_and_tau_take_effect_from_the_next_step(bench):
    heard = bench.heard(Float64, 'y')
    node = bench.add(PLANT, 'x0:=[1.5, 0.0]')
    bench.until(lambda: len(heard) > 5)
    node.set_parameters([Parameter('k', value=50.0)])  # a leak that pulls y to 0 at once
    bench.until(lambda: abs(heard[-1].data) < 0.1)
    assert node.n < 200, 'the default k would have spiked meanwhile'


def test_deactivated_it_publishes_zero_once_and_activated_it_starts_from_x0(bench):
    heard = bench.heard(Float64, 'u')
    node = bench.add(CONTROLLER, 'rate:=25.0')  # slow, so that its first tick is not late
    bench.until(lambda: len(heard) > 5)
    node.trigger_deactivate()
    bench.until(lambda: heard[-1].data == 0.0)
    count = len(heard)
    bench.spin(0.2)  # five periods
    assert len(heard) == count
    node.trigger_activate()
    bench.until(lambda: len(heard) > count)
    assert heard[count].data == 0.5


def test_inputs_add_with_their_signs_and_one_that_nobody_publishes_is_zero(bench):
    node = bench.add(PLANT)
    w = bench.peer.create_publisher(Float64, 'w', 10)
    u = bench.peer.create_publisher(Float64, 'u', 10)

    def send():
        w.publish(Float64(data=0.7))
        u.publish(Float64(data=0.7))

    timer = bench.peer.create_timer(0.005, send)
    bench.until(
        lambda: all(s.received > 50 for s in (node.inputs.samples[0], node.inputs.samples[2]))
    )
    assert [s.received for s in node.inputs.samples][1] == 0
    # w - u = 0 from when both are heard: at most the few samples before have moved the state.
    assert abs(node.block.y) < 0.2
    timer.cancel()


def test_a_silent_input_counts_as_zero_is_reported_and_recovers(bench):
    said = bench.heard(DiagnosticArray, '/diagnostics')
    node = bench.add(PLANT, 'input_timeout:=0.1')
    w = bench.peer.create_publisher(Float64, 'w', 10)
    timer = bench.peer.create_timer(0.005, lambda: w.publish(Float64(data=0.3)))
    bench.until(lambda: node.inputs.samples[0].received > 10)
    assert node.inputs.silent == [False, False, False]
    timer.cancel()
    bench.until(lambda: node.inputs.silent == [True, False, False])

    def status():
        found = [s for a in said for s in a.status if s.name == '/plant: plant']
        return found[-1] if found else None

    bench.until(lambda: status() and status().level == DiagnosticStatus.WARN)
    assert 'w' in status().message
    timer.reset()
    bench.until(lambda: node.inputs.silent == [False, False, False])
    bench.until(lambda: status().level == DiagnosticStatus.OK)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_a_sample_that_is_not_finite_is_dropped_and_counted(bench, bad):
    heard = bench.heard(Float64, 'y')
    node = bench.add(PLANT)
    w = bench.peer.create_publisher(Float64, 'w', 10)
    bench.until(lambda: w.get_subscription_count() == 1)
    w.publish(Float64(data=bad))
    bench.until(lambda: node.inputs.samples[0].dropped.not_finite == 1)
    count = len(heard)
    bench.until(lambda: len(heard) > count + 5)
    assert all(math.isfinite(m.data) for m in heard)
    assert node.inputs.samples[0].received == 0


def test_a_state_that_stops_being_finite_goes_through_the_error_state(bench):
    heard = bench.heard(Float64, 'y')
    said = bench.heard(DiagnosticArray, '/diagnostics')
    node = bench.add(PLANT, 'x0:=[1.0e150, 0.0]')
    bench.until(lambda: node.fault is not None)
    assert node._state_machine.current_state[1] == 'unconfigured'
    assert 'finite' in node.fault
    bench.until(lambda: any(s.level == DiagnosticStatus.ERROR for a in said for s in a.status))
    assert all(math.isfinite(m.data) for m in heard)
    node.set_parameters([Parameter('x0', value=[0.0, 0.0])])
    node.bring_up()
    count = len(heard)
    bench.until(lambda: len(heard) > count + 3)
    assert node.fault is None


def test_a_late_timer_is_caught_up(bench):
    node = bench.add(EXOSYSTEM)
    bench.until(lambda: node.n > 5)
    time.sleep(0.1)  # the executor is held up for twenty steps
    bench.until(lambda: node.pace.caught_up >= 10)
    late = node.get_clock().now().nanoseconds - node.pace.grid.stamp(node.pace.origin + node.n)
    assert late < 0.05e9
    # Lateness counts from the first instant that was due; it came at most a step into the pause.
    assert node.pace.lateness.largest >= 0.1 - 0.005
    assert node.pace.dropped == 0
    assert node.block.y == offline('exosystem', node.n)[-1]


def test_a_long_pause_is_caught_up_only_so_far_and_reported(bench):
    node = bench.add(EXOSYSTEM, 'max_catch_up:=0.05', 'late_warn:=1.0e6')
    bench.until(lambda: node.n > 5)
    origin = node.pace.origin
    time.sleep(0.3)
    bench.until(lambda: node.pace.dropped > 0)
    assert node.pace.dropped == node.pace.origin - origin
    assert node.block.y == offline('exosystem', node.n)[-1]
    assert node.report()[0] == DiagnosticStatus.WARN


def test_simulation_time_that_begins_anew_does_not_hold_the_node_up(bench):
    clock = bench.peer.create_publisher(Clock, '/clock', 10)
    node = bench.add(EXOSYSTEM, 'use_sim_time:=true')
    now = 4_000_000_000

    def tick():
        nonlocal now
        now += 5_000_000
        clock.publish(Clock(clock=Time(nanoseconds=now).to_msg()))
        bench.spin(0.001)
        return node.n

    bench.until(lambda: tick() >= 300)
    now, n = 100_000_000, node.n
    bench.until(lambda: tick() > n + 20)
    assert node.pace.clock_jumps == 1
    assert now < 1_000_000_000, 'it went on at once'
    assert node.block.y == offline('exosystem', node.n)[-1]


def test_precision_is_half_a_period_at_most(bench):
    node = bench.add(EXOSYSTEM, 'precision:=0.01')
    assert node.pace._early == 2_500_000


def test_the_worst_that_is_known_is_reported(bench):
    node = bench.add(PLANT, 'delay_margin:=0.5', 'late_error:=2.0')
    node.inputs.samples[0].received = 1
    node.inputs.delays[0].add(0.045)  # a WARN
    node.pace.lateness.add(1.0)  # an ERROR
    level, message, _ = node.report()
    assert level == DiagnosticStatus.ERROR
    assert 'steps late' in message
    assert 'delay margin' in message


def test_the_margin_is_that_of_the_hold(bench):
    node = bench.add(PLANT, 'hold:=zero', 'delay_margin:=0.5', 'delay_margin_zero:=0.2')
    node.inputs.samples[0].received = 1
    node.inputs.delays[0].add(0.025)
    assert 'delay margin of the scenario (0.2)' in node.report()[1]


def test_nodes_that_share_a_start_time_begin_at_the_same_instant(bench):
    start = bench.peer.get_clock().now().nanoseconds * 1e-9 + 1.5
    nodes = [bench.add(make, f'start_time:={start:.9f}') for make in (EXOSYSTEM, PLANT)]
    bench.until(lambda: all(node.n > 0 for node in nodes))
    assert nodes[0].pace.origin == nodes[1].pace.origin
    assert nodes[0].pace.grid.stamp(nodes[0].pace.origin) >= start * 1e9 - 1000


def test_diagnostics_come_once_a_second_in_every_state(bench):
    said = bench.heard(DiagnosticArray, '/diagnostics')
    node = bench.add(PLANT, start=False)

    def states():
        return [v.value for a in said for s in a.status for v in s.values if v.key == 'state']

    bench.until(lambda: 'unconfigured' in states())
    node.bring_up()
    bench.until(lambda: 'active' in states())


def test_a_transition_that_the_state_does_not_have_is_refused_and_the_node_lives(bench):
    node = bench.add(PLANT)
    client = bench.peer.create_client(ChangeState, '/plant/change_state')
    bench.until(client.service_is_ready)

    def ask(number):
        request = ChangeState.Request(transition=Transition(id=number))
        future = client.call_async(request)
        bench.until(future.done)
        return future.result().success

    assert not ask(Transition.TRANSITION_ACTIVATE)
    assert not ask(Transition.TRANSITION_CONFIGURE)
    n = node.n
    bench.until(lambda: node.n > n)
    assert ask(Transition.TRANSITION_DEACTIVATE)


def test_two_publishers_of_one_input_are_reported(bench):
    node = bench.add(PLANT)
    first, second = (bench.peer.create_publisher(Float64, 'w', 10) for _ in range(2))
    bench.until(lambda: node.sources['w'].get_publisher_count() == 2)
    level, message, _ = node.report()
    assert level == DiagnosticStatus.WARN
    assert 'w' in message
    bench.peer.destroy_publisher(first)
    bench.peer.destroy_publisher(second)


def test_a_delay_near_the_margin_is_a_warning_in_those_words(bench):
    node = bench.add(PLANT, 'delay_margin:=0.5')
    node.inputs.samples[0].received = 1
    node.inputs.delays[0].add(0.045)  # seconds; 0.45 of model time
    level, message, _ = node.report()
    assert level == DiagnosticStatus.WARN
    assert 'comes near the delay margin of the scenario (0.5)' in message
    node.inputs.delays[0].add(0.055)
    assert node.report()[0] == DiagnosticStatus.ERROR


@pytest.mark.parametrize('rate', [300.0, 1500.0])
def test_a_period_of_no_whole_nanoseconds_does_not_drift_off_the_grid(bench, rate):
    node = bench.add(EXOSYSTEM, f'rate:={rate}')
    timer, pace = node.pace._timer, node.pace
    bench.until(lambda: node.n > 20)
    periods = set()

    def watch():
        periods.add(timer.timer_period_ns)
        return len(periods) > 1

    bench.until(watch)
    grid = {pace.grid.stamp(k + 1) - pace.grid.stamp(k) for k in range(10)}
    assert periods <= grid
