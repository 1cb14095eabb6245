# SPDX-License-Identifier: Apache-2.0
"""What a writer notices of its own files, and what it needs however long it writes."""

import gc
import shutil
import tracemalloc

import pytest

from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.errors import BagError

DATA = b'\x00\x01\x00\x00' + bytes(8)

both = pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])


def opened(path, storage):
    writer = BagWriter(path, storage, None, None)
    writer.add('/w', FLOAT64)
    write(writer, 0)
    writer.flush()
    return writer


def write(writer, second):
    for i in range(100):
        writer.write('/w', second * 10**9 + i, DATA)


def cut(bag):
    for file in bag.iterdir():
        with file.open('r+b') as opened_again:
            opened_again.truncate(100)


def replace(bag):
    shutil.copytree(bag, bag.with_name('copy'))
    shutil.rmtree(bag)
    bag.with_name('copy').rename(bag)


@both
@pytest.mark.parametrize(
    ('harm', 'words'),
    [
        (shutil.rmtree, 'deleted or moved'),
        (lambda bag: next(bag.iterdir()).unlink(), 'deleted or moved'),
        (lambda bag: bag.rename(bag.with_name('elsewhere')), 'deleted or moved'),
        (replace, 'deleted or moved'),
        (cut, 'to 100 bytes'),
    ],
    ids=['delete', 'delete file', 'move', 'replace', 'cut'],
)
@pytest.mark.parametrize('then', ['flush', 'close'])
def test_a_writer_notices_what_happens_to_its_bag(tmp_path, storage, harm, words, then):
    writer = opened(tmp_path / 'bag', storage)
    write(writer, 1)
    harm(tmp_path / 'bag')
    with pytest.raises(BagError, match=words):
        getattr(writer, then)()
    if then == 'flush':
        with pytest.raises(BagError, match=words):
            writer.close()
    assert not (tmp_path / 'bag' / 'metadata.yaml').exists()


def test_a_cut_is_noticed_although_much_was_written_since(tmp_path):
    """A writer goes on where it was: the file is soon as long as before, with a hole."""
    writer = opened(tmp_path / 'bag', 'mcap')
    cut(tmp_path / 'bag')
    rows = [DATA] * 30_000  # more than a chunk
    with pytest.raises(BagError, match='to 100 bytes'):
        writer.write_rows(['/w'], range(30_000), [rows])


@pytest.mark.slow
def test_the_memory_of_a_writer_does_not_grow_with_what_it_has_written(tmp_path):
    writer = opened(tmp_path / 'bag', 'mcap')
    tracemalloc.start()
    try:
        sizes = []
        for second in range(1, 2001):
            write(writer, second)
            writer.flush()
            if second % 1000 == 0:
                gc.collect()
                sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    writer.close()
    assert sizes[1] - sizes[0] < 2_000  # two bytes a second would be 173 kB a day
    recording = read_bag(tmp_path / 'bag')
    assert len(recording.signals['w'].stamps) == 200_100
    assert recording.findings == ()
