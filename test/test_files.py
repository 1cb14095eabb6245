# SPDX-License-Identifier: Apache-2.0
"""Files: what is no file is refused without waiting, and what is written is whole or not there."""

import os
import socket

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.files import UnreadableError, need_writable, read_text, writing


@pytest.fixture
def places(tmp_path):
    """One of everything that a name may stand for and that is no readable text."""
    os.mkfifo(tmp_path / 'fifo')
    server = socket.socket(socket.AF_UNIX)
    server.bind(str(tmp_path / 'socket'))
    (tmp_path / 'bytes').write_bytes(b'k: \xff')
    (tmp_path / 'big').write_bytes(b'x' * 11)
    (tmp_path / 'loop').symlink_to(tmp_path / 'loop')
    yield tmp_path
    server.close()


@pytest.mark.parametrize(
    ('name', 'reason'),
    [
        ('', 'it is a directory; give a regular file'),
        ('fifo', 'it is a pipe; give a regular file'),
        ('socket', 'it is a socket; give a regular file'),
        ('/dev/zero', 'it is a device; give a regular file'),
        ('bytes', 'it is not UTF-8 text (invalid start byte at 3)'),
        ('big', 'it has more than 10 bytes; give a smaller file'),
        ('none', 'no such file or directory'),
        ('big/none', 'not a directory'),
        ('loop', 'too many levels of symbolic links'),
        ('x' * 5000, 'file name too long'),
        ('nu\0ll', 'embedded null byte'),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_true_reason(places, name, reason):
    with pytest.raises(UnreadableError) as caught:
        read_text(os.path.join(places, name), 10)
    assert str(caught.value) == reason


def test_text_is_read_without_its_byte_order_mark(tmp_path):
    (tmp_path / 'text').write_bytes(b'\xef\xbb\xbfk: \xc3\xa9')
    assert read_text(tmp_path / 'text') == 'k: é'


def test_a_file_is_replaced_whole_and_keeps_its_mode(tmp_path):
    path = tmp_path / 'x.json'
    path.write_text('old')
    path.chmod(0o640)
    with writing(path) as beside:
        assert beside.suffix == '.json'
        beside.write_text('new')
        assert path.read_text() == 'old'
    assert (path.read_text(), path.stat().st_mode & 0o777) == ('new', 0o640)
    assert list(tmp_path.iterdir()) == [path]


def stop_within(path, error):
    with writing(path) as beside:
        beside.write_text('ne')
        raise error


@pytest.mark.parametrize('error', [KeyboardInterrupt, ValueError, OSError(28, 'No space left')])
def test_what_fails_on_the_way_leaves_the_old_file_alone(tmp_path, error):
    path = tmp_path / 'x.json'
    path.write_text('old')
    expected = EventregError if isinstance(error, OSError) else error
    with pytest.raises(expected):
        stop_within(path, error)
    assert path.read_text() == 'old'
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link_and_a_device_a_device(tmp_path):
    (tmp_path / 'link').symlink_to(tmp_path / 'file')
    with writing(tmp_path / 'link') as beside:
        beside.write_text('text')
    assert (tmp_path / 'link').is_symlink()
    assert (tmp_path / 'file').read_text() == 'text'
    os.mkfifo(tmp_path / 'fifo')
    with writing(tmp_path / 'fifo') as beside:
        assert beside == tmp_path / 'fifo'


@pytest.mark.parametrize('name', ['', 'none/x', 'file/x', 'x' * 5000, 'nu\0ll'])
def test_what_cannot_be_written_is_known_before_the_work(tmp_path, name):
    (tmp_path / 'file').touch()
    with pytest.raises(EventregError, match='cannot write'):
        need_writable(tmp_path / name)


def test_what_can_be_written_passes(tmp_path):
    (tmp_path / 'file').touch()
    for path in (None, tmp_path / 'file', tmp_path / 'new', tmp_path / 'file' / '..' / 'new'):
        if path is None or path.parent.is_dir():
            need_writable(path)
