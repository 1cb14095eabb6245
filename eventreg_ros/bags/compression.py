# SPDX-License-Identifier: Apache-2.0
"""Unpacking, never more than was promised: a small file may claim to hold gigabytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Protocol

from .channel import UnreadableError

ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'

FREE = 2**30
RATIO = 500
"""What unpacks to more than FREE bytes and to more than RATIO times its size is no recording."""

PIECE = 2**20
_STEP = 2**12


class TornError(ValueError):
    """Packed data that are damaged, or end too early."""


class Decompressor(Protocol):
    """What zstd's and lz4's objects have in common."""

    eof: bool
    unused_data: bytes | None

    def decompress(self, data: bytes | memoryview, max_length: int = -1) -> bytes:
        """Return what comes out next."""


def sane(packed: int, unpacked: int) -> bool:
    """Whether ``packed`` bytes may unpack to ``unpacked``."""
    return unpacked <= max(FREE, RATIO * packed)


def zstd_decompressor() -> Decompressor:
    """Return a new one."""
    import sys

    if sys.version_info >= (3, 14):
        from compression.zstd import ZstdDecompressor
    else:
        from backports.zstd import ZstdDecompressor
    found: Decompressor = ZstdDecompressor()
    return found


def lz4_decompressor() -> Decompressor:
    """Return a new one."""
    from lz4.frame import LZ4FrameDecompressor

    found: Decompressor = LZ4FrameDecompressor()
    return found


DECOMPRESSORS: dict[str, Callable[[], Decompressor]] = {
    'zstd': zstd_decompressor,
    'lz4': lz4_decompressor,
}


def unpack(data: bytes | memoryview, compression: str, size: int) -> bytes:
    """Return what ``data`` unpack to, ``size`` bytes at most.

    Where they are damaged, that is what precedes the damage: the caller compares the length with
    what was promised.
    """
    if not size:
        return b''
    machine = DECOMPRESSORS[compression]()
    try:
        return machine.decompress(data, size)
    except Exception:  # each library raises its own
        return b''.join(_salvaged(data, compression, size))


def _salvaged(data: bytes | memoryview, compression: str, size: int) -> Iterator[bytes]:
    """Yield what comes out before the damage; a library that fails gives back nothing at all."""
    machine = DECOMPRESSORS[compression]()
    for at in range(0, len(data), _STEP):
        try:
            piece = machine.decompress(data[at : at + _STEP], size)
        except Exception:
            return
        size -= len(piece)
        yield piece
        if size <= 0 or machine.eof:
            return


def unpacked(pieces: Iterator[bytes], compression: str) -> Iterator[bytes]:
    """Yield what a stream of ``pieces`` unpacks to, PIECE bytes at a time.

    Raises TornError, after all that could be had, where the stream is damaged or ends too early.
    """
    machine, inside = DECOMPRESSORS[compression](), False
    for data in _sliced(pieces):
        while True:
            try:
                piece = machine.decompress(data, PIECE)
            except Exception as error:  # each library raises its own
                raise TornError(str(error)) from None
            if piece:
                yield piece
            inside, data = not machine.eof, b''
            if machine.eof:  # another frame may follow
                data, machine = machine.unused_data or b'', DECOMPRESSORS[compression]()
            if not data and len(piece) < PIECE:
                break
    if inside:
        raise TornError('it ends too early')


def _sliced(pieces: Iterator[bytes]) -> Iterator[bytes]:
    """Yield small parts: of the part in which the damage is, nothing comes out."""
    for piece in pieces:
        for at in range(0, len(piece), _STEP):
            yield piece[at : at + _STEP]


def unpack_file(file: Path, to: Path) -> bool:
    """Unpack a .zstd file; whether it was whole.

    Raises UnreadableError where it is no recording.
    """
    size, done = file.stat().st_size, 0
    with file.open('rb') as source, to.open('wb') as target:
        try:
            for piece in unpacked(_read(source), 'zstd'):
                done += len(piece)
                if not sane(size, done):
                    raise UnreadableError(
                        f'{file} holds {size} bytes that unpack to more than {done >> 20} MiB, '
                        'which no recording does; unpack it by hand if you trust it'
                    )
                target.write(piece)
        except TornError:
            return False
    return True


def _read(file: IO[bytes]) -> Iterator[bytes]:
    while piece := file.read(PIECE):
        yield piece
