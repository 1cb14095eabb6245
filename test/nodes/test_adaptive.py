# SPDX-License-Identifier: Apache-2.0
"""The controller that learns, as a node: what it publishes, when it learns, what it keeps."""

from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from std_msgs.msg import Float64

from eventreg_ros.nodes.block import BlockNode

CONTROLLER = partial(BlockNode, 'controller')
QUICK = 'adapt:=2.0'
"""So large a gain that tau moves visibly within a few steps."""


@pytest.fixture
def driven(bench):
    """Make a controller that hears y = 0.5, from the timer that is its ``speaker``."""

    def make(*parameters):
        node = bench.add(CONTROLLER, *parameters)
        y = bench.peer.create_publisher(Float64, 'y', 10)
        node.speaker = bench.peer.create_timer(0.005, lambda: y.publish(Float64(data=0.5)))
        bench.until(lambda: node.inputs.samples[0].received > 10)
        return node

    return make


def tau_of(node):
    return node.block.x[4]


def moves(bench, node):
    before, n = tau_of(node), node.n
    bench.until(lambda: node.n > n + 5)
    return tau_of(node) != before


def test_it_publishes_what_it_learns_beside_the_output(bench, driven):
    outputs, learned = bench.heard(Float64, 'u'), bench.heard(Float64, 'u/tau')
    said = bench.heard(DiagnosticArray, '/diagnostics')
    node = driven(QUICK)
    bench.until(lambda: outputs and learned)
    more = len(outputs) - len(learned)  # one may be heard before the other
    bench.until(lambda: len(learned) > 20)
    assert learned[-1].data != learned[0].data
    assert abs(len(outputs) - len(learned) - more) <= 1
    bench.until(lambda: learned[-1].data == tau_of(node))
    bench.until(lambda: any(v.key == 'learning' for a in said for s in a.status for v in s.values))
    values = {v.key: v.value for v in said[-1].status[0].values}
    assert values['learning'] == 'on'
    assert 0.02 <= float(values['tau']) <= 1.5
    assert values['u/tau.subscribers'] == '1'


def test_a_fixed_controller_publishes_its_output_alone(bench):
    node = bench.add(CONTROLLER)
    assert list(node.sinks) == ['u']
    assert len(node.block.x) == 4


def test_tau_set_while_it_learns_sets_the_state(bench, driven):
    node = driven('adapt:=1.0e-6')
    assert node.set_parameters([Parameter('tau', value=0.3)])[0].successful
    assert tau_of(node) == 0.3
    bench.until(lambda: tau_of(node) != 0.3)
    assert tau_of(node) == pytest.approx(0.3, rel=1e-3)
    refused = node.set_parameters([Parameter('tau', value=1.6)])[0]
    assert not refused.successful
    assert 'tau_max' in refused.reason
    assert tau_of(node) == pytest.approx(0.3, rel=1e-3)


def test_switched_on_and_off_while_it_runs(bench, driven):
    learned = bench.heard(Float64, 'u/tau')
    node = driven()
    own = node.block.x
    node.set_parameters([Parameter('adapt', value=2.0)])
    assert node.block.x == (*own, 1 / 12), 'tau became a state'
    assert moves(bench, node)
    bench.until(lambda: len(learned) > 5)
    before, tau = node.block.x, tau_of(node)
    node.set_parameters([Parameter('adapt', value=0)])
    assert node.block.x == before[:4], 'and the state is tau again'
    assert node.block.spec.params == (2.0, tau)
    assert node.get_parameter('tau').value == tau
    count = len(learned)
    bench.until(lambda: len(learned) > count + 5)
    assert learned[-1].data == tau


def test_any_other_change_keeps_what_was_learned(bench, driven):
    node = driven(QUICK)
    bench.until(lambda: abs(tau_of(node) - 1 / 12) > 0.01)
    tau = tau_of(node)
    node.set_parameters([Parameter('k', value=1.5)])
    assert tau_of(node) == tau
    assert node.block.spec.params[0] == 1.5
    assert node.get_parameter('tau').value == tau


def test_activated_again_it_starts_from_x0_and_the_learned_tau(bench, driven):
    node = driven(QUICK)
    bench.until(lambda: abs(tau_of(node) - 1 / 12) > 0.01)
    node.trigger_deactivate()
    tau = tau_of(node)
    assert node.get_parameter('tau').value == tau
    node.speaker.cancel()
    node.trigger_activate()
    assert node.block.x == (0.5, 0.0, -0.5, 0.0, tau)


def test_it_holds_still_while_an_input_is_silent(bench, driven):
    """Also where y_r alone is silent: the error would be wrong, and so what it teaches."""
    node = driven(QUICK, 'input_timeout:=0.1')
    reference = bench.peer.create_publisher(Float64, 'y_r', 10)
    timer = bench.peer.create_timer(0.005, lambda: reference.publish(Float64(data=0.1)))
    bench.until(lambda: node.inputs.samples[1].received > 10)
    assert moves(bench, node)
    timer.cancel()
    bench.until(lambda: node.inputs.quiet == ['y_r'])
    assert not moves(bench, node)
    timer.reset()
    bench.until(lambda: node.inputs.quiet == [])
    assert moves(bench, node)
    node.speaker.cancel()
    bench.until(lambda: node.inputs.quiet == ['y'])
    tau, n = tau_of(node), node.n
    bench.until(lambda: node.n > n + 20)
    assert tau_of(node) == tau
    assert node.report().values['learning'] == 'paused'
