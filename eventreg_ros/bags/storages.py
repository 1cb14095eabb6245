# SPDX-License-Identifier: Apache-2.0
"""The formats of files, and how each is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from ..files import scratch_directory
from . import mcap_records
from .channel import Account, Select, UnreadableError
from .compression import ZSTD_MAGIC, unpack_file
from .files import PACKED, need_regular
from .mcap_file import read_mcap
from .sqlite_file import MAGIC as SQLITE_MAGIC
from .sqlite_file import read_sqlite


class Format(NamedTuple):
    """A format: the bytes with which its files begin, the end of their names, and the reader."""

    magic: bytes
    ending: str
    read: Callable[[Path, Select], Account]


FORMATS = (
    Format(mcap_records.MAGIC, '.mcap', read_mcap),
    Format(SQLITE_MAGIC, '.db3', read_sqlite),
)
_ROS1 = b'#ROSBAG V'


def read_file(path: Path, select: Select) -> Account:
    """Hand the messages of a file to those who want them.

    Raises UnreadableError where it is no bag.
    """
    need_regular(path)
    try:
        with path.open('rb') as file:
            head = file.read(16)
        if head.startswith(ZSTD_MAGIC):
            return _read_packed(path, select)
        return _format(path, head).read(path, select)
    except OSError as error:
        raise UnreadableError(f'{path} cannot be read: {error.strerror or error}') from None
    except ImportError as error:
        raise UnreadableError(
            f'{path} cannot be read ({error}); pip install {error.name}'
        ) from None


def _format(path: Path, head: bytes) -> Format:
    for known in FORMATS:
        if head.startswith(known.magic):
            return known
    if not head:
        raise UnreadableError(f'{path} cannot be read: it is empty (0 bytes); nothing was recorded')
    if head.startswith(_ROS1):
        raise UnreadableError(f'{path} is a ROS 1 bag; bring it to ROS 2 with rosbags-convert')
    for known in FORMATS:
        if path.suffix == known.ending and len(head) >= len(known.magic):
            alike = sum(a == b for a, b in zip(head, known.magic, strict=False))
            if alike >= len(known.magic) // 2:  # its beginning may be what is damaged
                return known
    raise UnreadableError(
        f'{path} cannot be read: it begins neither as an MCAP file nor as a database does, but '
        f'with {head[:8]!r}; give the directory or the file of a bag'
    )


def _read_packed(path: Path, select: Select) -> Account:
    """Read a file that was packed as a whole: what it holds goes into a temporary file first."""
    name = path.stem if path.suffix in PACKED else path.name
    with scratch_directory() as scratch:
        plain = scratch / name
        whole = unpack_file(path, plain)
        account = read_file(plain, select)
    if not whole:
        account.note('damaged', f'{path.name} is damaged or cut; what it unpacks to was read')
    return account
