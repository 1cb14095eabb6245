# SPDX-License-Identifier: Apache-2.0
"""The bytes of MCAP files: many messages at a time, large chunks, checksums, and what we write."""

import struct
from contextlib import suppress
from zlib import crc32

import numpy as np
import pytest

from eventreg_ros.bags import mcap_contents, mcap_file, tape
from eventreg_ros.bags.channel import FLOAT64, each
from eventreg_ros.bags.mcap_file import read_mcap
from eventreg_ros.bags.mcap_messages import Chain, Table, items, parted
from eventreg_ros.bags.mcap_records import MAGIC, find_record
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.tape import Tape, joined
from eventreg_ros.bags.writer import BagWriter, write_bag
from eventreg_ros.errors import BagError

START = 1_795_304_457_727_915_003


class Keeper:
    """Keeps log time, publish time and bytes of messages."""

    def __init__(self):
        self.found = []

    def expect(self, count):
        pass

    def take(self, messages):
        publish = messages.log if messages.publish is None else messages.publish
        parts = sorted(pair for group in messages.groups for pair in each(group))
        assert [i for i, _ in parts] == list(range(len(messages.log)))
        self.found += zip(
            messages.log.tolist(), publish.tolist(), [d for _, d in parts], strict=True
        )


def one_by_one(data):
    """What a buffer holds, record by record: (opcode, start, end)."""
    at, found = 0, []
    while at + 9 <= len(data):
        length = int.from_bytes(data[at + 1 : at + 9], 'little')
        found.append((data[at], at, at + 9 + length))
        at += 9 + length
    return found


def random_records(rng, mixed):
    """Message records on 3 channels, of one length or many, now and then another record."""
    pieces = []
    for i in range(2000):
        data = bytes(12) if not mixed else rng.bytes(int(rng.choice([0, 1, 5, 12, 12, 12, 300])))
        if rng.random() < 0.3:
            data = (b'\x05\x16' + bytes(7) + data)[: len(data)]  # looks like a record's beginning
        head = struct.pack('<HIQQ', int(rng.integers(0, 3)), 5, START + i, START + i + 1)
        pieces.append(struct.pack('<BQ', 5, 22 + len(data)) + head + data)
        if rng.random() < 0.001:
            pieces.append(struct.pack('<BQ', 12, 4) + bytes(4))
    return b''.join(pieces)


@pytest.mark.parametrize('mixed', [False, True])
@pytest.mark.parametrize('seed', range(4))
def test_many_at_a_time_are_the_same_as_one_by_one(seed, mixed):
    data = random_records(np.random.default_rng(seed), mixed)
    expected = one_by_one(data)
    found = list(items(memoryview(data), 0))
    assert found[-1].end == len(data)
    for channel in range(3):
        keeper = Keeper()
        for item in found:
            if isinstance(item, (Table, Chain)):
                keeper.take(item.of([channel]))
        wanted = []
        for opcode, start, end in expected:
            if opcode == 5:
                number, _, log, publish = struct.unpack_from('<HIQQ', data, start + 9)
                wanted += [(log, publish, data[start + 31 : end])] * (number == channel)
        assert keeper.found == wanted
        counts = [i.counts().get(channel, 0) for i in found if isinstance(i, (Table, Chain))]
        assert sum(counts) == len(wanted)
    places = [start for _, start, _ in expected]
    assert parted(found, len(data), places[::7])
    assert not parted(found, len(data), [places[0], places[5] + 1])


def test_a_record_is_found_again_after_damage(mcap):
    data = mcap(chunk=0).signal(1, '/y', np.arange(50.0)).bytes()
    starts = {start for _, start, _ in one_by_one(data[8:])}
    for place in range(300, 1500, 37):
        broken = memoryview(data[8:place] + bytes(20) + data[place + 20 :])
        found = find_record(broken, place - 8, len(broken))
        assert found in starts
        assert found - (place + 12) < 2 * 43
    assert find_record(memoryview(bytes(1000)), 0, 1000) is None


@pytest.fixture(name='small_window')
def _small_window(monkeypatch):
    """A window of 4 kB instead of 8 MB: what is large then is large now."""
    monkeypatch.setattr(tape, 'ROOM', 4096)
    for module in (mcap_file, mcap_contents):
        monkeypatch.setattr(module, 'ROOM', 4096)
    monkeypatch.setattr(mcap_contents, '_PART', 2048)
    monkeypatch.setattr(mcap_contents, '_HOPELESS', 8192)
    monkeypatch.setattr(mcap_file, 'PIECE', 1000)


@pytest.mark.parametrize('compression', ['', 'zstd', 'lz4'])
@pytest.mark.parametrize('crc', [False, True])
def test_a_chunk_larger_than_the_window(tmp_path, mcap, small_window, compression, crc):
    file = mcap(chunk=2000, compression=compression, crc=crc, data_crc=True)
    file.signal(1, '/y', np.arange(1000.0))
    file.channels[2] = ('/image', 0, 'cdr')
    for place in (100, 500, 900):
        file.messages.insert(place, (2, START, START, np.random.default_rng(1).bytes(9000)))
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert recording.findings == ()
    assert recording.signals['y'].values.tolist() == list(range(1000))
    data = bytearray(file.bytes())
    data[-len(data) // 2] ^= 0xFF
    (tmp_path / 'bag.mcap').write_bytes(data)
    with suppress(BagError):  # what is packed may be one block, and all of it is lost
        assert read_bag(tmp_path / 'bag.mcap').findings != ()


def test_records_larger_than_the_window_outside_of_chunks(tmp_path, mcap, small_window):
    file = mcap(data_crc=True).signal(1, '/y', np.arange(300.0))
    file.channels[2] = ('/image', 0, 'cdr')
    file.messages.insert(150, (2, START, START, bytes(30_000)))
    file.between = struct.pack('<BQ', 9, 10_000) + bytes(10_000)
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert recording.findings == ()
    assert recording.signals['y'].values.tolist() == list(range(300))


def test_small_chunks_are_read_together_and_damage_in_one_stays_in_it(tmp_path, mcap):
    file = mcap(chunk=10).signal(1, '/y', np.arange(2000.0))
    data = bytearray(file.bytes())
    place = data.index(np.float64(1005.0).tobytes())
    data[place + 10 : place + 14] = bytes(4)
    (tmp_path / 'bag.mcap').write_bytes(data)
    found = read_bag(tmp_path / 'bag.mcap').signals['y'].values.tolist()
    assert {*range(1000), *range(1010, 2000)} <= set(found) <= set(range(2000))


def test_hostile_lengths_and_counts_reserve_nothing(tmp_path, mcap):
    file = mcap(chunk=10, counts={1: 2**60}).signal(1, '/y', np.arange(20.0))
    recording = read_bag(file.write(tmp_path / 'bag.mcap'))
    assert recording.signals['y'].values.tolist() == list(range(20))
    data = mcap(chunk=0).signal(1, '/y', np.arange(20.0)).data()
    for opcode in (3, 4, 5, 6, 9, 77):
        (tmp_path / 'bag.mcap').write_bytes(data + struct.pack('<BQ', opcode, 2**63) + bytes(50))
        assert len(read_bag(tmp_path / 'bag.mcap').signals['y'].values) == 20


# The tape ----------------------------------------------------------------------------------------


@pytest.mark.parametrize('length', [0, 1, 7, 1000, 2**20])
def test_checksums_of_two_pieces_join(length):
    rng = np.random.default_rng(length)
    first, second = rng.bytes(77), rng.bytes(length)
    assert joined(crc32(first), crc32(second), length) == crc32(first + second)


def test_a_tape_shows_everything_once_and_knows_its_checksum(tmp_path, small_window):
    data = np.random.default_rng(2).bytes(50_000)
    (tmp_path / 'file').write_bytes(data)
    rng = np.random.default_rng(3)
    with (tmp_path / 'file').open('rb') as file:
        reel, seen = Tape(file, len(data)), b''
        reel.crc = 0
        while reel.left:
            view = reel.view(int(rng.integers(1, 5000)))
            count = min(int(rng.integers(1, 3000)), len(view))
            seen += bytes(view[:count])
            reel.drop(count, crc32(view[:count]) if rng.random() < 0.5 else None)
    assert seen == data
    assert reel.crc == crc32(data)


# What we write -----------------------------------------------------------------------------------


@pytest.fixture(name='ours')
def _ours(tmp_path):
    """A bag of ours: rows, single messages of another type, and a flush in between."""
    writer = BagWriter(tmp_path / 'bag', 'mcap', 'plant: {}', 'made')
    for topic in ('/w', '/y'):
        writer.add(topic, FLOAT64)
    writer.add('/spikes/y/event', 'std_msgs/msg/Header')
    for first in range(0, 30_000, 500):
        stamps = [START + 1000 * i for i in range(first, first + 500)]
        column = [
            b'\x00\x01\x00\x00' + struct.pack('<d', float(i)) for i in range(first, first + 500)
        ]
        writer.write_rows(['/w', '/y'], stamps, [column, column])
        writer.write(
            '/spikes/y/event', stamps[-1], b'\x00\x01\x00\x00' + bytes(8) + b'\x02\x00\x00\x00y\x00'
        )
        if first == 10_000:
            writer.flush()
    writer.close()
    return tmp_path / 'bag'


@pytest.mark.slow
def test_another_reader_reads_ours_by_its_index(ours):
    from rosbags.highlevel import AnyReader

    with AnyReader([ours]) as reader:
        assert reader.message_count == 60_060
        assert {c.topic: c.msgcount for c in reader.connections} == {
            '/w': 30_000, '/y': 30_000, '/spikes/y/event': 60,
        }  # fmt: skip
        chosen = [c for c in reader.connections if c.topic == '/y']
        found = [(t, reader.deserialize(d, c.msgtype).data) for c, t, d in reader.messages(chosen)]
        event = next(reader.messages([c for c in reader.connections if 'event' in c.topic]))
        assert reader.deserialize(event[2], event[0].msgtype).frame_id == 'y'
    assert found == [(START + 1000 * i, float(i)) for i in range(30_000)]
    recording = read_bag(ours)
    assert recording.findings == ()
    assert recording.signals['y'].stamps.tolist() == [t for t, _ in found]
    assert recording.signals['y'].values.tolist() == [v for _, v in found]


def test_ours_bears_every_checksum(ours):
    data = (ours / 'bag.mcap').read_bytes()
    records = one_by_one(data[8:-8])
    data_end = next(start for opcode, start, _ in records if opcode == 15) + 8
    assert int.from_bytes(data[data_end + 9 : data_end + 13], 'little') == crc32(data[:data_end])
    chunks = [(start + 8, end + 8) for opcode, start, end in records if opcode == 6]
    assert len(chunks) > 2
    for start, end in chunks:
        stated = int.from_bytes(data[start + 33 : start + 37], 'little')
        assert stated == crc32(data[start + 49 : end])
    footer = next(start for opcode, start, _ in records if opcode == 2) + 8
    summary, _, stated = struct.unpack_from('<QQI', data, footer + 9)
    assert summary == data_end + 13
    assert stated == crc32(data[summary : footer + 25])
    assert data.startswith(MAGIC)
    assert data.endswith(MAGIC)


@pytest.mark.slow
def test_no_byte_of_ours_can_change_without_a_word(ours):
    data = (ours / 'bag.mcap').read_bytes()
    path = ours.parent / 'alone.mcap'
    for place in np.random.default_rng(5).integers(0, len(data), 40).tolist():
        path.write_bytes(data[:place] + bytes([data[place] ^ 4]) + data[place + 1 :])
        assert read_bag(path).findings != ()


def test_two_bags_of_the_same_are_the_same(tmp_path):
    t = np.arange(40_000)
    signals = {
        'w': ((START + 7 * t).tolist(), np.sin(t)),
        'y': ((START + 14 * t[::2]).tolist(), t[::2] * 1.0),
    }
    for name in ('one', 'other'):
        (tmp_path / name).mkdir()
        write_bag(tmp_path / name / 'bag', signals, 'made', 'plant: {}')
    for file in ('bag.mcap', 'metadata.yaml'):
        one, other = ((tmp_path / name / 'bag' / file).read_bytes() for name in ('one', 'other'))
        assert one == other
    account = read_mcap(tmp_path / 'one' / 'bag' / 'bag.mcap', lambda channel: None)
    assert account.promised['statistics'] == {'/w': 40_000, '/y': 20_000}
    assert account.promised['index'] == account.promised['statistics']


@pytest.mark.parametrize('opcode', [2, 15])
def test_a_false_end_in_the_midst_of_the_data_is_damage(tmp_path, mcap, opcode):
    path = (
        mcap(chunk=10, statistics=False)
        .signal(1, '/y', np.arange(100.0))
        .write(tmp_path / 'it.mcap')
    )
    data = bytearray(path.read_bytes())
    chunks = [start for code, start, _ in one_by_one(data[8:]) if code == 6]
    data[8 + chunks[4]] = opcode
    data[-20:] = bytes(20)  # nor is there a summary that knows better
    path.write_bytes(data)
    recording = read_bag(path)
    _, values = recording.signals['y']
    assert values.tolist() == list(range(100))  # its messages were found all the same
    assert 'damaged' in [finding.code for finding in recording.findings]
