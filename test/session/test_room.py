# SPDX-License-Identifier: Apache-2.0
"""A run looks first: in a domain where its nodes live already it starts nothing."""

import os
import time

import pytest

pytest.importorskip('rclpy')

import rclpy
from rclpy.context import Context
from std_msgs.msg import Float64

from eventreg_ros.session.domain import loopback_domain


@pytest.fixture
def domain():
    """A domain of its own, as a user exports it."""
    with loopback_domain({k: v for k, v in os.environ.items() if k != 'ROS_DOMAIN_ID'}) as found:
        yield found


@pytest.fixture
def stranger(domain):
    """A node of another name that publishes y, in a context of its own."""
    context = Context()
    context.init(domain_id=int(domain['ROS_DOMAIN_ID']))
    node = rclpy.create_node('sensor', context=context, namespace='/arm')
    node.create_publisher(Float64, '/y', 1)
    yield node
    node.destroy_node()
    context.try_shutdown()


def test_nodes_and_publishers_of_the_same_names_are_named_and_left_alone(
    domain, stranger, eventreg, spawn, tmp_path
):
    controller = spawn(
        '-m', 'eventreg_ros', 'node', 'controller', '--ros-args', '-p', 'autostart:=false',
        env=domain,
    )  # fmt: skip
    end = time.monotonic() + 20.0
    while ('controller', '/') not in stranger.get_node_names_and_namespaces():
        assert time.monotonic() < end, 'the controller never came'
        time.sleep(0.05)
    result = eventreg('run', 'exact', '--bag', tmp_path / 'bag', env=domain)
    assert result.returncode == 2
    assert result.stderr == (
        f'eventreg: on ROS_DOMAIN_ID={domain["ROS_DOMAIN_ID"]} there is /controller, /arm/sensor, '
        'which publishes /y, already, and two would disturb each other; stop them, or unset '
        'ROS_DOMAIN_ID for a domain of its own\n'
    )
    assert not (tmp_path / 'bag').exists()
    controller.terminate()
    out, err = controller.communicate(timeout=20)
    assert (out, err) == ('', '')  # nobody asked it for anything
