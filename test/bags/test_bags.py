# SPDX-License-Identifier: Apache-2.0
"""Bags: written and read back to the last bit, killed, cut, broken, foreign."""

import math
import shutil
import signal
import sqlite3
import struct
import sys

import numpy as np
import pytest

from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter, write_bag
from eventreg_ros.errors import BagError
from eventreg_ros.runtime.cdr import packed

STORAGES = ('mcap', 'sqlite3')
TEXT = "# a comment\nplant:\n  ros__parameters: {output: 'y'}  # ü, not only ASCII\n"
START = 1_795_304_457_727_915_003

VALUES = [
    0.0, -0.0, 1.0, -1.5, math.pi, 5e-324, -2.2250738585072014e-308, 1.7976931348623157e308,
    math.inf, -math.inf, math.nan, 0.1 + 0.2,
]  # fmt: skip


def zstd(data):
    """Pack bytes as rosbag2 packs a file."""
    if sys.version_info >= (3, 14):
        from compression.zstd import compress
    else:
        from backports.zstd import compress
    return compress(data)


def bits(values):
    return np.asarray(values, dtype=np.float64).view(np.uint64).tolist()


def write(path, storage, samples, scenario=TEXT, name='made', close=True):
    """Write (topic, stamp, value) with a BagWriter and return it."""
    writer = BagWriter(path, storage, scenario, name)
    for topic in dict.fromkeys(topic for topic, _, _ in samples):
        writer.add(topic, FLOAT64)
    for topic, stamp, value in samples:
        writer.write(topic, stamp, packed(value))
    if close:
        writer.close()
    return writer


def complaint(path, *arguments):
    """Return the one line with which a bag is refused."""
    with pytest.raises(BagError) as caught:
        read_bag(path, *arguments)
    message = str(caught.value)
    assert '\n' not in message
    return message


def values_or_complaint(path):
    """Return the values of y and '', or nothing and the one line with which the bag is refused."""
    try:
        return read_bag(path).signals.get('y', ((), np.empty(0)))[1].tolist(), ''
    except BagError as error:
        message = str(error)
    return [], message if '\n' not in message else pytest.fail(message)


# There and back ---------------------------------------------------------------------------------


@pytest.mark.parametrize('storage', STORAGES)
def test_values_and_stamps_come_back_to_the_last_bit(tmp_path, storage):
    samples = [('/y', START + 7 * i, value) for i, value in enumerate(VALUES)]
    samples += [('/w', START + 3, 2.0)]
    write(tmp_path / 'bag', storage, samples)
    recording = read_bag(tmp_path / 'bag')
    assert set(recording.signals) == {'w', 'y'}
    stamps, values = recording.signals['y']
    assert stamps.dtype == np.int64
    assert stamps.tolist() == [START + 7 * i for i in range(len(VALUES))]
    assert bits(values) == bits(VALUES)
    assert (recording.scenario, recording.name) == (TEXT, 'made')


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_of_signals_over_model_time(tmp_path, storage, stamped):
    t = np.arange(1001) * 0.05
    signals = {'w': (t, np.cos(t)), 'y': (t[::2], np.sin(t[::2]))}
    write_bag(tmp_path / 'bag', stamped(signals), 'made', TEXT, storage)
    recording = read_bag(tmp_path / 'bag')
    assert (recording.scenario, recording.name) == (TEXT, 'made')
    assert recording.signals['w'][0].tolist() == [5_000_000 * i for i in range(1001)]
    for name, (times, values) in recording.in_model_time(10.0).items():
        assert times == pytest.approx(signals[name][0], abs=1e-7)  # stamps are whole nanoseconds
        assert bits(values) == bits(signals[name][1])


@pytest.mark.parametrize('storage', STORAGES)
def test_the_storage_file_alone_is_enough(tmp_path, storage):
    write(tmp_path / 'bag', storage, [('/y', START, 1.0)])
    (file,) = (f for f in (tmp_path / 'bag').iterdir() if f.suffix in ('.mcap', '.db3'))
    recording = read_bag(file)
    assert recording.signals['y'][1].tolist() == [1.0]
    assert (recording.scenario, recording.name) == (TEXT, 'made')
    assert read_bag(str(file)).signals.keys() == {'y'}


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_without_a_scenario(tmp_path, storage):
    write(tmp_path / 'bag', storage, [('/y', START, 1.0)], scenario=None, name=None)
    recording = read_bag(tmp_path / 'bag')
    assert (recording.scenario, recording.name) == (None, None)


@pytest.mark.parametrize('storage', STORAGES)
def test_samples_are_ordered_by_their_stamps(tmp_path, storage):
    order = [3, 0, 2, 1, 1]
    write(tmp_path / 'bag', storage, [('/y', START + i, float(n)) for n, i in enumerate(order)])
    stamps, values = read_bag(tmp_path / 'bag').signals['y']
    assert (stamps - START).tolist() == [0, 1, 1, 2, 3]
    assert values.tolist() == [1.0, 3.0, 4.0, 2.0, 0.0]  # equal stamps in the order written


def test_time_begins_with_the_first_sample_of_the_run(tmp_path):
    second = 1_000_000_000
    samples = [('/battery', START, 12.0), ('/u', START + 3 * second, 0.5)]
    samples += [('/y', START + (4 + i) * second, 0.0) for i in range(2)]
    write(tmp_path / 'bag', 'mcap', samples)
    recording = read_bag(tmp_path / 'bag')
    assert recording.start == START + 3 * second
    times = {name: t.tolist() for name, (t, _) in recording.in_model_time(2.0).items()}
    assert times == {'battery': [-6.0], 'u': [0.0], 'y': [2.0, 4.0]}


def test_other_topics_are_left_alone(tmp_path):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/y', FLOAT64)
    writer.add('/spikes/y/count', 'std_msgs/msg/UInt64')
    writer.write('/y', START, packed(1.0))
    writer.write('/spikes/y/count', START, struct.pack('<BBBBQ', 0, 1, 0, 0, 7))
    writer.close()
    assert read_bag(tmp_path / 'bag').signals.keys() == {'y'}


def test_big_and_little_endian_messages(tmp_path):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/y', FLOAT64)
    for i, value in enumerate(VALUES):
        big = struct.pack('>BBBBd', 0, 0, 0, 0, value)
        writer.write('/y', START + i, packed(value) if i % 2 else big)
    writer.close()
    assert bits(read_bag(tmp_path / 'bag').signals['y'][1]) == bits(VALUES)


def test_a_message_as_ros_serializes_it():
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    message = store.types[FLOAT64](data=-1.25)
    assert bytes(store.serialize_cdr(message, FLOAT64)) == packed(-1.25)


# Namespaces -------------------------------------------------------------------------------------


def test_topics_lose_their_namespace(tmp_path):
    write(tmp_path / 'bag', 'mcap', [('/a/b/y', START, 1.0), ('/a/b/w', START, 2.0)])
    assert read_bag(tmp_path / 'bag').signals.keys() == {'w', 'y'}


def test_of_several_namespaces_one_is_chosen(tmp_path):
    samples = [('/a/y', START, 1.0), ('/a/w', START, 2.0), ('/b/y', START, 3.0), ('/y', START, 4.0)]
    write(tmp_path / 'bag', 'mcap', samples)
    message = complaint(tmp_path / 'bag')
    assert 'several namespaces with a y: /, /a, /b; choose one with --namespace' in message
    for namespace, y in {'a': 1.0, '/a': 1.0, '/a/': 1.0, 'b': 3.0, '/': 4.0}.items():
        assert read_bag(tmp_path / 'bag', namespace).signals['y'][1].tolist() == [y]
    assert read_bag(tmp_path / 'bag', 'a').signals.keys() == {'w', 'y'}


def test_a_namespace_that_is_not_there_is_one_line(tmp_path):
    write(tmp_path / 'bag', 'mcap', [('/a/y', START, 1.0)])
    message = complaint(tmp_path / 'bag', 'b')
    assert message.endswith('holds no std_msgs/msg/Float64 topic in namespace /b; it has /a/y')


# Killed writers ---------------------------------------------------------------------------------


@pytest.mark.parametrize('storage', STORAGES)
def test_what_was_flushed_can_be_read_while_the_writer_lives(tmp_path, storage):
    samples = [('/y', START + i, float(i)) for i in range(300)]
    writer = write(tmp_path / 'bag', storage, samples[:200], close=False)
    writer.flush()
    for topic, stamp, value in samples[200:]:
        writer.write(topic, stamp, packed(value))
    recording = read_bag(tmp_path / 'bag')
    assert recording.signals['y'][1].tolist() == [float(i) for i in range(200)]
    assert (recording.scenario, recording.name) == (TEXT, 'made')
    writer.close()
    assert len(read_bag(tmp_path / 'bag').signals['y'][1]) == 300


KILLED = """
import os, signal, sys
from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.runtime.cdr import packed
writer = BagWriter(sys.argv[1], sys.argv[2], 'plant: {ros__parameters: {}}', 'killed')
for topic in ('/w', '/y'):
    writer.add(topic, FLOAT64)
if sys.argv[2] == 'sqlite3':  # so that what is not committed reaches the file before the end
    writer._writer.storage.conn.execute('PRAGMA cache_size=10')
for i in range(30000):
    # y is stamped before w, but written after it: killed bags are not ordered
    writer.write('/w', 1000 * i + 500, packed(float(i)))
    writer.write('/y', 1000 * i, packed(-float(i)))
    if i in (999, 19999):
        writer.flush()
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
@pytest.mark.parametrize('storage', STORAGES)
def test_a_killed_writer_leaves_all_that_it_flushed(tmp_path, python, storage):
    result = python('-c', KILLED, str(tmp_path / 'bag'), storage)
    assert result.returncode == -signal.SIGKILL
    assert not (tmp_path / 'bag' / 'metadata.yaml').exists()
    recording = read_bag(tmp_path / 'bag')
    assert recording.name == 'killed'
    for name, sign in (('w', 1.0), ('y', -1.0)):
        stamps, values = recording.signals[name]
        assert len(values) >= 20000
        assert storage == 'mcap' or len(values) == 20000  # the rest was never committed
        assert np.array_equal(values, sign * np.arange(len(values)))
        assert np.array_equal(stamps, 1000 * np.arange(len(stamps)) + (500 if name == 'w' else 0))


@pytest.mark.slow
def test_a_killed_writer_leaves_its_bag_as_it_was(tmp_path, python):
    for storage in STORAGES:
        python('-c', KILLED, str(tmp_path / storage), storage)
        before = {f.name: f.read_bytes() for f in (tmp_path / storage).iterdir()}
        read_bag(tmp_path / storage)
        assert {f.name: f.read_bytes() for f in (tmp_path / storage).iterdir()} == before


@pytest.mark.parametrize('storage', STORAGES)
def test_a_writer_killed_before_it_flushed(tmp_path, storage):
    writer = write(tmp_path / 'bag', storage, [('/y', START, 1.0)], close=False)
    shutil.copytree(tmp_path / 'bag', tmp_path / 'copy')
    complaint(tmp_path / 'copy')
    writer.close()


def test_a_split_bag_whose_writer_was_killed(tmp_path):
    split = tmp_path / 'split'
    split.mkdir()
    for part in range(3):
        samples = [(t, START + 10 * part + i, part + i / 10) for i in (1, 0) for t in ('/y', '/w')]
        writer = write(tmp_path / f'part_{part}', 'mcap', samples, close=part < 2)
        if part == 2:
            writer.flush()
        shutil.copy(tmp_path / f'part_{part}' / f'part_{part}.mcap', split)
    values = read_bag(split).signals['y'][1]
    assert values.tolist() == [0.0, 0.1, 1.0, 1.1, 2.0, 2.1]


def test_a_database_in_wal_mode_whose_writer_was_killed(tmp_path):
    """The resilient preset of ros2 bag record."""
    write(tmp_path / 'bag', 'sqlite3', [('/y', START, 1.0)])
    connection = sqlite3.connect(tmp_path / 'bag' / 'bag.db3')
    connection.execute('PRAGMA journal_mode=WAL')
    connection.execute('PRAGMA wal_autocheckpoint=0')
    query = 'INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)'
    connection.execute(query, (START + 1, packed(2.0)))
    connection.commit()
    killed = tmp_path / 'killed'
    killed.mkdir()
    for end in ('', '-wal'):
        shutil.copy(tmp_path / 'bag' / f'bag.db3{end}', killed)
    connection.close()
    assert read_bag(killed).signals['y'][1].tolist() == [1.0, 2.0]


@pytest.fixture(scope='module')
def flushed(tmp_path_factory):
    """An unfinished and a finished .mcap, with (size, samples) at each flush."""
    path = tmp_path_factory.mktemp('flushed') / 'bag'
    writer = write(path, 'mcap', [('/y', START, 0.0)], close=False)
    file = path / 'bag.mcap'
    marks = []
    for i in range(1, 60):
        if i % 20 == 0:
            writer.flush()
            marks.append((file.stat().st_size, i))
        writer.write('/y', START + i, packed(float(i)))
    writer.flush()
    marks.append((file.stat().st_size, 60))
    unfinished = file.read_bytes()
    writer.close()
    return unfinished, file.read_bytes(), marks


def cuts(data, marks):
    """Sizes to cut a file to: around every boundary, and many others."""
    edges = {0, 8, len(data), *(size for size, _ in marks)}
    near = {edge + d for edge in edges for d in range(-12, 13)}
    return sorted(c for c in near | set(range(0, len(data), 61)) if 0 <= c < len(data))


@pytest.mark.parametrize('finished', [False, True])
def test_a_file_cut_anywhere_gives_what_was_flushed_or_one_line(tmp_path, flushed, finished):
    data, marks = flushed[finished], flushed[2]
    file = tmp_path / 'cut.mcap'
    for size in cuts(data, marks):
        file.write_bytes(data[:size])
        whole = max((n for end, n in marks if end <= size), default=0)
        values, message = values_or_complaint(file)
        assert values == [float(i) for i in range(len(values))]
        assert len(values) >= whole, f'cut at {size}: {message}'
        assert bool(message) == (values == [])


def test_a_cut_database_gives_part_of_it_or_one_line(tmp_path):
    samples = [('/y', START + i, float(i)) for i in range(3000)]
    write(tmp_path / 'bag', 'sqlite3', samples)
    data = (tmp_path / 'bag' / 'bag.db3').read_bytes()
    (tmp_path / 'cut').mkdir()
    for size in [*range(0, 200, 13), *range(200, len(data), 4096 + 511)]:
        (tmp_path / 'cut' / 'cut.db3').write_bytes(data[:size])
        values, message = values_or_complaint(tmp_path / 'cut')
        assert set(values) <= {float(i) for i in range(3000)}
        assert bool(message) == (values == [])


@pytest.mark.parametrize('storage', STORAGES)
def test_damaged_bytes_never_crash(tmp_path, storage):
    write(tmp_path / 'bag', storage, [('/y', START + i, float(i)) for i in range(50)])
    (file,) = (f for f in (tmp_path / 'bag').iterdir() if f.suffix in ('.mcap', '.db3'))
    data = file.read_bytes()
    rng = np.random.default_rng(8)
    damaged = tmp_path / file.name
    for where in rng.integers(0, len(data), 80):
        damaged.write_bytes(data[:where] + bytes([data[where] ^ 0xFF]) + data[where + 1 :])
        values_or_complaint(damaged)


# Broken, empty, foreign -------------------------------------------------------------------------


def test_a_bag_that_does_not_exist(tmp_path):
    assert complaint(tmp_path / 'no') == f'bag {tmp_path}/no does not exist; check the path'


def test_a_directory_that_is_no_bag(tmp_path):
    assert 'is no bag: it holds neither metadata.yaml nor' in complaint(tmp_path)


@pytest.mark.parametrize('name', ['notes.txt', 'notes', 'notes.mcap', 'notes.db3'])
def test_a_text_file(tmp_path, name):
    (tmp_path / name).write_text('hello\nthere\n' * 100)
    assert f'{name} cannot be read' in complaint(tmp_path / name)


@pytest.mark.parametrize('name', ['empty.mcap', 'empty.db3'])
def test_an_empty_file(tmp_path, name):
    (tmp_path / name).touch()
    assert f'{name} cannot be read' in complaint(tmp_path / name)


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_without_a_sample(tmp_path, storage):
    writer = BagWriter(tmp_path / 'bag', storage, TEXT, 'made')
    writer.add('/y', FLOAT64)
    writer.close()
    assert complaint(tmp_path / 'bag').endswith('record while the nodes run')


@pytest.mark.parametrize('storage', STORAGES)
def test_a_bag_without_a_topic(tmp_path, storage):
    BagWriter(tmp_path / 'bag', storage, TEXT, 'made').close()
    assert 'holds no std_msgs/msg/Float64 topic (it has none)' in complaint(tmp_path / 'bag')


def test_a_bag_of_something_else(tmp_path):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/chatter', 'std_msgs/msg/String')
    writer.write('/chatter', START, b'\x00\x01\x00\x00\x02\x00\x00\x00a\x00')
    writer.close()
    message = complaint(tmp_path / 'bag')
    assert '(it has /chatter (std_msgs/msg/String)); record w, v, y, y_r and u' in message


@pytest.mark.parametrize('data', [b'', b'\x00\x01\x00\x00', packed(1.0) + b'\x00' * 4])
def test_a_message_of_the_wrong_size(tmp_path, data):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/y', FLOAT64)
    writer.write('/y', START, data)
    writer.close()
    assert 'a message on y is not a Float64' in complaint(tmp_path / 'bag')


def test_a_ros_1_bag(tmp_path):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    with Writer(tmp_path / 'old.bag') as writer:
        store = get_typestore(Stores.ROS1_NOETIC)
        connection = writer.add_connection('/y', FLOAT64, typestore=store)
        writer.write(connection, 1, struct.pack('<d', 1.0))
    message = complaint(tmp_path / 'old.bag')
    assert message.endswith('is a ROS 1 bag; bring it to ROS 2 with rosbags-convert')


@pytest.mark.parametrize('text', ['', '}{', 'rosbag2_bagfile_information: 3', '[1, 2]', '\x00'])
def test_broken_metadata_is_no_obstacle_and_reported(tmp_path, text):
    write(tmp_path / 'bag', 'mcap', [('/y', START, 1.0)])
    (tmp_path / 'bag' / 'metadata.yaml').write_text(text)
    recording = read_bag(tmp_path / 'bag')
    assert recording.signals['y'].values.tolist() == [1.0]
    assert [finding.code for finding in recording.findings] == ['metadata-disagrees']


def test_metadata_of_files_that_are_gone(tmp_path):
    write(tmp_path / 'bag', 'mcap', [('/y', START, 1.0)])
    (tmp_path / 'bag' / 'bag.mcap').unlink()
    assert 'has none of the files that its metadata.yaml names (bag.mcap)' in complaint(
        tmp_path / 'bag'
    )


def test_without_a_library_the_message_says_which(tmp_path, monkeypatch):
    write(tmp_path / 'bag', 'sqlite3', [('/y', START, 1.0)])
    packed_file = tmp_path / 'bag.db3.zstd'
    packed_file.write_bytes(zstd((tmp_path / 'bag' / 'bag.db3').read_bytes()))
    for name in ('backports.zstd', 'compression.zstd'):
        monkeypatch.setitem(sys.modules, name, None)
    assert 'pip install' in complaint(packed_file)


# Writing where it cannot be ---------------------------------------------------------------------


def test_an_existing_bag_is_not_touched(tmp_path):
    write(tmp_path / 'bag', 'mcap', [('/y', START, 1.0)])
    with pytest.raises(BagError, match='exists already; remove it or name another directory'):
        BagWriter(tmp_path / 'bag', 'mcap', None, None)
    assert read_bag(tmp_path / 'bag').signals['y'][1].tolist() == [1.0]


def test_a_place_where_no_bag_can_be(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(BagError) as caught:
        BagWriter(tmp_path / 'file' / 'bag', 'mcap', None, None)
    assert str(caught.value).endswith('name another directory')
    assert '\n' not in str(caught.value)
