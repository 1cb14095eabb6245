# SPDX-License-Identifier: Apache-2.0
"""What damaged bags do to the reader: bits flipped, bytes zeroed, files cut, over three storages.

Run ``PYTHONPATH=. python bench/damaged.py [COUNT [SEED]]`` from the top of the repository. Prints a
table: of the damaged bags of each storage, how many were read as before, differ and say so, are
refused in one line, and differ without a word; and the memory and the time that the worst took.
"""

from __future__ import annotations

import resource
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.recording import Recording
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.errors import BagError

STORAGES = ('mcap, checksums', 'mcap, none', 'sqlite3')
ROWS = 2000
START = 1_795_304_457_727_915_003
RESULTS = ('the same', 'a finding', 'refused', 'SILENT', 'CRASH')


def signals() -> dict[str, tuple[list[int], np.ndarray]]:
    """Return three signals on the grid of a run in lockstep."""
    stamps = [START + 5_000_000 * i for i in range(ROWS)]
    t = np.arange(ROWS) * 0.05
    return {name: (stamps, 2 * np.sin(t / 3 + k) ** 3) for k, name in enumerate(('w', 'y', 'u'))}


def make(directory: Path, storage: str) -> Path:
    """Write the bag that is damaged later; return its data file."""
    path = directory / storage.replace(', ', '_')
    if storage == 'mcap, none':
        write_without_checksums(path)
    else:
        write_bag(path, signals(), 'exact', 'plant: {ros__parameters: {}}', storage.split(',')[0])
    return next(f for f in path.iterdir() if f.suffix in ('.mcap', '.db3'))


def write_without_checksums(path: Path) -> None:
    """Write the bag as rosbags does, in chunks of 4 s, without any checksum."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    from eventreg_ros.runtime.cdr import packed

    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        store = get_typestore(Stores.ROS2_JAZZY)
        found = signals()
        connections = {n: writer.add_connection(f'/{n}', FLOAT64, typestore=store) for n in found}
        for i in range(ROWS):
            for name, (stamps, values) in found.items():
                writer.write(connections[name], stamps[i], packed(float(values[i])))
            if i % 800 == 799:
                writer.storage.close_chunk()  # type: ignore[union-attr]


def damage(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a file's bytes, damaged in one of the ways in which files are."""
    at = int(rng.integers(0, len(data)))
    size = int(rng.choice([1, 4, 16, 64, 512, 4096]))
    kind = rng.choice(['bit', 'byte', 'zeros', 'noise', 'cut', 'removed', 'twice'])
    before, hit, after = data[:at], data[at : at + size], data[at + size :]
    match kind:
        case 'bit':
            return before + bytes([data[at] ^ 1 << int(rng.integers(0, 8))]) + data[at + 1 :]
        case 'byte':
            return before + bytes([data[at] ^ 0xFF]) + data[at + 1 :]
        case 'zeros':
            return before + bytes(len(hit)) + after
        case 'noise':
            return before + rng.bytes(len(hit)) + after
        case 'cut':
            return before
        case 'removed':
            return before + after
        case _:
            return before + hit + hit + after


def same(one: Recording, other: Recording) -> bool:
    """Whether two recordings hold the same samples to the last bit."""
    if one.signals.keys() != other.signals.keys() or one.scenario != other.scenario:
        return False
    return all(
        np.array_equal(a.stamps, b.stamps)
        and np.array_equal(a.values.view(np.uint64), b.values.view(np.uint64))
        for a, b in zip(one.signals.values(), other.signals.values(), strict=True)
    )


def judge(path: Path, sound: Recording) -> str:
    """Return how the reader took a bag that is damaged."""
    try:
        found = read_bag(path)
    except BagError as error:
        return 'refused' if '\n' not in str(error) else 'CRASH'
    except Exception as error:
        print(f'{path}: {error!r}')
        return 'CRASH'
    if found.findings:
        return 'a finding'
    return 'the same' if same(found, sound) else 'SILENT'


def main() -> None:
    """Damage bags and print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    rng = np.random.default_rng(int(sys.argv[2]) if len(sys.argv) > 2 else 8)
    with tempfile.TemporaryDirectory() as scratch:
        files = {storage: make(Path(scratch), storage) for storage in STORAGES}
        sound = {storage: read_bag(file.parent) for storage, file in files.items()}
        results: dict[str, Counter[str]] = {storage: Counter() for storage in STORAGES}
        slowest = 0.0
        for i in range(count):
            storage = STORAGES[i % len(STORAGES)]
            bag = Path(scratch) / 'damaged'
            shutil.copytree(files[storage].parent, bag)
            if i % 2:
                (bag / 'metadata.yaml').unlink()
            (bag / files[storage].name).write_bytes(damage(files[storage].read_bytes(), rng))
            start = time.process_time()
            result = judge(bag, sound[storage])
            slowest = max(slowest, time.process_time() - start)
            results[storage][result] += 1
            shutil.rmtree(bag)
    print(f'| {count} damaged bags | {" | ".join(RESULTS)} |')
    print('|---|' + '---:|' * len(RESULTS))
    for storage, found in results.items():
        print(f'| {storage} | {" | ".join(str(found[r]) for r in RESULTS)} |')
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f'\nslowest {slowest:.2f} s of CPU; {memory:.0f} MiB at most (limit 200)')


if __name__ == '__main__':
    main()
