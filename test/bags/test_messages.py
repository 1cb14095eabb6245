# SPDX-License-Identifier: Apache-2.0
"""Any number in messages of any type, against rosbags' own serialization."""

import numpy as np
import pytest

from eventreg_ros.bags.channel import Channel
from eventreg_ros.bags.definitions import Named, is_number, kind_at, numbers, parse_path, types_of
from eventreg_ros.bags.messages import FieldDecoder, float64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.errors import BagError

START = 1_795_304_457_727_915_003
JOINTS = 'sensor_msgs/msg/JointState'


@pytest.fixture(scope='module', name='store')
def _store():
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(name='joints')
def _joints(store):
    """Make a JointState, whose strings and sequences have whatever length."""

    def make(i, names=('a', 'bc'), frame='base'):
        stamp = store.types['builtin_interfaces/msg/Time'](
            sec=1_795_304_457 + i // 10, nanosec=i % 10 * 10**8
        )
        header = store.types['std_msgs/msg/Header'](stamp=stamp, frame_id=frame)
        position = np.arange(len(names), dtype=np.float64)
        return store.types[JOINTS](
            header=header, name=list(names), position=position, velocity=position + i,
            effort=np.array([], dtype=np.float64),
        )  # fmt: skip

    return make


def table(messages):
    """Equally long messages as a table."""
    return np.frombuffer(b''.join(map(bytes, messages)), np.uint8).reshape(len(messages), -1)


def test_paths():
    assert parse_path('velocity[2]') == ('velocity', 2)
    assert parse_path('twist.linear.x') == ('twist', 'linear', 'x')
    assert parse_path('poses[0].position.x') == ('poses', 0, 'position', 'x')
    for text in ('', '.', 'a.', '.a', 'a..b', '[0]', 'a[]', 'a[-1]', 'a[x]', 'a b', 'a[1]b', '1a'):
        assert parse_path(text) is None


@pytest.mark.parametrize('little', [True, False])
@pytest.mark.parametrize('kind', [
    'std_msgs/msg/Float64', 'std_msgs/msg/Float32', 'std_msgs/msg/Int16', 'std_msgs/msg/UInt64',
    'std_msgs/msg/Bool', 'std_msgs/msg/Byte', 'std_msgs/msg/Char', 'std_msgs/msg/Int8',
])  # fmt: skip
def test_every_kind_of_number_in_either_byte_order(store, kind, little):
    values = [0, 1, 0, 1, 1] if kind.endswith('Bool') else [0, 1, 77, 100, 3]
    messages = [
        store.serialize_cdr(store.types[kind](data=v), kind, little_endian=little) for v in values
    ]
    types = types_of(Channel('/x', kind, 'cdr', '', ''))
    found = FieldDecoder(types, kind, ('data',))(table(messages))
    assert found.values.tolist() == values
    assert found.good is None
    if kind.endswith('Float64'):
        assert float64(table(messages)).values.tolist() == values


@pytest.mark.parametrize('names', [(), ('a',), ('a', 'bc'), ('a' * 40, 'b', 'c', 'd' * 3)])
@pytest.mark.parametrize('frame', ['', 'b', 'base_link'])
def test_a_field_behind_strings_and_sequences(store, joints, names, frame):
    messages = [store.serialize_cdr(joints(i, names, frame), JOINTS) for i in range(20)]
    types = types_of(Channel('/joints', JOINTS, 'cdr', '', ''))
    for index in range(3):
        found = FieldDecoder(types, JOINTS, ('velocity', index))(table(messages))
        if index < len(names):
            assert found.values.tolist() == [float(index + i) for i in range(20)]
        else:
            assert not found.good.any()


def test_messages_of_one_length_whose_parts_differ(store, joints):
    """'ab', 'c' and 'a', 'bc' are equally long, and so are their messages."""
    parts = [(('abcd', 'a'), 'xx'), (('a', 'abcd'), 'xx'), (('ab', 'abc'), 'yyyyyy')]
    messages = [bytes(store.serialize_cdr(joints(i, *parts[i % 3]), JOINTS)) for i in range(60)]
    types = types_of(Channel('/joints', JOINTS, 'cdr', '', ''))
    decode = FieldDecoder(types, JOINTS, ('velocity', 1))
    for length in {len(m) for m in messages}:
        some = [(i, m) for i, m in enumerate(messages) if len(m) == length]
        found = decode(table([m for _, m in some]))
        assert found.values.tolist() == [1.0 + i for i, _ in some]
    assert len({len(m) for m in messages}) < 3


@pytest.mark.slow
def test_all_numbers_of_all_types_of_ros(store):
    """Each number of each type that ROS brings, found where rosbags puts it."""
    tried = 0
    for kind in sorted(store.fielddefs):
        types = types_of(Channel('/x', kind, 'cdr', '', ''))
        message = filled(store, kind)
        data = bytes(store.serialize_cdr(message, kind))
        for way in numbers(types, kind):
            path = parse_path(way)
            assert is_number(kind_at(types, Named(kind), path))
            expected = message
            for step in path:
                expected = expected[step] if isinstance(step, int) else getattr(expected, step)
            found = FieldDecoder(types, kind, path)(table([data]))
            assert found.values[0] == np.float64(expected), (kind, way)
            tried += 1
    assert tried > 800


def filled(store, kind, count=[0]):  # noqa: B006
    """A message whose numbers are all different, with two of everything in a sequence."""

    def value(desc):
        node, what = int(desc[0]), desc[1]
        count[0] += 1
        if node == 1:
            name = what[0]
            if name == 'string':
                return 'x' * (count[0] % 7)
            return count[0] % 2 == 0 if name == 'bool' else count[0] % 100
        if node == 2:
            return filled(store, what)
        size = what[1] if node == 3 else 2
        items = [value(what[0]) for _ in range(size)]
        if int(what[0][0]) == 1 and what[0][1][0] != 'string':
            kinds = {'bool': 'bool', 'byte': 'uint8', 'char': 'uint8', 'octet': 'uint8'}
            return np.array(items, dtype=kinds.get(what[0][1][0], what[0][1][0]))
        return items

    fields = {name: value(desc) for name, desc in store.fielddefs[kind][1]}
    return store.types[kind](**fields)


def test_lengths_that_lie_take_neither_time_nor_memory(store, joints):
    good = bytes(store.serialize_cdr(joints(1), JOINTS))
    types = types_of(Channel('/joints', JOINTS, 'cdr', '', ''))
    decode = FieldDecoder(types, JOINTS, ('velocity', 0))
    for place in range(4, len(good) - 4):
        bad = good[:place] + b'\xff\xff\xff\x7f' + good[place + 4 :]
        decode(table([bad]))
    assert not decode(table([b'\x00\x01\x00\x00'])).good.any()
    assert not decode(table([b'\x28\xb5\x2f\xfd' + good[4:]])).good.any()


def test_definitions_that_hurt_are_refused():
    def decoder(text, path):
        channel = Channel('/x', 'a/msg/B', 'cdr', text, 'ros2msg')
        return FieldDecoder(types_of(channel), 'a/msg/B', path)

    line = '=' * 80
    within = f'C c\nfloat64 x\n{line}\nMSG: a/C\nB b\n'
    with pytest.raises(BagError, match='choose a field before it'):
        decoder(within, ('x',))(
            np.zeros((1, 100), np.uint8) + np.array([0, 1, *[0] * 98], np.uint8)
        )
    huge = decoder('uint8[4000000000] a\nfloat64 x\n', ('x',))
    assert not huge(table([b'\x00\x01\x00\x00' + bytes(100)])).good.any()
    with pytest.raises(BagError, match='neither readable'):
        decoder('?' * 10, ('x',))


# In bags ------------------------------------------------------------------------------------------


@pytest.fixture(name='bag')
def _bag(tmp_path, store, joints):
    """A bag with /robot/joints, /robot/w, /robot/y of Float32, and /arm/pose."""
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/robot/joints', JOINTS)
    writer.add('/robot/w', 'std_msgs/msg/Float64')
    writer.add('/robot/y', 'std_msgs/msg/Float32')
    for i in range(100):
        stamp = START + 10**8 * i
        message = joints(i, ('a', 'bc') if i % 3 else ('a', 'bc', 'd'))
        writer.write('/robot/joints', stamp, bytes(store.serialize_cdr(message, JOINTS)))
        writer.write('/robot/w', stamp, b'\x00\x01\x00\x00' + np.float64(i).tobytes())
        writer.write('/robot/y', stamp, b'\x00\x01\x00\x00' + np.float32(i / 2).tobytes())
    writer.close()
    return tmp_path / 'bag'


def complaint(*arguments, **options):
    with pytest.raises(BagError) as caught:
        read_bag(*arguments, **options)
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_a_number_by_topic_and_field(bag):
    recording = read_bag(
        bag, topics=['y:=/robot/joints:velocity[1]', 'u:=/robot/joints:position[0]']
    )
    assert recording.signals['y'].values.tolist() == [1.0 + i for i in range(100)]
    assert set(recording.signals['u'].values.tolist()) == {0.0}
    assert recording.signals['w'].values.tolist() == list(range(100))
    assert recording.topics == {'y': '/robot/joints', 'u': '/robot/joints', 'w': '/robot/w'}
    assert recording.findings == ()


def test_an_element_that_some_messages_lack_is_reported(bag):
    recording = read_bag(bag, topics=['y:=/robot/joints:velocity[2]'])
    assert len(recording.signals['y'].values) == 34
    assert [(f.code, f.signal) for f in recording.findings] == [('not-decoded', 'y')]


def test_float32_says_so_and_how_it_is_named(bag):
    message = complaint(bag)
    assert '/robot/y is std_msgs/msg/Float32' in message
    cure = message.rpartition('--topic ')[2]
    assert cure == 'y:=/robot/y:data'
    for given in (cure, 'y:=/robot/y', 'y:=robot/y'):
        recording = read_bag(bag, topics=[given])
        assert recording.signals['y'].values.tolist() == [i / 2 for i in range(100)]


def test_what_is_asked_for_in_vain_is_one_line_with_what_there_is(bag):
    assert 'has no topic /robot/joint; it has /robot/joints' in complaint(
        bag, topics=['y:=/robot/joint:position[0]']
    )
    message = complaint(bag, topics=['y:=/robot/joints'])
    assert message.endswith('needs a field; it has position[0], velocity[0], effort[0]')
    assert 'has no number name[0]' in complaint(bag, topics=['y:=/robot/joints:name[0]'])
    assert 'must be SIGNAL:=TOPIC' in complaint(bag, topics=['y=/robot/joints'])
    assert 'must be like velocity[2]' in complaint(bag, topics=['y:=/robot/joints:velo city'])
    assert 'name y twice' in complaint(bag, topics=['y:=/a', 'y:=/b'])


def test_only_the_signals_that_are_asked_for(bag):
    recording = read_bag(bag, topics=['y:=/robot/y'], signals={'w', 'y'})
    assert set(recording.signals) == {'w', 'y'}
    assert set(read_bag(bag, 'robot', topics=['y:=/robot/y'], signals={'y'}).signals) == {'y'}


def test_header_times(bag):
    recording = read_bag(bag, topics=['y:=/robot/joints:velocity[0]'], signals={'y'}, time='header')
    assert recording.time == 'header'
    first = 1_795_304_457 * 10**9
    assert recording.signals['y'].stamps.tolist() == [first + 10**8 * i for i in range(100)]
    assert 'time header needs messages with a header, and those of w have none' in complaint(
        bag, topics=['y:=/robot/joints:velocity[0]'], time='header'
    )


def test_log_and_publish_times_as_asked(tmp_path, mcap, database, float64):
    stamps = START + 10**8 * np.arange(50)
    file = mcap().signal(1, '/y', np.arange(50.0), stamps + 12345, stamps)
    path = file.write(tmp_path / 'bag.mcap')
    for time, expected in ((None, stamps), ('publish', stamps), ('log', stamps + 12345)):
        recording = read_bag(path, time=time)
        assert recording.time == (time or 'publish')
        assert np.array_equal(recording.signals['y'].stamps, expected)
    assert 'must be log, publish or header' in complaint(path, time='now')
    rows = [('/y', int(s), float64(1.0)) for s in stamps]
    base = database(tmp_path / 'bag.db3', rows)
    assert read_bag(base).time == 'log'
    assert 'holds no publish times' in complaint(base, time='publish')


@pytest.mark.parametrize('publish', ['zero', 'constant', 'another clock', 'ahead'])
def test_publish_times_that_are_not_plausible(tmp_path, mcap, publish):
    stamps = START + 10**8 * np.arange(50)
    given = {
        'zero': np.zeros(50, int), 'constant': np.full(50, START),
        'another clock': stamps // 2, 'ahead': stamps + 5 * 10**9,
    }[publish]  # fmt: skip
    file = mcap().signal(1, '/y', np.sin(np.arange(50)), stamps, given)
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert recording.time == 'log'
    assert np.array_equal(recording.signals['y'].stamps, stamps)
    assert recording.findings == ()


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_signals_that_were_remapped_are_found_again(tmp_path, storage):
    writer = BagWriter(tmp_path / 'bag', storage, None, None)
    topics = {'w': '/lab/w', 'y': '/arm/membrane', 'u': '/lab/u'}
    writer.name_signals(topics)
    for i, topic in enumerate(topics.values()):
        writer.add(topic, 'std_msgs/msg/Float64')
        writer.write(topic, START, b'\x00\x01\x00\x00' + np.float64(i).tobytes())
    writer.close()
    (file,) = (f for f in (tmp_path / 'bag').iterdir() if f.suffix in ('.mcap', '.db3'))
    for path in (tmp_path / 'bag', file):
        recording = read_bag(path, 'lab')
        assert {n: s.values.tolist() for n, s in recording.signals.items()} == {
            'w': [0.0], 'y': [1.0], 'u': [2.0],
        }  # fmt: skip
        assert recording.topics == topics
        assert read_bag(path, topics=['y:=/lab/u']).topics['y'] == '/lab/u'
