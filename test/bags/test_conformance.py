# SPDX-License-Identifier: Apache-2.0
"""The 154 variants of foxglove's conformance files with ten messages, remade with Float64.

Their names say what a file has: ch chunks, chx a chunk index, mx a message index, pad bytes after
the fields of records, rch and rsh repeated channels and schemas, st statistics, sum the offsets of
the summary.
"""

from itertools import product

import pytest

from eventreg_ros.bags.reader import read_bag

FLAGS = ('ch', 'chx', 'mx', 'pad', 'rch', 'rsh', 'st', 'sum')
VALUES = [float(i) for i in range(10)]


def names():
    """Return the names of all variants: indices need chunks, summary offsets need a summary."""
    found = []
    for present in product((False, True), repeat=len(FLAGS)):
        on = {flag for flag, there in zip(FLAGS, present, strict=True) if there}
        if on & {'chx', 'mx'} and 'ch' not in on:
            continue
        if 'sum' in on and not on & {'chx', 'rch', 'rsh', 'st'}:
            continue
        found.append('-'.join(flag for flag in FLAGS if flag in on))
    return found


def test_there_are_as_many_variants_as_there():
    assert len(names()) == 154


@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_every_variant_is_read_without_a_finding(tmp_path, mcap, compression):
    wrong = []
    for name in names():
        on = set(name.split('-'))
        if compression and 'ch' not in on:
            continue
        file = mcap(
            profile='', chunk=10 if 'ch' in on else 0, compression=compression,
            chunk_index='chx' in on, message_index='mx' in on,
            padding=b'\x01\xff\xff' if 'pad' in on else b'',
            repeated_channels='rch' in on, repeated_schemas='rsh' in on, statistics='st' in on,
            summary_offsets='sum' in on,
        ).signal(1, '/y', VALUES)  # fmt: skip
        recording = read_bag(file.write(tmp_path / 'TenMessages.mcap'))
        if recording.findings or recording.signals['y'].values.tolist() != VALUES:
            wrong.append((name, recording))
    assert wrong == []


def test_a_message_without_a_schema_is_read_and_said_so(tmp_path, mcap):
    file = mcap(schemas={}, chunk=5).signal(1, 'y', VALUES, schema=0)
    recording = read_bag(file.write(tmp_path / 'OneSchemalessMessage.mcap'))
    assert recording.signals['y'].values.tolist() == VALUES
    assert [finding.code for finding in recording.findings] == ['assumed-type']
