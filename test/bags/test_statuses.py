# SPDX-License-Identifier: Apache-2.0
"""Diagnostic statuses in a bag, and when a run came near its delay margin by them."""

import pytest
from rosbags.typesys import Stores, get_typestore

from eventreg_ros.analysis.delays import delay_findings
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.statuses import STATUS, read_statuses
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.runtime.cdr import packed


@pytest.fixture
def bag(tmp_path):
    """A bag in namespace /r1 of 20 s, whose monitor speaks once a second; one message is broken."""
    store = get_typestore(Stores.ROS2_JAZZY)
    status, pair = store.types[STATUS], store.types['diagnostic_msgs/msg/KeyValue']
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    for name in ('w', 'y'):
        writer.add(f'/r1/{name}', FLOAT64)
    writer.add('/r1/verdict', STATUS)
    for i in range(201):
        stamp = 10**18 + i * 10**8
        for name in ('w', 'y'):
            writer.write(f'/r1/{name}', stamp, packed(0.0))
        if i % 10 == 0:
            used = f'{0.04 * i / 10:.3f}' if i < 150 else '1.200'
            values = [pair(key='margin_used', value=used)] if i >= 50 else []
            message = status(level=0, name='m', message='', hardware_id='', values=values)
            data = bytes(store.serialize_cdr(message, STATUS))
            writer.write('/r1/verdict', stamp, data[:9] if i == 100 else data)
    writer.close()
    return tmp_path / 'bag'


def test_statuses_are_read_in_order_without_those_that_are_broken(bag):
    found = read_statuses(bag, '/r1/verdict')
    assert len(found) == 20
    assert found[0] == (10**18, {})
    assert found[8] == (10**18 + 8 * 10**9, {'margin_used': '0.320'})
    assert read_statuses(bag, '/r1/y') == []
    assert read_statuses(bag, '/none') == []


def test_the_first_time_that_a_delay_took_half_and_all_of_the_margin(bag):
    found = delay_findings(bag, analyze(bag))
    assert [(f.code, f.at) for f in found] == [('delay', 130.0), ('delay', 150.0)]
    assert found[0].text == 'the longest delay so far was 0.52 times the delay margin'
    assert found[1].text == 'the longest delay so far was 1.20 times the delay margin'


def test_a_bag_without_a_monitor_says_nothing(make_bag):
    bag = make_bag(w=[110], y=[], text=None)
    assert delay_findings(bag, analyze(bag)) == []
