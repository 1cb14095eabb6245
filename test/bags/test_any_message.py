# SPDX-License-Identifier: Apache-2.0
"""Messages of any bytes, and of types made up at random: read as rosbags reads them, or not."""

import numpy as np
import pytest

from eventreg_ros.bags.channel import Channel
from eventreg_ros.bags.definitions import parse_path, types_of
from eventreg_ros.bags.messages import FieldDecoder, float64
from eventreg_ros.errors import BagError

pytestmark = pytest.mark.slow

hypothesis = pytest.importorskip('hypothesis')
given, st = hypothesis.given, hypothesis.strategies

JOINTS = 'sensor_msgs/msg/JointState'
KINDS = {
    'bool': st.booleans(),
    'uint8': st.integers(0, 255),
    'int16': st.integers(-(2**15), 2**15 - 1),
    'uint32': st.integers(0, 2**32 - 1),
    'int64': st.integers(-(2**53), 2**53),
    'float32': st.floats(width=32),
    'float64': st.floats(),
    'string': st.text(st.characters(codec='utf-8', exclude_characters='\x00'), max_size=9),
}
MADE = 'made_msgs/msg/Up'


@st.composite
def made_up(draw):
    """The definition of a message and values of its fields; the last field is a number."""
    names = draw(st.lists(st.sampled_from([*KINDS]), max_size=6))
    names.append(draw(st.sampled_from([name for name in KINDS if name != 'string'])))
    lines, values = [], {}
    for i, name in enumerate(names):
        many = i < len(names) - 1 and draw(st.booleans())
        lines.append(f'{name}{"[]" if many else ""} f{i}')
        value = draw(st.lists(KINDS[name], max_size=4) if many else KINDS[name])
        numbers = many and name != 'string'
        values[f'f{i}'] = np.array(value, dtype=name) if numbers else value
    return '\n'.join(lines) + '\n', values


@given(made=made_up(), little=st.booleans())
def test_the_last_field_of_any_type_is_what_was_written(made, little):
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    definition, values = made
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, MADE))
    message = store.serialize_cdr(store.types[MADE](**values), MADE, little_endian=little)
    types = types_of(Channel('/x', MADE, 'cdr', definition, 'ros2msg'))
    last = list(values)[-1]
    table = np.frombuffer(bytes(message), np.uint8)[None, :]
    found = FieldDecoder(types, MADE, (last,))(table)
    assert found.good is None
    np.testing.assert_array_equal(found.values, [float(values[last])])


@given(data=st.binary(max_size=200), field=st.sampled_from(['velocity[1]', 'header.stamp.sec']))
def test_any_bytes_are_a_number_or_none(data, field):
    types = types_of(Channel('/x', JOINTS, 'cdr', '', ''))
    table = np.frombuffer(data, np.uint8)[None, :]
    found = FieldDecoder(types, JOINTS, parse_path(field))(table)
    assert found.values.shape == (1,)
    assert found.good is None or np.isnan(found.values[~found.good]).all()
    if len(data) != 12:
        return
    assert float64(table).values.shape == (1,)


@given(text=st.text(max_size=300) | st.from_regex(r'([a-z0-9/]{1,9}(\[\d*\])? [a-z]{1,4}\n){1,6}'))
def test_any_definition_is_understood_or_unknown(text):
    try:
        types = types_of(Channel('/x', 'a_msgs/msg/B', 'cdr', text, 'ros2msg'))
    except BagError:
        return
    assert all(isinstance(name, str) for name in types)


@given(text=st.text(max_size=40) | st.from_regex(r'[a-z]{1,3}(\[\d+\])?(\.[a-z]{1,3}){0,2}'))
def test_any_path_is_one_or_none(text):
    path = parse_path(text)
    assert path is None or all(isinstance(step, str | int) for step in path)
