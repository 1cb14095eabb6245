# SPDX-License-Identifier: Apache-2.0
"""How fast bags are read, beside the floor: chunks of MCAP decoded as numpy structured arrays.

Run ``PYTHONPATH=. python bench/reading.py [MILLIONS]`` from the top of the repository (5 million
messages by default; 1 GB of disk for the ten hours). Prints a table with the limit beside each
figure. Times are of CPU, the shortest of three; the floor is measured before each row anew.
"""

from __future__ import annotations

import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from eventreg_ros.bags.mcap_records import CHUNK, HEAD
from eventreg_ros.bags.mcap_writer import _FLOAT64 as MESSAGE
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter, write_bag

START = 1_795_304_457_727_915_003
NAMES = ('w', 'y', 'u')
STEP = 5_000_000
TEN_HOURS = 7_200_000


@dataclass
class Row:
    """One line of the table: seconds of CPU, and what it may take."""

    what: str
    seconds: float
    limit: str
    floor: float | None = None
    memory: str = ''

    def line(self) -> str:
        """Return the row."""
        ratio = f'{self.seconds / self.floor:.2f}' if self.floor else ''
        return f'| {self.what} | {self.seconds:.3f} | {ratio} | {self.limit} | {self.memory} |'


def signals(rows: int) -> dict[str, tuple[Any, np.ndarray]]:
    """Return three signals at 200 Hz."""
    stamps = START + STEP * np.arange(rows)
    return {n: (stamps, 2 * np.sin(5e-3 * np.arange(rows) + k) ** 3) for k, n in enumerate(NAMES)}


def best(run: Callable[[], object], repeat: int = 3) -> float:
    """Return the shortest CPU time of ``repeat`` runs."""
    times = []
    for _ in range(repeat):
        start = time.process_time()
        run()
        times.append(time.process_time() - start)
    return min(times)


def floor(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Decode the chunks of an MCAP file of Float64 alone; nothing is checked."""
    found, first = [], True
    with path.open('rb') as file:
        file.seek(8)
        while len(head := file.read(HEAD.size)) == HEAD.size:
            opcode, length = HEAD.unpack(head)
            body = file.read(length)
            if opcode != CHUNK:
                continue
            at = 40 + int.from_bytes(body[28:32], 'little')
            while first and body[at] != 5:  # schema and channels
                at += HEAD.size + int.from_bytes(body[at + 1 : at + 9], 'little')
            first = False
            table = np.frombuffer(body, MESSAGE, offset=at)
            for channel in range(1, len(NAMES) + 1):
                which = table['channel'] == channel
                found.append((table['log'][which], table['value'][which]))
    return found


def by_sql(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Read a database by one query per topic."""
    found = {}
    connection = sqlite3.connect(path)
    for number, name in enumerate(NAMES, 1):
        query = 'SELECT timestamp, data FROM messages WHERE topic_id = ?'
        rows = connection.execute(query, (number,)).fetchall()
        stamps = np.fromiter((stamp for stamp, _ in rows), np.int64, len(rows))
        data = np.frombuffer(b''.join(data for _, data in rows), np.uint8).reshape(-1, 12)
        found[name] = (stamps, data[:, 4:].copy().view('<f8')[:, 0])
    connection.close()
    return found


def flushed(path: Path, rows: int) -> None:
    """Write a bag as the recorder does at 200 Hz: a chunk every second."""
    writer = BagWriter(path, 'mcap', None, None)
    for name in NAMES:
        writer.add(f'/{name}', 'std_msgs/msg/Float64')
    found = signals(rows)
    values = np.stack([v for _, v in found.values()], 1)
    for at in range(0, rows, 200):
        stamps = np.repeat(found['w'][0][at : at + 200], len(NAMES))
        which = np.tile(np.arange(len(NAMES)), len(stamps) // len(NAMES))
        writer.write_float64([f'/{n}' for n in NAMES], which, stamps, values[at : at + 200].ravel())
        writer.flush()
    writer.close()


def packed(source: Path, target: Path) -> None:
    """Pack a file as rosbag2 does when it compresses files."""
    from backports import zstd

    target.write_bytes(zstd.compress(source.read_bytes()))


CHILD = """
import re, sys, time
from eventreg_ros.bags.reader import read_bag
recording = read_bag(sys.argv[1])
peak = re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read()).group(1)
print(time.process_time(), int(peak) / 1024,
      sum(len(s.stamps) for s in recording.signals.values()))
"""


def alone(path: Path) -> tuple[float, float, int]:
    """Read a bag in a process of its own: CPU time with its start, MiB, messages."""
    command = [sys.executable, '-c', CHILD, str(path)]
    found = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return float(found[0]), float(found[1]), int(found[2])


def of_mcap(scratch: Path, millions: float) -> list[Row]:
    """Return the rows of MCAP files."""
    rows = round(millions * 1e6 / len(NAMES))
    write_bag(scratch / 'bag', signals(rows), 'exact', 'plant: {}')
    flushed(scratch / 'flushed', rows)
    plain, small = scratch / 'bag' / 'bag.mcap', scratch / 'flushed' / 'flushed.mcap'
    without = scratch / 'none.mcap'
    without.write_bytes(without_checksums(plain.read_bytes()))
    found = []
    for what, path, limit in (
        ('no checksums', without, '<= 2 x the floor'),
        ('ours, with checksums', plain, '<= 2 x the floor'),
        ('as the recorder flushes, with checksums', small, '<= 2 x the floor'),
    ):
        lowest = best(lambda path=path: floor(path))
        seconds = best(lambda path=path: read_bag(path))
        found.append(Row(f'mcap, {millions:g} million, {what}', seconds, limit, lowest))
    packed(plain, scratch / 'file.mcap.zstd')
    seconds = best(lambda: read_bag(scratch / 'file.mcap.zstd'), 1)
    found.append(Row(f'mcap, {millions:g} million, packed as a file', seconds, ''))
    return found


def without_checksums(data: bytes) -> bytes:
    """Return an MCAP file whose chunks state no checksum."""
    found, at = bytearray(data), 8
    while at + HEAD.size <= len(found) - 8:
        opcode, length = HEAD.unpack_from(found, at)
        if opcode == CHUNK:
            found[at + 33 : at + 37] = bytes(4)
        if opcode == 15:
            found[at + 9 : at + 13] = bytes(4)
        at += HEAD.size + length
    return bytes(found)


def of_sqlite(scratch: Path) -> list[Row]:
    """Return the rows of a database of a million messages."""
    write_bag(scratch / 'base', signals(333_333), 'exact', 'plant: {}', 'sqlite3')
    path = scratch / 'base' / 'base.db3'
    lowest = best(lambda: by_sql(path))
    seconds = best(lambda: read_bag(path))
    return [
        Row('sqlite3, 1 million, one SQL query per topic', lowest, '', lowest),
        Row('sqlite3, 1 million', seconds, '<= one query per topic', lowest),
    ]


def of_ten_hours(scratch: Path) -> list[Row]:
    """Return the row of ten hours at 200 Hz, in a process of its own."""
    write_bag(scratch / 'long', signals(TEN_HOURS), 'exact', 'plant: {}')
    lowest = best(lambda: floor(scratch / 'long' / 'long.mcap'), 1)
    seconds, memory, count = alone(scratch / 'long')
    what = f'mcap, ten hours ({count / 1e6:.1f} million), start of Python included'
    return [Row(what, seconds, 'analyze: 6 s, 1.2 GB', lowest, f'{memory:.0f} MiB')]


def main() -> None:
    """Print the table."""
    millions = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        print('| what | s of CPU | ratio | limit | memory |\n|---|---:|---:|---|---:|')
        for rows in (of_mcap(scratch, millions), of_sqlite(scratch), of_ten_hours(scratch)):
            for row in rows:
                print(row.line(), flush=True)


if __name__ == '__main__':
    main()
