# SPDX-License-Identifier: Apache-2.0
"""Bags that were damaged, by their bytes or in what they hold: judged, or refused in one line.

Every bag holds one unwanted event. Whatever is done to it, it is never called rejected, unless its
end is missing, with the event, and what is there is judged with a word on that; or unless an
independent reader finds all samples in order and no event in them: then the damage left no trace,
which only storages without checksums allow.
"""

import importlib.util
import json
import shutil
import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest

from eventreg_ros.analysis.events import detect
from eventreg_ros.analysis.verdict import EXIT_CODES
from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.writer import BagWriter, write_bag
from eventreg_ros.runtime.cdr import packed

pytestmark = pytest.mark.slow

DAMAGED = Path(__file__).resolve().parents[2] / 'bench' / 'damaged.py'

SCENARIO = """\
exosystem: {ros__parameters: {}}
plant: {ros__parameters: {time_scale: 10.0, rate: 50.0}}
controller: {ros__parameters: {}}
"""
START = 1_795_304_457_727_915_003
W = (20.0, *range(105, 150, 15), *range(185, 255, 15))
UNWANTED, END = 165.0, 260.0
BLIND = 5.0
REJECTED = EXIT_CODES['rejected']


def sound(pulses):
    """Stamps and values of w, y and u, 50 a second, with one event of y after settling."""
    t = np.arange(round(END / 0.2) + 1) * 0.2
    stamps = START + np.rint(t * 1e8).astype(np.int64)
    events = {'w': W, 'y': (20.0, UNWANTED), 'u': W}
    return {name: (stamps, pulses(times, t)) for name, times in events.items()}


def write_in_chunks(path, signals):
    """Write with checksums, 200 rows a chunk."""
    writer = BagWriter(path, 'mcap', SCENARIO, 'made')
    topics = [f'/{name}' for name in signals]
    for topic in topics:
        writer.add(topic, FLOAT64)
    stamps = next(iter(signals.values()))[0]
    for first in range(0, len(stamps), 200):
        rows = slice(first, first + 200)
        columns = [[packed(x) for x in values[rows].tolist()] for _, values in signals.values()]
        writer.write_rows(topics, stamps[rows].tolist(), columns)
        writer.flush()
    writer.close()


def write_as_others_do(path, signals, mode=None):
    """Write with rosbags alone: no checksums; a compressed file, messages, or chunks."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
    if mode:
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        writer.set_custom_data('scenario', SCENARIO)
        topics = {n: writer.add_connection(f'/{n}', FLOAT64, typestore=store) for n in signals}
        for i, stamp in enumerate(next(iter(signals.values()))[0].tolist()):
            for name, (_, values) in signals.items():
                writer.write(topics[name], stamp, packed(float(values[i])))
            if i % 200 == 199 and mode != 'FILE' and hasattr(writer.storage, 'close_chunk'):
                writer.storage.close_chunk()


WRITERS = {
    'checked': write_in_chunks,
    'sqlite3': lambda path, s: write_bag(path, s, 'made', SCENARIO, 'sqlite3'),
    'plain': write_as_others_do,
    'file': lambda path, s: write_as_others_do(path, s, 'FILE'),
    'messages': lambda path, s: write_as_others_do(path, s, 'MESSAGE'),
    'chunks': lambda path, s: write_as_others_do(path, s, 'STORAGE'),
}


@pytest.fixture(scope='module')
def damage():
    """Damage a file's bytes as the benchmark does."""
    spec = importlib.util.spec_from_file_location('damaged', DAMAGED)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.damage


@pytest.fixture
def bags(tmp_path, pulses):
    """A bag of each kind."""
    found = {}
    for name, write in WRITERS.items():
        found[name] = tmp_path / name
        write(found[name], sound(pulses))
    return found


def data_file(bag):
    return next(f for f in bag.iterdir() if f.suffix in ('.mcap', '.db3', '.zstd'))


def swapped(data, draw):
    """Two stretches of one length, each in the other's place."""
    size = min(draw.choice([16, 512, 4096]), len(data) // 2)
    a, b = sorted(draw.sample(range(0, len(data), size or 1), 2)) if size else (0, 0)
    one, other = data[a : a + size], data[b : b + size]
    return data[:a] + other + data[a + size : b] + one + data[b + size :]


def inserted(data, draw):
    at = draw.randrange(len(data))
    return data[:at] + draw.randbytes(draw.choice([1, 9, 512])) + data[at:]


def aimed(kind, data, draw):
    """Damage what is written about where the event is, which leaves enough events of w."""
    a, b = int(0.58 * len(data)), int(0.7 * len(data))
    return data[:a] + kind(data[a:b], draw) + data[b:]


def swapped_chunks(data, draw):
    """Two chunks of an MCAP file, each in the other's place; other files stay."""
    found = [(start, end) for code, start, end in records(data) if code == 6]
    if len(found) < 2:
        return data
    (a, b), (c, d) = sorted(draw.sample(found, 2))
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def records(data):
    at = 8
    while data[:5] == b'\x89MCAP' and at + 9 < len(data):
        code, length = struct.unpack_from('<BQ', data, at)
        yield code, at, at + 9 + length
        at += 9 + length


def test_damaged_bytes(bags, damage, fuzz, answered, mangled, tmp_path):
    kinds = [lambda data, draw: damage(data, np.random.default_rng(draw.getrandbits(32)))] * 4
    kinds += [swapped, inserted, swapped_chunks]

    def case(draw):
        kind, bag = draw.choice(list(bags)), tmp_path / 'it'
        shutil.rmtree(bag, ignore_errors=True)
        shutil.copytree(bags[kind], bag)
        file = data_file(bag)
        for _ in range(draw.choice([1, 1, 1, 2, 3])):
            data, hurt = file.read_bytes(), draw.choice(kinds)
            if len(data) > 1000:
                aim = draw.random() < 0.6
                file.write_bytes(aimed(hurt, data, draw) if aim else hurt(data, draw))
        other = draw.random()
        if other < 0.4:
            (bag / 'metadata.yaml').unlink()
        elif other < 0.55:
            text = (bag / 'metadata.yaml').read_text()
            (bag / 'metadata.yaml').write_bytes(mangled(text, draw).encode('utf-8', 'replace'))
        elif other < 0.7:  # of another recording
            shutil.copy(bags[draw.choice(list(bags))] / 'metadata.yaml', bag)
        path = str(draw.choice([bag, bag, file]))
        if draw.random() < 0.1:
            return 'compared', answered(['compare', path, str(bags['checked'])])[0]
        out = tmp_path / 'out.json'
        code, lines = answered(['analyze', path, '--json', str(out)])
        if code == REJECTED and not ends_before_the_event(out):
            assert kind != 'checked', lines
            assert left_no_trace(bag), (kind, lines)
        return kind, code

    fuzz(100, case)


def ends_before_the_event(out):
    """Say whether only what comes before the event was judged, with a word on the missing end."""
    evidence = json.loads(out.read_text())['evidence']
    codes = {warning['code'] for warning in evidence['warnings']}
    return evidence['span'][1] < UNWANTED and 'no-end' in codes


def left_no_trace(bag):
    """Say whether an independent reader finds all samples of y, in order, and no event."""
    try:
        found = read_sqlite(bag) if data_file(bag).suffix == '.db3' else read_rosbags(bag)
    except Exception:
        return False
    stamps, values = (np.array(column) for column in zip(*found, strict=True))
    t = (stamps - START) * 1e-8
    whole = len(t) == round(END / 0.2) + 1 and np.all(np.diff(t) > 0.0)
    return whole and not [at for at in detect(t, values) if at > 100.0]


def read_sqlite(bag):
    connection = sqlite3.connect(data_file(bag))
    rows = connection.execute(
        "SELECT timestamp, data FROM messages JOIN topics ON topic_id = topics.id WHERE name = '/y'"
    ).fetchall()
    return [(stamp, struct.unpack('<4xd', data)[0]) for stamp, data in rows]


def read_rosbags(bag):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        topics = [c for c in reader.connections if c.topic == '/y']
        return [
            (stamp, struct.unpack('<4xd', bytes(data))[0])
            for _, stamp, data in reader.messages(topics)
        ]


# What a bag holds -------------------------------------------------------------------------------


def lost(stamps, values, draw):
    """Samples missing around the event, for longer than a signal may be unseen."""
    start = UNWANTED - draw.uniform(0.5, 20.0)
    t = (stamps - START) * 1e-8
    keep = (t < start) | (t > max(start + BLIND + 1.0, UNWANTED + draw.uniform(2.0, 90.0)))
    return stamps[keep], values[keep]


def not_numbers(stamps, values, draw):
    kept, _ = lost(stamps, values, draw)
    bad = draw.choice([np.nan, np.inf, -np.inf])
    return stamps, np.where(np.isin(stamps, kept), values, bad)


def twice(stamps, values, draw):
    """Some samples, or all, a second time: with the same stamps, or later ones."""
    some = np.sort(draw.sample(range(len(stamps)), draw.choice([1, 10, len(stamps)])))
    later = draw.choice([0, 1, 10_000_000])
    return np.append(stamps, stamps[some] + later), np.append(values, values[some])


def two_writers(stamps, values, draw):
    return np.append(stamps, stamps + 7_000_000), np.append(values, np.full(len(values), -1.0))


def set_back(stamps, values, draw):
    """A clock that was set, forth or back."""
    at, by = draw.randrange(1, len(stamps)), draw.choice([10**7, 10**10, START // 2])
    return np.append(stamps[:at], stamps[at:] + draw.choice([-by, by])), values


def huge(stamps, values, draw):
    values = values.copy()
    places = draw.sample(range(len(values)), draw.choice([1, 5]))
    values[places] = draw.choice([1e308, -1e30, 5e-324])
    return stamps, values


def as_it_is(stamps, values, draw):
    return stamps, values


CHANGES = (lost, not_numbers, twice, two_writers, set_back, huge, as_it_is)


def test_odd_contents(fuzz, answered, pulses, tmp_path):
    good = sound(pulses)

    def case(draw):
        shutil.rmtree(bag := tmp_path / 'it', ignore_errors=True)
        changes = {n: draw.choice(CHANGES if n == 'y' else [as_it_is, *CHANGES]) for n in good}
        signals = {n: changes[n](*pair, draw) for n, pair in good.items()}
        write_bag(bag, signals, 'made', SCENARIO, draw.choice(['mcap', 'sqlite3']))
        out = tmp_path / 'out.json'
        code, lines = answered(['analyze', str(bag), '--json', str(out)])
        assert code != REJECTED, (changes, lines)
        # A signal that was set back moves t = 0, so that what came before settling counts.
        if changes['y'] in (lost, not_numbers) and set_back not in changes.values() and code != 2:
            assert code == EXIT_CODES['undecided'], (changes, lines)
            assert json.loads(out.read_text())['evidence']['seen']['y'] < 1.0
        return changes['y'].__name__, code

    fuzz(60, case)
