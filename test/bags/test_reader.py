# SPDX-License-Identifier: Apache-2.0
"""Recordings that go wrong, each in its kind: what is read of them, and what is said."""

import os
import shutil
import socket

import numpy as np
import pytest

from eventreg_ros.bags.finding import CODES, IMPAIRING
from eventreg_ros.bags.reader import read_bag, read_messages
from eventreg_ros.bags.writer import BagWriter, write_bag
from eventreg_ros.errors import BagError

START = 1_795_304_457_727_915_003
STEP = 50_000_000
N = 801
T = 0.5 * np.arange(N)
W, Y, U = 2 * np.sin(T / 6) ** 3, 0.4 * np.exp(-T / 9) * np.cos(T), 2 * np.sin(T / 6 + 0.1) ** 3
OTHER = {'/w': 2 * np.sin(T / 5 + 1) ** 3, '/y': 1.5 * np.sin(T / 5) ** 5, '/u': np.cos(T / 4)}
SIGNALS = {'/w': W, '/y': Y, '/u': U}
STAMPS = START + STEP * np.arange(N)


@pytest.fixture(name='loop')
def _loop(mcap):
    """An MCAP file of w, y and u, in chunks, with everything that a good one has."""

    def make(signals=SIGNALS, stamps=STAMPS, **options):
        file = mcap(**{'chunk': 300, **options})
        for number, (topic, values) in enumerate(signals.items()):
            file.signal(number + 1, topic, values, stamps)
        return file.ordered()

    return make


def codes(recording):
    """The codes of the findings, each once."""
    assert {finding.code for finding in recording.findings} <= set(CODES)
    for finding in recording.findings:
        assert '\n' not in finding.text
        assert len(finding.text) <= 300
    return sorted({finding.code for finding in recording.findings})


def read(path, **options):
    """Read a bag of the loop; its signals must be those of the loop."""
    recording = read_bag(path, **options)
    for topic, values in SIGNALS.items():
        assert np.array_equal(recording.signals[topic[1:]].values, values, equal_nan=True)
        assert np.array_equal(recording.signals[topic[1:]].stamps, STAMPS)
    return recording


# Good bags, whatever their writer ----------------------------------------------------------------


@pytest.mark.parametrize(
    'options',
    [
        {},
        {'crc': True, 'data_crc': True},
        {'chunk': 0},
        {'chunk': 0, 'data_crc': True},
        {'chunk': 7},
        {'compression': 'zstd', 'crc': True},
        {'compression': 'lz4'},
        {'message_index': False},
        {'repeated_schemas': False},
        {'repeated_channels': False},
        {'statistics': False},
        {'profile': ''},
        {'schemas': {1: ('std_msgs/Float64', 'ros2msg', 'float64 data')}},
        {'schemas': {1: ('std_msgs/msg/Float64', 'ros2idl', '}{')}},
        {'between': b'\x80' + (5).to_bytes(8, 'little') + b'other'},
        {'between': b'\x09' + (300).to_bytes(8, 'little') + bytes(range(256)) + bytes(44)},
    ],
)
def test_a_good_bag_gives_its_samples_and_no_finding(tmp_path, loop, options):
    recording = read(loop(**options).write(tmp_path / 'bag.mcap'))
    assert recording.findings == ()
    assert recording.time == 'publish'
    assert recording.topics == {'w': '/w', 'y': '/y', 'u': '/u'}


def test_a_channel_that_nobody_can_parse_is_no_obstacle(tmp_path, loop):
    file = loop()
    file.schemas |= {2: ('foxglove.Log', 'jsonschema', '{'), 3: ('a/srv/B_Event', 'ros2msg', '?')}
    file.channels |= {7: ('/log', 2, 'json'), 8: ('/add/_service_event', 3, 'cdr')}
    file.messages[100:100] = [(7, START, START, b'{}'), (8, START, START, b'\x00' * 77)]
    assert read(file.write(tmp_path / 'bag.mcap')).findings == ()


def test_messages_out_of_order_are_put_in_order(tmp_path, loop):
    file = loop(chunk=0)
    rng = np.random.default_rng(4)
    order = np.argsort([m[1] + rng.integers(0, 14 * STEP) for m in file.messages])
    file.messages = [file.messages[i] for i in order]
    assert read(file.write(tmp_path / 'bag.mcap')).findings == ()


@pytest.mark.parametrize('chunk', [0, 60])
def test_parts_in_another_order_are_put_in_order(tmp_path, loop, chunk):
    file = loop(chunk=chunk)
    parts = [file.messages[i : i + 600] for i in range(0, len(file.messages), 600)]
    file.messages = [message for part in parts[::-1] for message in part]
    assert read(file.write(tmp_path / 'bag.mcap')).findings == ()


@pytest.mark.parametrize('schema', [1, 2, 3, 4])
@pytest.mark.parametrize('page_size', [512, 4096, 65536])
def test_databases_of_every_version(tmp_path, database, float64, schema, page_size):
    rows = [(t, int(s), float64(v[i])) for i, s in enumerate(STAMPS) for t, v in SIGNALS.items()]
    database(tmp_path / 'bag.db3', rows, schema=schema, page_size=page_size)
    recording = read(tmp_path / 'bag.db3')
    assert recording.findings == ()
    assert recording.time == 'log'


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_split_packed_alone_and_without_metadata_are_the_same(tmp_path, zstd, storage):
    signals = {t[1:]: (STAMPS.tolist(), v) for t, v in SIGNALS.items()}
    write_bag(tmp_path / 'bag', signals, 'made', 'plant: {}', storage)
    (file,) = (f for f in (tmp_path / 'bag').iterdir() if f.suffix in ('.mcap', '.db3'))
    for name, content in (('packed', zstd(file.read_bytes())), ('plain', file.read_bytes())):
        (tmp_path / name).mkdir()
        ending = '.zstd' if name == 'packed' else ''
        (tmp_path / name / (file.name + ending)).write_bytes(content)
    split = tmp_path / 'split'
    split.mkdir()
    for part in range(12):
        some = slice(part * 70, part * 70 + 70)
        pieces = {n: (s[some], v[some]) for n, (s, v) in signals.items()}
        write_bag(tmp_path / f'p{part}', pieces, 'made', 'plant: {}', storage)
        shutil.copy(
            tmp_path / f'p{part}' / f'p{part}{file.suffix}', split / f's_{part}{file.suffix}'
        )
    for path in (tmp_path / 'bag', tmp_path / 'packed', tmp_path / 'plain', split, file):
        recording = read(path)
        assert recording.findings == ()
        assert storage == 'sqlite3' or recording.scenario == 'plant: {}'


def test_messages_that_are_packed_one_by_one(tmp_path, database, float64, zstd):
    rows = [
        (t, int(s), zstd(float64(v[i]))) for i, s in enumerate(STAMPS) for t, v in SIGNALS.items()
    ]
    assert read(database(tmp_path / 'bag.db3', rows)).findings == ()


def test_what_the_metadata_say_otherwise_does_not_matter(tmp_path, loop):
    write_bag(tmp_path / 'bag', {'y': ([START], [1.0])}, 'made', 'plant: {}')
    text = (tmp_path / 'bag' / 'metadata.yaml').read_text()
    for old, new in (("'mcap'", "''"), ('storage_identifier: mcap', 'storage_identifier: ""')):
        text = text.replace(old, new)
    (tmp_path / 'bag' / 'metadata.yaml').write_text(text.replace('version: 9', 'version: 3'))
    recording = read_bag(tmp_path / 'bag')
    assert recording.findings == ()
    assert (recording.scenario, recording.name) == ('plant: {}', 'made')


def test_the_scenario_of_a_file_alone_is_in_the_file_or_beside(tmp_path, loop):
    write_bag(tmp_path / 'bag', {'y': ([START], [1.0])}, 'made', 'plant: {}')
    alone = shutil.copy(tmp_path / 'bag' / 'bag.mcap', tmp_path / 'alone.mcap')
    assert read_bag(alone).scenario == 'plant: {}'
    (tmp_path / 'x').mkdir()
    bare = loop().write(tmp_path / 'x' / 'bare.mcap')
    (tmp_path / 'x' / 'one.scenario.yaml').write_text('one: {}')
    assert (read(bare).scenario, read(bare).name) == ('one: {}', 'one')
    (tmp_path / 'x' / 'two.scenario.yaml').write_text('two: {}')
    assert read(bare).scenario is None


# Two runs, two writers ---------------------------------------------------------------------------


def test_a_second_run_under_the_stamps_of_the_first(tmp_path, loop):
    file, second = loop(), loop(OTHER)
    file.messages += second.messages
    recording = read(file.write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['second-run']
    assert [finding.signal for finding in recording.findings] == ['w', 'y', 'u']
    assert {finding.at for finding in recording.findings} == {0.0}


def test_two_recordings_in_one_directory(tmp_path, loop):
    for name, signals in (('a_0.mcap', SIGNALS), ('b_0.mcap', OTHER)):
        loop(signals).write(tmp_path / name)
    assert codes(read(tmp_path)) == ['second-run']


def test_a_second_run_interleaved_under_the_same_stamps(tmp_path, loop):
    file, second = loop(), loop(OTHER, stamps=STAMPS)
    late = [m for m in second.messages if m[1] >= START + 300 * STEP]
    file.messages = sorted(file.messages + late, key=lambda m: m[1])
    recording = read(file.write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['second-writer']
    assert [finding.at for finding in recording.findings] == pytest.approx([15.0] * 3)


def test_two_publishers_of_one_signal(tmp_path, loop):
    file = loop()
    file.messages += [
        (2, m[1] + STEP // 2, m[2] + STEP // 2, m[3])
        for m in loop({'/w': W, '/y': Y + 1.0, '/u': U}).messages
        if m[0] == 2
    ]
    recording = read_bag(file.ordered().write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['second-writer']
    assert [finding.signal for finding in recording.findings] == ['y']
    assert len(recording.signals['y'].values) == 2 * N


def test_two_channels_of_one_topic(tmp_path, loop):
    file = loop().signal(9, '/y', Y, STAMPS + STEP // 2)
    recording = read_bag(file.ordered().write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['second-writer']
    again = loop().signal(9, '/y', Y[:5], STAMPS[:5] + N * STEP)
    assert read_bag(again.ordered().write(tmp_path / 'again.mcap')).findings == ()


def test_a_clock_that_was_set_back(tmp_path, loop):
    stamps = np.where(np.arange(N) < 500, STAMPS, STAMPS - 3000 * 1_000_000_000)
    file = loop(stamps=stamps)
    file.messages = [
        m
        for i in range(N)
        for m in (
            (k + 1, int(stamps[i]), int(stamps[i]), file_data)
            for k, file_data in enumerate(data(i) for data in map(_data, SIGNALS.values()))
        )
    ]
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['second-run']
    assert np.array_equal(recording.signals['w'].values, W[:500])


def _data(values):
    return lambda i: b'\x00\x01\x00\x00' + np.float64(values[i]).tobytes()


# Stamps ------------------------------------------------------------------------------------------


def test_log_times_without_sense_where_the_publish_times_are_good(tmp_path, mcap):
    for name, log in {
        'tenth': np.where(np.arange(N) < 80, 0, STAMPS),
        'one': np.where(np.arange(N) == 1, 1, STAMPS),
        'all': np.zeros(N, int),
    }.items():
        file = mcap(chunk=500)
        for number, (topic, values) in enumerate(SIGNALS.items()):
            file.signal(number + 1, topic, values, log, STAMPS)
        recording = read(file.write(tmp_path / f'{name}.mcap'))
        assert codes(recording) == ['log-stamps']
        assert not set(codes(recording)) & IMPAIRING


def test_stamps_from_before_the_first_clock_are_left_out_and_time_begins_with_the_run(
    tmp_path, database, float64
):
    stamps = np.where(np.arange(N) < 80, 0, STAMPS)
    rows = [(t, int(s), float64(v[i])) for i, s in enumerate(stamps) for t, v in SIGNALS.items()]
    recording = read_bag(database(tmp_path / 'bag.db3', rows))
    assert codes(recording) == ['nonsense-stamps']
    assert recording.start == START
    t, values = recording.in_model_time(10.0)['w']
    assert np.array_equal(values, W[80:])
    assert t == pytest.approx(T[80:])


def test_bad_stamps_that_a_file_holds_first_do_not_shift_the_run(tmp_path, database, float64):
    stamps = {t: STAMPS.copy() for t in SIGNALS}
    stamps['/y'][[300, 401, 555]] = [1, 2, 3]
    rows = [(t, int(s), float64(v[i])) for t, v in SIGNALS.items() for i, s in enumerate(stamps[t])]
    recording = read_bag(database(tmp_path / 'bag.db3', sorted(rows, key=lambda row: row[1])))
    assert codes(recording) == ['nonsense-stamps']
    assert recording.start == START


@pytest.mark.parametrize('wrong', [1, -(2**63), 2**63 - 1, START - 3_700_000_000_000, START * 3])
@pytest.mark.parametrize('where', [0, 1, 400, N - 1])
def test_one_stamp_without_sense_is_left_out(tmp_path, database, float64, where, wrong):
    stamps = [wrong if i == where else int(s) for i, s in enumerate(STAMPS)]
    rows = [('/y', s, float64(v)) for s, v in zip(stamps, Y, strict=True)]
    recording = read_bag(database(tmp_path / 'bag.db3', rows))
    assert codes(recording) == ['nonsense-stamps']
    assert np.array_equal(recording.signals['y'].values, np.delete(Y, where))
    assert recording.start == START


@pytest.mark.parametrize('shift', [7 * STEP, 60 * STEP, -60 * STEP, 2_000_000_000_000, STEP // 3])
def test_one_stamp_that_was_changed_a_little(tmp_path, database, float64, shift):
    stamps = STAMPS.copy()
    stamps[400] += shift
    rows = [('/y', int(s), float64(v)) for s, v in zip(stamps, Y, strict=True)]
    recording = read_bag(database(tmp_path / 'bag.db3', rows))
    assert codes(recording) in (
        ['nonsense-stamps'], ['stamps-stand-still'], ['stamps-off-grid'],
    )  # fmt: skip
    assert recording.start == START


def test_publish_times_of_which_one_was_changed(tmp_path, mcap):
    for shift in (7 * STEP, 3_000_000_000, 4000 * 1_000_000_000, -(10**17)):
        publish = STAMPS + np.random.default_rng(1).integers(-90_000, 0, N)
        publish[400] += shift
        file = mcap(chunk=100).signal(1, '/y', Y, STAMPS, publish)
        recording = read_bag(file.write(tmp_path / 'bag.mcap'))
        assert recording.time == 'publish'
        assert shift == 7 * STEP or codes(recording) != []


def test_stamps_that_stand_still(tmp_path, loop):
    stamps = STAMPS.copy()
    stamps[300:350] = stamps[300]
    recording = read_bag(loop(stamps=stamps).write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['stamps-stand-still']
    assert [finding.at for finding in recording.findings] == pytest.approx([15.0] * 3)
    assert len(recording.signals['y'].values) == N


def test_a_clock_that_is_too_slow_is_no_second_writer(tmp_path, loop):
    stamps = START + np.arange(N) // 2 * (2 * STEP)
    assert codes(read_bag(loop(stamps=stamps).write(tmp_path / 'bag.mcap'))) == [
        'stamps-stand-still'
    ]


def test_a_jump_of_hours_keeps_the_larger_part(tmp_path, loop):
    stamps = STAMPS + np.where(np.arange(N) < 500, 0, 7_200_000_000_000)
    recording = read_bag(loop(stamps=stamps).write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['stamps-jump']
    assert np.array_equal(recording.signals['w'].values, W[:500])


# Values ------------------------------------------------------------------------------------------


@pytest.mark.parametrize('value', [2.6e300, -1e9, 3.0])
def test_a_lone_sample_is_worth_a_word(tmp_path, loop, value):
    y = Y.copy()
    y[500] = value
    recording = read_bag(loop({**SIGNALS, '/y': y}).write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['lone-sample']
    assert recording.findings[0][1:3] == ('y', 25.0)
    assert not set(codes(recording)) & IMPAIRING


def test_what_is_not_a_number_stays(tmp_path, loop):
    y = np.where(np.arange(N) % 7, Y, np.nan)
    recording = read_bag(loop({**SIGNALS, '/y': y}).write(tmp_path / 'bag.mcap'))
    assert recording.findings == ()
    assert np.array_equal(recording.signals['y'].values, y, equal_nan=True)


def test_messages_that_are_no_float64_are_left_out_and_counted(tmp_path, loop):
    file = loop()
    of_y = [i for i, m in enumerate(file.messages) if m[0] == 2]
    for i in of_y[100:103]:
        file.messages[i] = (*file.messages[i][:3], b'\x00\x01\x00\x00\x00')
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert codes(recording) == ['not-decoded']
    assert '3 of 801' in recording.findings[0].text
    assert np.array_equal(recording.signals['y'].values, np.delete(Y, [100, 101, 102]))


# Damage ------------------------------------------------------------------------------------------


@pytest.mark.parametrize('chunk', [0, 600, 10_000])
def test_zeroed_bytes_cost_what_they_hit(tmp_path, loop, chunk):
    data = bytearray(loop(chunk=chunk).bytes())
    data[40_000:40_512] = bytes(512)
    (tmp_path / 'bag.mcap').write_bytes(data)
    recording = read_bag(tmp_path / 'bag.mcap')
    assert codes(recording) == ['damaged', 'lost-samples']
    for signal, values in (('w', W), ('y', Y), ('u', U)):
        found = recording.signals[signal].values
        assert N - 6 <= len(found) < N
        assert set(found) <= set(values)
    lost = [finding for finding in recording.findings if finding.code == 'lost-samples']
    assert f'{len(recording.signals["w"].values)} of {N}' in lost[0].text
    where = len(recording.signals['w'].values[recording.signals['w'].stamps < START + 15 * STEP])
    assert where == 15
    assert all(10.0 < finding.at < 20.0 for finding in recording.findings)


@pytest.mark.parametrize('compression', ['', 'zstd', 'lz4'])
def test_a_chunk_that_fails_its_checksum(tmp_path, loop, compression):
    good = loop(crc=True, compression=compression, chunk=300).bytes()
    data = bytearray(good)
    data[len(data) // 2] ^= 0x10
    (tmp_path / 'bag.mcap').write_bytes(data)
    recording = read_bag(tmp_path / 'bag.mcap')
    assert set(codes(recording)) & {'checksum', 'damaged'}
    assert len(recording.signals['w'].values) >= N - 100


def test_one_wrong_byte_of_an_unchunked_file_fails_the_checksum_of_the_data(tmp_path, loop):
    data = bytearray(loop(chunk=0, data_crc=True).bytes())
    place = data.index(np.float64(Y[400]).tobytes())
    data[place] ^= 1
    (tmp_path / 'bag.mcap').write_bytes(data)
    assert codes(read_bag(tmp_path / 'bag.mcap')) == ['checksum']


@pytest.mark.parametrize('chunk', [0, 300])
def test_a_file_without_its_end(tmp_path, loop, chunk):
    data = loop(chunk=chunk).bytes()
    (tmp_path / 'bag.mcap').write_bytes(data[: len(data) // 2])
    recording = read_bag(tmp_path / 'bag.mcap')
    assert codes(recording) == ['no-end']
    assert not set(codes(recording)) & IMPAIRING
    found = recording.signals['y'].values
    assert len(found) > N // 3
    assert np.array_equal(found, Y[: len(found)])


def chunks_of(data):
    """Where the chunks of an MCAP file begin."""
    at, found = 8, []
    while at + 9 <= len(data) - 8:
        found += [at] * (data[at] == 6)
        at += 9 + int.from_bytes(data[at + 1 : at + 9], 'little')
    return found


@pytest.mark.parametrize('compression', ['', 'zstd'])
def test_a_chunk_that_was_cut_is_left_out_unless_it_is_all(tmp_path, loop, compression):
    data = loop(chunk=300, compression=compression, crc=True).bytes()
    (tmp_path / 'bag.mcap').write_bytes(data[: chunks_of(data)[3] + 500])
    recording = read_bag(tmp_path / 'bag.mcap')
    assert [finding.code for finding in recording.findings] == ['no-end']
    assert 'its last chunk' in recording.findings[0].text
    assert len(recording.signals['w'].values) == 300
    whole = loop(chunk=9999).bytes()
    (tmp_path / 'one.mcap').write_bytes(whole[: len(whole) // 2])
    assert len(read_bag(tmp_path / 'one.mcap').signals['w'].values) > 200


def test_statistics_that_promise_more_or_less(tmp_path, loop):
    more = loop(counts={1: N, 2: N + 9, 3: N}, message_index=False)
    assert codes(read(more.write(tmp_path / 'more.mcap'))) == ['lost-samples']
    less = loop(counts={1: N, 2: N - 9, 3: N}, message_index=False)
    assert codes(read(less.write(tmp_path / 'less.mcap'))) == ['summary-disagrees']


def test_metadata_that_are_stale(tmp_path, loop):
    signals = {t[1:]: (STAMPS.tolist(), v) for t, v in SIGNALS.items()}
    write_bag(tmp_path / 'bag', {n: (s[:700], v[:700]) for n, (s, v) in signals.items()}, 'x', '')
    write_bag(tmp_path / 'rest', {n: (s[700:], v[700:]) for n, (s, v) in signals.items()}, 'x', '')
    shutil.copy(tmp_path / 'rest' / 'rest.mcap', tmp_path / 'bag' / 'bag_1.mcap')
    recording = read(tmp_path / 'bag')
    assert codes(recording) == ['metadata-disagrees']
    assert not set(codes(recording)) & IMPAIRING


def test_a_file_that_is_missing_or_no_bag(tmp_path):
    signals = {t[1:]: (STAMPS.tolist(), v) for t, v in SIGNALS.items()}
    write_bag(tmp_path / 'bag', signals, 'x', '')
    metadata = tmp_path / 'bag' / 'metadata.yaml'
    text = metadata.read_text()
    name = text.index('- bag.mcap')
    metadata.write_text(text[:name] + '- gone.mcap\n  ' + text[name:])
    assert codes(read(tmp_path / 'bag')) == ['missing-file']
    (tmp_path / 'bag' / 'gone.mcap').write_text('hello, this is no bag at all')
    assert codes(read(tmp_path / 'bag')) == ['missing-file']
    (tmp_path / 'bag' / 'gone.mcap').write_bytes(b'')
    assert codes(read(tmp_path / 'bag')) == ['no-end']
    (tmp_path / 'bag' / '._bag.mcap').write_bytes(b'a resource fork')
    assert codes(read(tmp_path / 'bag')) == ['no-end']


def test_a_channel_that_data_and_summary_name_differently(tmp_path, loop):
    data = loop(chunk=0).bytes()
    (tmp_path / 'bag.mcap').write_bytes(data.replace(b'/y', b'/x', 1))
    assert codes(read_bag(tmp_path / 'bag.mcap')) == ['topic-disagrees']


# Refused, in one line ----------------------------------------------------------------------------


def complaint(path, **options):
    with pytest.raises(BagError) as caught:
        read_bag(path, **options)
    message = str(caught.value)
    assert '\n' not in message
    assert len(message) <= 300
    return message


def test_devices_pipes_and_sockets_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / 'pipe.mcap')
    with socket.socket(socket.AF_UNIX) as one:
        here = os.getcwd()
        os.chdir(tmp_path)
        one.bind('socket.mcap')
        os.chdir(here)
        for path in ('/dev/zero', '/dev/null', tmp_path / 'pipe.mcap', tmp_path / 'socket.mcap'):
            assert 'is a device, a pipe or a socket' in complaint(path)
    assert 'is no bag' in complaint(tmp_path)


def test_a_chunk_that_unpacks_to_gigabytes_is_left_out(tmp_path, mcap, loop):
    bomb = mcap(chunk=10, compression='zstd').signal(1, '/y', [])
    data = bytearray(bomb.bytes())
    place = data.index(b'zstd') - 4 - 28
    data[place + 16 : place + 24] = (2**32).to_bytes(8, 'little')
    (tmp_path / 'bomb.mcap').write_bytes(data)
    assert 'claims to unpack' in complaint(tmp_path / 'bomb.mcap')


BOMB = """
import resource, sys
from eventreg_ros.bags import compression
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.errors import BagError
compression.FREE = 2**26
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    read_bag(sys.argv[1])
except BagError as error:
    print(error)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""


@pytest.mark.slow
@pytest.mark.parametrize('kind', ['file', 'chunk'])
def test_what_unpacks_without_end_takes_little_memory(tmp_path, python, zstd, mcap, kind):
    zeros = zstd(bytes(2**28))
    path = tmp_path / 'bag.mcap.zstd'
    if kind == 'file':
        path.write_bytes(zeros)
    else:
        head = b'\x06' + (40 + 4 + len(zeros)).to_bytes(8, 'little') + bytes(16)
        head += (2**26).to_bytes(8, 'little') + bytes(4) + b'\x04\x00\x00\x00zstd'
        data = mcap().signal(1, '/y', [1.0]).data()
        path = tmp_path / 'bag.mcap'
        path.write_bytes(data + head + len(zeros).to_bytes(8, 'little') + zeros)
    *lines, memory = python('-c', BOMB, str(path)).stdout.splitlines()
    assert len(lines) == (kind == 'file')
    assert int(memory) < 100


def test_a_ros_1_bag_says_so_whatever_its_name(tmp_path):
    (tmp_path / 'old.mcap').write_bytes(b'#ROSBAG V2.0\n' + bytes(100))
    assert 'is a ROS 1 bag' in complaint(tmp_path / 'old.mcap')


def test_messages_of_ros_1_say_so(tmp_path, loop):
    file = loop(profile='ros1')
    file.channels = {n: (topic, s, 'ros1') for n, (topic, s, _) in file.channels.items()}
    assert "encoded as 'ros1'" in complaint(file.write(tmp_path / 'bag.mcap'))


def test_what_is_in_a_file_cannot_break_a_line(tmp_path, mcap):
    file = mcap(schemas={1: ('a/msg/B\nTraceback', 'ros2msg', '')})
    file.signal(1, '/x\ny\x1b[2J' + 'z' * 1000, [1.0])
    assert '\x1b' not in complaint(file.write(tmp_path / 'bag.mcap'))


# Other messages ----------------------------------------------------------------------------------


def test_messages_of_any_topic_as_they_are(tmp_path):
    writer = BagWriter(tmp_path / 'bag', 'mcap', None, None)
    writer.add('/parameter_events', 'rcl_interfaces/msg/ParameterEvent')
    writer.add('/verdict', 'diagnostic_msgs/msg/DiagnosticStatus')
    for i in range(5):
        writer.write('/parameter_events', START + i, b'\x00\x01\x00\x00' + bytes(i))
    writer.close()
    found = read_messages(tmp_path / 'bag', ['/parameter_events', '/verdict', 'nowhere'])
    assert found['/verdict'] == found['nowhere'] == []
    assert [m.log for m in found['/parameter_events']] == [START + i for i in range(5)]
    assert [len(m.data) for m in found['/parameter_events']] == [4, 5, 6, 7, 8]
    assert found['/parameter_events'][0].type == 'rcl_interfaces/msg/ParameterEvent'


def test_a_reader_does_not_change_the_bag(tmp_path, loop):
    path = loop().write(tmp_path / 'bag.mcap')
    before = (path.read_bytes(), path.stat().st_mtime_ns, sorted(tmp_path.iterdir()))
    read(path)
    assert before == (path.read_bytes(), path.stat().st_mtime_ns, sorted(tmp_path.iterdir()))
