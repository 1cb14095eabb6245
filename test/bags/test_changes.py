# SPDX-License-Identifier: Apache-2.0
"""What was changed during a recording: messages as ROS writes them, in bags of both storages."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from eventreg_ros.bags.changes import PARAMETERS, TRANSITION, Changed, as_set
from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.runtime.cdr import packed

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
EMPTY = {
    'byte_array_value': np.empty(0, np.uint8), 'bool_array_value': np.empty(0, np.bool_),
    'integer_array_value': np.empty(0, np.int64), 'double_array_value': np.empty(0),
    'string_array_value': [], 'bool_value': False, 'integer_value': 0, 'double_value': 0.0,
    'string_value': '',
}  # fmt: skip


def parameter_event(node, *changed, new=()):
    def parameters(pairs):
        return [
            TYPES['rcl_interfaces/msg/Parameter'](
                name, TYPES['rcl_interfaces/msg/ParameterValue'](type=kind, **{**EMPTY, **value})
            )
            for name, kind, value in pairs
        ]

    time = TYPES['builtin_interfaces/msg/Time'](1, 5)
    event = TYPES[PARAMETERS](time, node, parameters(new), parameters(changed), [])
    return bytes(STORE.serialize_cdr(event, PARAMETERS))


def transition_event(start, goal):
    state = TYPES['lifecycle_msgs/msg/State']
    transition = TYPES['lifecycle_msgs/msg/Transition'](3, 'x')
    event = TYPES[TRANSITION](0, transition, state(1, start), state(2, goal))
    return bytes(STORE.serialize_cdr(event, TRANSITION))


@pytest.fixture
def bag(tmp_path):
    """Write a bag of one signal and of messages (topic, type, stamp, data); return its path."""

    def make(messages, storage='mcap'):
        writer = BagWriter(tmp_path / 'bag', storage, None, None)
        writer.add('/y', FLOAT64)
        writer.write('/y', 1000, packed(0.0))
        known = set()
        for topic, kind, stamp, data in messages:
            if topic not in known:
                writer.add(topic, kind)  # in the middle of a recording
                known.add(topic)
            writer.write(topic, stamp, data)
            writer.write('/y', stamp, packed(1.0))
        writer.close()
        return tmp_path / 'bag'

    return make


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_parameters_and_transitions_are_read_beside_the_signals(bag, storage):
    k = ('k', 3, {'double_value': 3.0})
    recording = read_bag(
        bag(
            [
                ('/parameter_events', PARAMETERS, 3000, parameter_event('/r1/controller', k)),
                ('/plant/transition_event', TRANSITION, 2000,
                 transition_event('active', 'deactivating')),
                ('/plant/transition_event', TRANSITION, 2500,
                 transition_event('deactivating', 'inactive')),
                ('/parameter_events', PARAMETERS, 4000, parameter_event('/plant', new=[k])),
            ],
            storage,
        )
    )  # fmt: skip
    assert recording.changes == (
        Changed(2500, 'plant', 'deactivate'),
        Changed(3000, 'r1/controller', 'k:=3'),
    )
    assert len(recording.signals['y'].stamps) == 5
    assert recording.findings == ()


@pytest.mark.parametrize(
    ('kind', 'value', 'shown'),
    [
        (1, {'bool_value': True}, 'true'),
        (2, {'integer_value': -7}, '-7'),
        (3, {'double_value': 1 / 12}, '0.0833333'),
        (4, {'string_value': 'linear'}, 'linear'),
        (7, {'integer_array_value': np.array([1, 2])}, '[1, 2]'),
        (8, {'double_array_value': np.array([0.5, 2.0])}, '[0.5, 2]'),
        (9, {'string_array_value': ['w', 'v']}, '[w, v]'),
        (0, {}, 'None'),
        (99, {}, 'None'),
    ],
)
def test_values_as_one_would_set_them(bag, kind, value, shown):
    event = parameter_event('/plant', ('p', kind, value))
    (change,) = read_bag(bag([('/parameter_events', PARAMETERS, 2000, event)])).changes
    assert change == Changed(2000, 'plant', f'p:={shown}')
    assert as_set([True, 2, 0.25, 'x']) == '[true, 2, 0.25, x]'


@pytest.mark.parametrize('cut', [0, 5, 20, 60])
def test_a_broken_message_is_no_change_and_no_obstacle(bag, cut):
    event = parameter_event('/plant', ('k', 3, {'double_value': 3.0}))[:cut]
    event += bytes([255] * (40 - min(cut, 40)))
    recording = read_bag(bag([('/parameter_events', PARAMETERS, 2000, event)]))
    assert recording.changes == ()
    assert len(recording.signals['y'].stamps) == 2
