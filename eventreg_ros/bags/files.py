# SPDX-License-Identifier: Apache-2.0
"""Which files make a bag: a directory, with or without metadata.yaml, or one file."""

from __future__ import annotations

import contextlib
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import BagError
from . import metadata
from .metadata import Metadata

METADATA = 'metadata.yaml'
SIDECAR = '.scenario.yaml'
"""NAME.scenario.yaml lies in the bag from the start: a killed recorder writes no metadata."""

STORAGES = {'mcap': '.mcap', 'sqlite3': '.db3'}
PACKED = ('.zstd', '.zst')


@dataclass(frozen=True)
class BagFiles:
    """The files of a bag in order, and what metadata.yaml says of them.

    ``missing`` are named there but not in the directory, ``extra`` the other way round;
    ``broken``: there is a metadata.yaml, and it cannot be understood.
    """

    files: tuple[Path, ...]
    missing: tuple[str, ...] = ()
    extra: tuple[str, ...] = ()
    metadata: Metadata | None = None
    broken: bool = False


def bag_files(path: Path) -> BagFiles:
    """Return the files of a bag. Raises BagError where there is none, or it is no file at all."""
    if path.name == METADATA and path.is_file():
        path = path.parent
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        raise BagError(f'bag {path} does not exist; check the path') from None
    except OSError as error:
        raise BagError(f'bag {path} cannot be read: {error.strerror}; check the path') from None
    if stat.S_ISDIR(mode):
        return _of_directory(path)
    need_regular(path)
    return BagFiles((path,))


def need_regular(path: Path) -> None:
    """Raise BagError for a device, a pipe or a socket: reading one may never end."""
    if not path.is_file():
        raise BagError(
            f'{path} is a device, a pipe or a socket, not a file; give the directory or the file '
            'of a bag'
        )


def _of_directory(path: Path) -> BagFiles:
    try:
        names = sorted((f.name for f in path.iterdir()), key=_natural)
    except OSError as error:
        raise BagError(f'bag {path} cannot be read: {error.strerror}; check its rights') from None
    there = [name for name in names if _is_storage(name) and (path / name).is_file()]
    there = [name for name in there if not (_unpacked(name) != name and _unpacked(name) in there)]
    found, broken = _read_metadata(path / METADATA) if METADATA in names else (None, False)
    named = list(found.files) if found else []
    stated = {_unpacked(name): name for name in named}
    listed = [name for stem in stated for name in there if _unpacked(name) == stem]
    extra = [name for name in there if _unpacked(name) not in stated]
    missing = [name for stem, name in stated.items() if stem not in map(_unpacked, there)]
    if not there:
        raise BagError(_nothing(path, missing))
    return BagFiles(
        tuple(path / name for name in [*listed, *extra]), tuple(missing),
        tuple(extra) if found else (), found, broken,
    )  # fmt: skip


def _nothing(path: Path, missing: list[str]) -> str:
    if missing:
        return (
            f'bag {path} has none of the files that its metadata.yaml names ({missing[0]}); put '
            'them back beside it'
        )
    return (
        f'{path} is no bag: it holds neither metadata.yaml nor a .mcap or .db3 file; '
        'give the directory that ros2 bag or the recorder made'
    )


def _is_storage(name: str) -> bool:
    return not name.startswith('.') and _unpacked(name).endswith(tuple(STORAGES.values()))


def _unpacked(name: str) -> str:
    """Return the name of a packed file without the ending that says so."""
    for ending in PACKED:
        name = name.removesuffix(ending)
    return name


def _natural(name: str) -> list[tuple[str, int]]:
    """Sort s_10 after s_9."""
    return [(text, int(part or 0)) for text, part in re.findall(r'(\D*)(\d*)', name)]


def _read_metadata(file: Path) -> tuple[Metadata | None, bool]:
    """Return what metadata.yaml says, and whether it cannot be understood."""
    if not file.is_file():
        return None, True
    try:
        with file.open(encoding='utf-8', errors='replace') as opened:
            found = metadata.parse(opened.read(metadata.MOST + 1))
    except OSError:
        found = None
    return found, found is None


def newest(directory: Path) -> Path:
    """Return the bag within ``directory`` that was written last, of those that hold a scenario.

    All that eventreg makes do. Raises BagError where there is none.
    """
    found = []
    for sidecar in directory.glob('*/*' + SIDECAR):
        with contextlib.suppress(OSError):
            names = [f for f in sidecar.parent.iterdir() if _is_storage(f.name)]
            found += [(max(f.stat().st_mtime_ns for f in names), sidecar.parent)] if names else []
    if not found:
        raise BagError(
            f'no bag of eventreg run is in {directory.absolute()}; make one, or give its path'
        )
    return max(found)[1]


# The scenario ------------------------------------------------------------------------------------


def sidecar(path: Path) -> tuple[str, str] | None:
    """Return text and name of the scenario beside a bag, None where it is not clear which."""
    directory = path if path.is_dir() else path.parent
    found = list(_sidecars(directory))
    if len(found) != 1:
        return None
    try:
        with found[0].open(encoding='utf-8') as file:
            return file.read(metadata.MOST), found[0].name.removesuffix(SIDECAR)
    except (OSError, UnicodeDecodeError):
        return None


def _sidecars(directory: Path) -> Iterator[Path]:
    for file in sorted(directory.glob('*' + SIDECAR)):
        if file.is_file():
            yield file
