# SPDX-License-Identifier: Apache-2.0
"""What Fast DDS leaves in shared memory when a node is killed, and how it goes.

Nodes talk through files in /dev/shm. One that ends removes its own; one that is killed cannot. So a
run notes the files of its nodes, and at its end those go that no living process has any more. The
notes of a run that was killed itself are read by the next one.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ..files import UnreadableError, dead_scratch, read_text
from .domain import FIRST_PORT, PORTS

HOME = Path('/dev/shm')

NOTES = 'shared_memory'
"""The file in a run's scratch directory that holds the names."""

_NAME = re.compile(r'/dev/shm/((?:sem\.)?fastrtps_\w+)')


class Notes:
    """Notes in ``scratch`` which files the nodes of a run have; its domain tells their ports."""

    def __init__(self, scratch: Path, domain: int) -> None:
        self._file = scratch / NOTES
        first = FIRST_PORT + PORTS * domain
        self._names = {f'fastrtps_port{port}' for port in range(first, first + PORTS)}
        self._due = 0.0

    def take(self, pids: Iterable[int], every: float = 0.0) -> None:
        """Add the files that the processes ``pids`` have, at most ``every`` so many seconds."""
        if time.monotonic() < self._due:
            return
        self._due = time.monotonic() + every
        self._names |= used_by(pids)
        with suppress(OSError):
            self._file.write_text('\n'.join(sorted(self._names)), encoding='utf-8')


def used_by(pids: Iterable[int]) -> set[str]:
    """Return the names of Fast DDS's files in shared memory that these processes have."""
    found: set[str] = set()
    for pid in pids:
        with suppress(OSError):
            found |= set(_NAME.findall(Path(f'/proc/{pid}/maps').read_text(errors='replace')))
            for handle in Path(f'/proc/{pid}/fd').iterdir():
                with suppress(OSError):
                    found |= set(_NAME.findall(os.readlink(handle)))
    return found


def remove_noted(scratch: Path) -> None:
    """Remove the files noted in ``scratch`` that no living process has."""
    try:
        names = [name for name in read_text(scratch / NOTES).split('\n') if _is_name(name)]
    except UnreadableError:
        return
    parts = {part for name in names for part in (name, f'{name}_el', f'sem.{name}_mutex')}
    left = {name for name in parts if _is_ours(HOME / name)}
    if left:
        alive = used_by(int(path.name) for path in Path('/proc').iterdir() if path.name.isdigit())
        for name in left - alive:
            with suppress(OSError):
                (HOME / name).unlink()


def sweep() -> None:
    """Remove what runs that were killed have left."""
    for scratch in dead_scratch():
        remove_noted(scratch)


def _is_name(name: str) -> bool:
    return _NAME.fullmatch(f'{HOME}/{name}') is not None


def _is_ours(path: Path) -> bool:
    try:
        return path.lstat().st_uid == os.getuid()
    except OSError:
        return False
