# SPDX-License-Identifier: Apache-2.0
"""Any number of blocks over DDS: banks and robots in lockstep, suffixes, QoS of one topic each."""

from functools import partial

import numpy as np
import pytest
from rclpy.qos import ReliabilityPolicy

from eventreg_ros import scenario as scenarios
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.nodes.composed import make
from eventreg_ros.simulation.sampled import simulate_sampled

TWO = """
exosystem: {ros__parameters: {k: 2.0, x0: [1.0, 0.0, -1.0, 0.0]}}
exosystem_2: {ros__parameters: {tau: 0.05263157894736842, x0: [-0.4, 0.6, 0.9, -0.3]}}
plant: {ros__parameters: {excitatory: ['w', 'w_2'], inhibitory: ['u', 'u_2']}}
controller: {ros__parameters: {}}
controller_2: {ros__parameters: {tau: 0.05263157894736842}}
plant_left: {ros__parameters: {k: 1.5}}
/robot/exosystem: {ros__parameters: {tau: 0.1}}
/robot/plant: {ros__parameters: {}}
"""


@pytest.fixture
def started(bench, tmp_path):
    """The nodes of a scenario in lockstep inside the test, recorded."""

    def start(scenario, seconds):
        stored = tmp_path / 'stored.yaml'
        stored.write_text(scenario.to_yaml())
        whole = scenario.with_recorder(str(tmp_path / 'bag'), str(stored)).in_lockstep(seconds)
        file = tmp_path / 'parameters.yaml'
        file.write_text(whole.to_yaml())
        arguments = ['--params-file', str(file)]
        return {node: bench.add(partial(make, node), arguments=arguments) for node in whole.nodes}

    return start


def test_a_bank_and_a_robot_in_lockstep_are_the_simulation_bit_for_bit(bench, started, tmp_path):
    scenario = scenarios.parse(TWO, 'two', ['/**.rate:=100'])
    nodes = started(scenario, 2.0)
    bench.until(lambda: nodes['recorder'].row > 200)
    nodes['recorder'].close()
    bench.nodes.remove(nodes['recorder'])
    truth = simulate_sampled(scenario.loop, 20.0).signals
    signals = read_bag(tmp_path / 'bag', '').signals
    assert set(signals) == set(truth) >= {'w_2', 'u_2', 'y_left', 'robot/y'}
    for name, (_, values) in signals.items():
        np.testing.assert_array_equal(values.view(np.int64), truth[name].view(np.int64))


def test_a_participant_with_another_rate_is_refused_by_name(bench, started):
    nodes = started(scenarios.parse(TWO, 'two', ['/**.rate:=100']), 1000.0)
    bench.until(lambda: nodes['plant'].n > 10)
    stranger = bench.add(
        partial(BlockNode, 'reference'), 'lockstep:=true', 'rate:=50.0', start=False
    )
    nodes['clock'].reached['/reference'] = -1
    stranger.bring_up()
    bench.until(lambda: nodes['clock'].fault is not None)
    assert '/reference has rate 50.0, the clock 100' in nodes['clock'].fault


def test_a_qos_override_of_one_topic_leaves_the_others_alone(bench):
    plant = bench.add(
        partial(BlockNode, 'plant'),
        'qos_overrides./w.subscription.reliability:=best_effort',
        'qos_overrides./y.publisher.depth:=10',
    )
    other = bench.add(partial(BlockNode, 'controller'))
    reliability = {
        signal: source.qos_profile.reliability for signal, source in plant.sources.items()
    }
    assert reliability == {
        'w': ReliabilityPolicy.BEST_EFFORT,
        'v': ReliabilityPolicy.RELIABLE,
        'u': ReliabilityPolicy.RELIABLE,
    }
    for node, signal, kind, expected in (
        (plant, 'y', 'publisher', 10),
        (plant, 'u', 'subscription', 100),
        (other, 'u', 'publisher', 100),
    ):
        name = f'qos_overrides./{signal}.{kind}.depth'
        assert node.get_parameter(name).value == expected
    assert other.sources['y'].qos_profile.reliability == ReliabilityPolicy.RELIABLE


def test_a_renamed_node_has_the_signals_of_its_name(bench):
    node = bench.add(partial(BlockNode, 'controller'), arguments=['-r', '__node:=controller_b'])
    assert node.values['output'] == 'u_b'
    assert set(node.sinks) == {'u_b'}
    other = bench.add(partial(BlockNode, 'controller'), arguments=['-r', '__node:=brain'])
    assert other.values['output'] == 'u'


def test_a_model_set_while_inactive_brings_its_own_parameters(bench):
    from rclpy.parameter import Parameter

    node = bench.add(partial(BlockNode, 'plant'), start=False)
    values = [Parameter('model', value='linear'), Parameter('x0', value=[0.25])]
    assert node.set_parameters_atomically(values).successful
    node.bring_up()
    bench.until(lambda: node.n >= 0)
    assert len(node.block.x) == 1
