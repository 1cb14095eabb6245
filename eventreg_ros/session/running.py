# SPDX-License-Identifier: Apache-2.0
"""The runs of this user on this machine: where `eventreg set` finds the loop that runs.

A run leaves a file with what another process needs to reach its nodes, and takes it away when it
ends. Files of runs that were killed are removed when somebody looks.
"""

from __future__ import annotations

import json
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from ..errors import EventregError
from ..files import writing
from ..nodes import environment
from .domain import REACH


class Running(NamedTuple):
    """A run: its process, its scenario, its nodes, and the environment that reaches them."""

    pid: int
    scenario: str
    nodes: tuple[str, ...]
    environment: Mapping[str, str]

    @property
    def domain(self) -> str:
        """The ROS domain id in which its nodes are."""
        return self.environment.get('ROS_DOMAIN_ID', '0')

    def __str__(self) -> str:
        """Return its scenario and its domain: exact on ROS_DOMAIN_ID=7."""
        return f'{self.scenario} on ROS_DOMAIN_ID={self.domain}'


@contextmanager
def announced(
    scenario: str, nodes: tuple[str, ...], environment: Mapping[str, str]
) -> Iterator[None]:
    """Announce the run of this process until the block ends; where that cannot be, go on."""
    reach = {name: value for name, value in environment.items() if name.startswith(REACH)}
    home = _home()
    file = home / f'{os.getpid()}.json'
    data = {'scenario': scenario, 'nodes': list(nodes), 'environment': reach}
    with suppress(OSError):
        home.mkdir(mode=0o700, exist_ok=True)
        if _is_private(home):
            # Whole or not at all: who reads half of it would take it away.
            with suppress(EventregError), writing(file) as new:
                new.write_text(json.dumps(data), encoding='utf-8')
    try:
        yield
    finally:
        with suppress(OSError):
            file.unlink()
            runs()  # which removes those of runs that were killed
            home.rmdir()


def runs() -> list[Running]:
    """Return the active runs, the oldest first."""
    found = []
    with suppress(OSError):
        if not _is_private(_home()):
            return []
        for file in sorted(_home().glob('[0-9]*.json'), key=lambda f: f.stat().st_mtime):
            if (run := _read(file)) is not None:
                found.append(run)
    return found


def the_run() -> Running | None:
    """Return the one active run; None where ROS_DOMAIN_ID says whom to reach, or none does.

    Raises EventregError when there are several.
    """
    if 'ROS_DOMAIN_ID' in os.environ:
        return None
    found = runs()
    if len(found) > 1:
        which = ', '.join(map(str, found))
        raise EventregError(
            f'several runs are active ({which}); choose one: export its ROS_DOMAIN_ID'
        )
    return found[0] if found else None


def reaching_environment(run: Running | None) -> dict[str, str]:
    """Return the environment that reaches ``run``, else whom ROS_* say, on this host.

    Raises EventregError when ROS cannot be used with it.
    """
    found = {environment.RANGE: 'LOCALHOST', **os.environ}
    found |= run.environment if run is not None else {}
    environment.check(found)
    return found


def of_domain(domain: str) -> str:
    """Return in words which run is in ``domain``; only the domain where none is announced."""
    found = [str(run) for run in runs() if run.domain == domain]
    return ', '.join(found) or f'ROS_DOMAIN_ID={domain}'


def _home() -> Path:
    return Path(tempfile.gettempdir()) / f'eventreg_runs_{os.getuid()}'


def _is_private(home: Path) -> bool:
    """Say whether nobody else could have put files there: they say whom to reach, and how."""
    status = home.lstat()
    return (
        stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o22
    )


def _read(file: Path) -> Running | None:
    """Return what a file says; a file that is no run's, or whose process has ended, goes."""
    try:
        pid, data = int(file.stem), json.loads(file.read_text(encoding='utf-8'))
        os.kill(pid, 0)
        return Running(pid, data['scenario'], tuple(data['nodes']), dict(data['environment']))
    except (OSError, ValueError, KeyError, TypeError):
        with suppress(OSError):
            file.unlink()
        return None
