# SPDX-License-Identifier: Apache-2.0
"""A small writer of MCAP files and of databases that can do what no proper writer does."""

import sqlite3
import struct
from dataclasses import dataclass, field
from zlib import crc32

import numpy as np
import pytest

MAGIC = b'\x89MCAP0\r\n'
START = 1_795_304_457_727_915_003
STEP = 50_000_000
FLOAT64 = ('std_msgs/msg/Float64', 'ros2msg', 'float64 data\n')


def float64(value):
    return b'\x00\x01\x00\x00' + struct.pack('<d', value)


def text(data):
    data = data.encode() if isinstance(data, str) else data
    return struct.pack('<I', len(data)) + data


@dataclass
class Mcap:
    """Messages, and everything that a file may or may not have around them."""

    messages: list = field(default_factory=list)
    """(channel, log time, publish time, data)"""
    channels: dict = field(default_factory=dict)
    """channel: (topic, schema id, encoding)"""
    schemas: dict = field(default_factory=lambda: {1: FLOAT64})
    profile: str = 'ros2'
    chunk: int = 0
    """Messages a chunk; 0: no chunks."""
    compression: str = ''
    crc: bool = False
    data_crc: bool = False
    message_index: bool = True
    chunk_index: bool = True
    repeated_schemas: bool = True
    repeated_channels: bool = True
    statistics: bool = True
    summary_offsets: bool = False
    padding: bytes = b''
    between: bytes = b''
    """Written between chunks, or after each message where there are none."""
    counts: dict | None = None
    """What the statistics say, if not the truth."""
    end: bool = True

    def signal(self, number, topic, values, stamps=None, publish=None, schema=1):
        """Add a channel of Float64 with its messages."""
        self.channels[number] = (topic, schema, 'cdr')
        stamps = START + STEP * np.arange(len(values)) if stamps is None else stamps
        publish = stamps if publish is None else publish
        pairs = zip(stamps, publish, values, strict=True)
        self.messages += [(number, int(s), int(p), float64(v)) for s, p, v in pairs]
        return self

    def ordered(self):
        """Put the messages in the order of their log times."""
        self.messages.sort(key=lambda message: message[1])
        return self

    def record(self, opcode, *body, pad=True):
        data = b''.join(body) + (self.padding if pad else b'')
        return struct.pack('<BQ', opcode, len(data)) + data

    def declarations(self):
        return self.declared_schemas() + self.declared_channels()

    def declared_schemas(self):
        found = (
            self.record(3, struct.pack('<H', number), *map(text, parts))
            for number, parts in self.schemas.items()
        )
        return b''.join(found)

    def declared_channels(self):
        found = (
            self.record(4, struct.pack('<HH', n, schema), text(topic), text(encoding), text(b''))
            for n, (topic, schema, encoding) in self.channels.items()
        )
        return b''.join(found)

    def message(self, message):
        number, log, publish, data = message
        head = struct.pack('<HIQQ', number, 0, log % 2**64, publish % 2**64)
        return self.record(5, head, data, pad=False)

    def chunks(self):
        """Yield chunks with their indices, and what the summary says of them."""
        for first in range(0, max(len(self.messages), 1), self.chunk):
            part = self.messages[first : first + self.chunk]
            data = (b'' if first else self.declarations()) + b''.join(map(self.message, part))
            stamps = [m[1] % 2**64 for m in part] or [0]
            head = struct.pack(
                '<QQQI', min(stamps), max(stamps), len(data), crc32(data) if self.crc else 0
            )
            packed = pack(data, self.compression)
            body = (text(self.compression), struct.pack('<Q', len(packed)), packed)
            yield self.record(6, head, *body), self.indices(part)

    def indices(self, part):
        if not self.message_index:
            return b''
        numbers = [m[0] for m in part]
        return b''.join(
            self.record(7, struct.pack('<H', n), text(bytes(16 * numbers.count(n))))
            for n in dict.fromkeys(numbers)
        )

    def data(self):
        head = MAGIC + self.record(1, text(self.profile), text('test'))
        if self.chunk:
            body = b''.join(c + i + self.between for c, i in self.chunks())
        else:
            messages = (self.message(m) + self.between for m in self.messages)
            body = self.declarations() + b''.join(messages)
        return head + body

    def summary(self, at):
        counts = {n: sum(m[0] == n for m in self.messages) for n in self.channels}
        counts = counts if self.counts is None else self.counts
        table = b''.join(struct.pack('<HQ', *pair) for pair in counts.items())
        numbers = struct.pack('<QHIIIIQQ', sum(counts.values()), 1, 1, 0, 0, 1, 0, 0)
        groups = [
            (3, self.declared_schemas() if self.repeated_schemas else b''),
            (4, self.declared_channels() if self.repeated_channels else b''),
            (11, self.record(11, numbers, text(table)) if self.statistics else b''),
            (8, self.record(8, bytes(32), text(b''), bytes(8), text(''), bytes(16))
             if self.chunk and self.chunk_index else b''),
        ]  # fmt: skip
        offsets = b''
        for opcode, group in groups if self.summary_offsets else ():
            offsets += self.record(14, struct.pack('<BQQ', opcode, at, len(group)))
        return b''.join(group for _, group in groups), offsets

    def bytes(self):
        """Return the file."""
        data = self.data()
        if not self.end:
            return data
        crc = struct.pack('<I', crc32(data) if self.data_crc else 0)
        data += self.record(15, crc)
        summary, offsets = self.summary(len(data))
        start = len(data) if summary + offsets else 0
        footer = struct.pack('<QQI', start, start + len(summary) if offsets else 0, 0)
        return data + summary + offsets + self.record(2, footer, pad=False) + MAGIC

    def write(self, path):
        """Write the file and return its path."""
        path.write_bytes(self.bytes())
        return path


def pack(data, compression):
    if compression == 'zstd':
        return zstd(data)
    if compression == 'lz4':
        import lz4.frame

        return lz4.frame.compress(data)
    return data


def zstd(data):
    """Pack bytes as rosbag2 packs a file or a message."""
    try:
        from compression.zstd import compress
    except ImportError:
        from backports.zstd import compress
    return compress(data)


@pytest.fixture(name='mcap')
def _mcap():
    return Mcap


@pytest.fixture(name='zstd')
def _zstd():
    return zstd


@pytest.fixture(name='float64')
def _float64():
    return float64


SCHEMAS = {
    1: 'serialization_format TEXT NOT NULL',
    2: 'serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL',
    3: 'serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL',
    4: 'serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, '
    'type_description_hash TEXT NOT NULL',
}
"""The columns of the table of topics after id, name and type, by the version of the schema."""


@pytest.fixture(name='database')
def _database():
    """Write a database: rows (topic, stamp, data), in a version of rosbag2's schema."""

    def make(path, rows, *, schema=4, page_size=4096, types=None, index=True, extra=()):
        topics = list(dict.fromkeys(topic for topic, _, _ in rows))
        connection = sqlite3.connect(path)
        connection.execute(f'PRAGMA page_size={page_size}')
        columns = SCHEMAS[schema]
        connection.execute(
            'CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, '
            f'type TEXT NOT NULL, {columns})'
        )
        connection.execute(
            'CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, '
            'timestamp INTEGER NOT NULL, data BLOB NOT NULL)'
        )
        if schema >= 3:
            connection.execute(
                'CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT)'
            )
            connection.execute('INSERT INTO schema VALUES (?, ?)', (schema, 'jazzy'))
        if index:
            connection.execute('CREATE INDEX timestamp_idx ON messages (timestamp ASC)')
        filler = [''] * (columns.count(' TEXT') - 1)
        for i, topic in enumerate(topics):
            kind = (types or {}).get(topic, 'std_msgs/msg/Float64')
            row = (i + 1, topic, kind, 'cdr', *filler)
            connection.execute(f'INSERT INTO topics VALUES ({",".join("?" * len(row))})', row)
        numbers = {topic: i + 1 for i, topic in enumerate(topics)}
        connection.executemany(
            'INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)',
            [(numbers[topic], stamp, data) for topic, stamp, data in rows],
        )
        for statement in extra:
            connection.execute(statement)
        connection.commit()
        connection.close()
        return path

    return make
