# SPDX-License-Identifier: Apache-2.0
"""A ROS context of its own for each test, in a domain of its own on the loopback."""

import os
import time

import pytest

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

rclpy = pytest.importorskip('rclpy', reason='needs ROS 2: pip install .[ros]')

from rclpy.context import Context  # noqa: E402
from rclpy.lifecycle import TransitionCallbackReturn  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402

from eventreg_ros.nodes.ros import make_executor, with_info  # noqa: E402
from eventreg_ros.session.domain import loopback_domain  # noqa: E402


class Bench:
    """Nodes under test, one executor for them, and a plain node that speaks and listens."""

    def __init__(self, context):
        self.context = context
        self.executor = make_executor(context)
        self.nodes = []
        self.peer = rclpy.create_node('bench', context=context)
        self.executor.add_node(self.peer)

    def add(self, make, *parameters, arguments=(), start=True):
        """Create a node with ``name:=value`` parameters, start it, and spin it."""
        flags = [word for p in parameters for word in ('-p', p)]
        given = [*flags, *arguments]
        node = make(context=self.context, cli_args=['--ros-args', *given] if given else None)
        self.nodes.append(node)
        self.executor.add_node(node)
        if start:
            node.bring_up()
        return node

    def heard(self, message, topic, qos=None):
        """Return the list that messages on ``topic`` will be put on."""
        messages = []
        qos = qos or QoSProfile(depth=1000)
        self.peer.create_subscription(message, topic, messages.append, qos)
        return messages

    def heard_with_stamps(self, message, topic):
        messages = []
        self.peer.create_subscription(
            message,
            topic,
            with_info(lambda m, info: messages.append((info['source_timestamp'], m.data))),
            QoSProfile(depth=1000),
        )
        return messages

    def until(self, condition, timeout=60.0):
        """Spin until ``condition()`` holds; fail after ``timeout`` seconds."""
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, 'the condition never came true'
            self.executor.spin_once(timeout_sec=0.05)

    def spin(self, seconds):
        """Let the nodes run for a span of time whose length is what the test is about."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def close(self):
        for node in self.nodes:
            node.close()
        self.peer.destroy_node()


@pytest.fixture
def domain(monkeypatch):
    """A free ROS domain, for this process and its children."""
    with loopback_domain({k: v for k, v in os.environ.items() if k != 'ROS_DOMAIN_ID'}) as found:
        monkeypatch.setenv('ROS_DOMAIN_ID', found['ROS_DOMAIN_ID'])
        yield int(found['ROS_DOMAIN_ID'])


@pytest.fixture
def bench(domain):
    context = Context()
    context.init(args=['--ros-args', '--log-level', 'FATAL'], domain_id=domain)
    found = Bench(context)
    yield found
    found.close()
    context.try_shutdown()


@pytest.fixture
def launch(domain, spawn):
    """Start a node as ``ros2 run`` would; everything started is ended with the test."""

    def start(node, *arguments):
        ros = ['--ros-args', *arguments] if arguments else []
        return spawn('-m', f'eventreg_ros.nodes.{node}', *ros)

    return start


SUCCESS = TransitionCallbackReturn.SUCCESS
