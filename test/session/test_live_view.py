# SPDX-License-Identifier: Apache-2.0
"""The running loop as a source for viewers: every message passes through as it is."""

import os
import struct
import sys
import time

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2: pip install eventreg_ros[ros]')

import rclpy
from rclpy.context import Context

from eventreg_ros.errors import EventregError
from eventreg_ros.nodes import topics
from eventreg_ros.session import live_view
from eventreg_ros.session.client import Client
from eventreg_ros.session.domain import loopback_domain


@pytest.fixture
def loop(monkeypatch):
    """Publishers as a loop has them, in a domain of their own; yields what publishes."""
    given = {k: v for k, v in os.environ.items() if k != 'ROS_DOMAIN_ID'}
    with loopback_domain(given) as found:
        for name in ('ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'):
            monkeypatch.setenv(name, found[name])
        context = Context()
        context.init(args=['--ros-args', '--log-level', 'FATAL'])
        node = rclpy.create_node('loop', context=context)

        def publisher(topic, signal=''):
            return node.create_publisher(topic.message, topic.of(signal), topic.qos)

        yield publisher
        node.destroy_node()
        context.try_shutdown()


def test_each_message_goes_to_the_channel_of_its_topic(loop):
    y, count, grant = loop(topics.SIGNAL, 'y'), loop(topics.COUNT, 'y'), loop(topics.GRANT)
    opened, logged = {}, []

    def channels(topic, kind, definition):
        opened[topic] = (kind, definition)
        return lambda data, stamp: logged.append((topic, data, stamp))

    count.publish(topics.COUNT.message(data=7))  # latched: who comes late gets it
    grant.publish(topics.GRANT.message(data=7))
    before = time.time_ns()
    with Client(lambda: None, environment=dict(os.environ)) as client:
        shown = live_view.wait_for_signals(client, channels, 'here')
        client.until(lambda: y.get_subscription_count() > 0, 10.0, lambda: 'y is not heard')
        y.publish(topics.SIGNAL.message(data=1.5))
        client.until(lambda: len(logged) == 2, 10.0, lambda: f'{logged}')
        live_view.show_new(client, channels, shown)
    assert opened['/y'] == ('std_msgs/msg/Float64', 'float64 data\n')
    assert not any('lockstep' in topic for topic in opened)
    found = {topic: (data[4:], stamp) for topic, data, stamp in logged}
    assert struct.unpack('<d', found['/y'][0][:8]) == (1.5,)
    assert struct.unpack('<Q', found['/spikes/y/count'][0][:8]) == (7,)
    assert before < found['/y'][1] < time.time_ns()
    assert len(opened) == len(shown)


def test_without_a_loop_it_says_what_to_start(loop, monkeypatch):
    monkeypatch.setattr(live_view, 'PATIENCE', 0.2)
    with (
        Client(lambda: None, environment=dict(os.environ)) as client,
        pytest.raises(EventregError, match='no signals on here; start a loop with eventreg run'),
    ):
        live_view.wait_for_signals(client, lambda *_: None, 'here')


def test_without_the_extra_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, 'foxglove', None)
    with pytest.raises(EventregError, match=r"pip install '\.\[live\]'"), live_view.server(0):
        pass


def test_the_server_keeps_to_the_loopback():
    pytest.importorskip('foxglove', reason='needs the extra live')
    with live_view.server(0) as (address, channels):
        assert address.startswith('ws://127.0.0.1:')
        channels('/y', 'std_msgs/msg/Float64', 'float64 data\n')(bytes(12), 1)
        port = int(address.rpartition(':')[2])
        with pytest.raises(EventregError, match='choose another --port'), live_view.server(port):
            pass
