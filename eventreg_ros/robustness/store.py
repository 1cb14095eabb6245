# SPDX-License-Identifier: Apache-2.0
"""Where a sweep is kept: what was asked for, what is done so far, and the table in the end.

DIR holds ``sweep.json`` (the plan, and the result once there is one), ``scenario.yaml``, and
``sweep.parquet``, or ``sweep.csv`` where DIR ends in .csv. Until the table is written, what is done
lies in ``parts``, a file per stretch of sets; each appears whole or not at all. One that cannot be
read any more is run again, and so is a sweep whose table has another size than it had.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import EventregError
from ..files import DRAFT, remove_dead_drafts, writing
from .outcome import ROW, Outcomes
from .plan import Plan

COUNTS = ('sets', 'rejected', 'not_rejected', 'undecided', 'bad', 'seconds')
"""What the result of a finished sweep consists of."""


class Stretch(NamedTuple):
    """Sets ``first`` to ``last`` - 1."""

    first: int
    last: int


class Store:
    """The directory of a sweep; made where it is not there."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path, self.plan = path, plan
        self._parts = path / 'parts'
        self._need_same_plan()
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise EventregError(
                f'cannot write {path}: {error.strerror}; name another --out'
            ) from None

    def _begin(self) -> None:
        """Write what was asked for, unless it is there: a finished sweep may be read-only."""
        self._need_same_plan()  # another process may have begun another sweep by now
        if not self._json.exists():
            self._note({})  # first: a directory with anything else holds no sweep
        path = self.path / 'scenario.yaml'
        if not path.is_file() or path.read_bytes() != self.plan.text.encode():
            _write(path, self.plan.text)

    @property
    def table(self) -> Path:
        """The file that holds the table in the end."""
        return self.path / ('sweep.csv' if self.path.suffix == '.csv' else 'sweep.parquet')

    @property
    def _json(self) -> Path:
        return self.path / 'sweep.json'

    def _need_same_plan(self) -> None:
        if not self._json.exists():
            if self.path.exists() and not (self.path.is_dir() and _is_empty(self.path)):
                raise EventregError(f'{self.path} is there and holds no sweep; name another --out')
            return
        before = self._noted().get('plan')
        if not isinstance(before, dict):
            raise EventregError(
                f'{self._json} does not say what the sweep was; remove {self.path} or name '
                'another --out'
            )
        now = self.plan.as_dict()
        for name, value in now.items():
            if before.get(name, '') != value:
                raise EventregError(
                    f'{self.path} holds another sweep: its {name} was {_short(before.get(name))}, '
                    f'not {_short(value)}; name another --out or remove it'
                )

    def _noted(self) -> dict[str, Any]:
        """Return what sweep.json holds, nothing where it cannot be read."""
        try:
            found = json.loads(self._json.read_text(encoding='utf-8'))
        except (OSError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}

    def _note(self, result: dict[str, Any]) -> None:
        text = json.dumps({'plan': self.plan.as_dict(), **result}, indent=1)
        _write(self._json, text + '\n')

    @property
    def result(self) -> dict[str, Any] | None:
        """What was found, once the table is written; None when the table is not that one."""
        found = self._noted().get('result')
        if not isinstance(found, dict) or not self.table.is_file():
            return None
        size = found.pop('bytes', None)
        whole = size is None or size == self.table.stat().st_size
        return found if whole and set(found) == set(COUNTS) else None

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Begin to work in the directory, and let no other process do so.

        What processes that were killed left there goes. Raises EventregError where another one is
        at work, or has begun another sweep.
        """
        place = os.open(self.path, os.O_RDONLY) if os.name == 'posix' else None
        try:
            if place is not None:
                self._lock(place)
            for directory in (self.path, self._parts):
                remove_dead_drafts(directory)
            self._begin()
            yield
        finally:
            if place is not None:
                os.close(place)

    def _lock(self, place: int) -> None:
        import fcntl

        try:
            fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise EventregError(
                f'another process works on the sweep in {self.path}; wait for it, or name '
                'another --out'
            ) from None
        except OSError:
            pass  # a file system that has no locks

    # Parts

    def save(self, stretch: Stretch, outcomes: Outcomes, seconds: float) -> None:
        """Keep the outcomes of a stretch, and how many seconds they took."""
        path = self._part(stretch)
        path.parent.mkdir(exist_ok=True)
        reasons = np.frombuffer(json.dumps(list(outcomes.reasons.items())).encode(), np.uint8)
        with writing(path) as file:
            np.savez(file, rows=outcomes.rows, reasons=reasons, seconds=seconds)

    def done(self) -> list[Stretch]:
        """Return the stretches that are done, in order, none twice."""
        found = sorted(map(_stretch, self._parts.glob('*-*.npz')))
        kept: list[Stretch] = []
        for stretch in found:
            if not kept or stretch.first >= kept[-1].last:
                kept.append(stretch)
        return kept

    def missing(self, count: int) -> list[Stretch]:
        """Return the stretches of ``count`` sets that are not done, in order.

        Parts that cannot be read, or are not of that many sets, go.
        """
        for path in self._parts.glob('*-*.npz'):
            if not _is_whole(path, count):
                path.unlink()
        gaps, at = [], 0
        for stretch in [*self.done(), Stretch(count, count)]:
            if stretch.first > at:
                gaps.append(Stretch(at, stretch.first))
            at = max(at, stretch.last)
        return gaps

    def outcomes(self) -> Iterator[tuple[Stretch, Outcomes]]:
        """Yield what is done, in order."""
        for stretch in self.done():
            yield stretch, _read_part(self._part(stretch))

    @property
    def seconds(self) -> float:
        """How many seconds what is done took, all runs of the command together."""
        return sum(_seconds(self._part(stretch)) for stretch in self.done())

    def _part(self, stretch: Stretch) -> Path:
        return self._parts / f'{stretch.first:012d}-{stretch.last:012d}.npz'

    def finish(self, result: dict[str, Any]) -> None:
        """Note the result, once the table is there, and leave the parts behind."""
        self._note({'result': {**result, 'bytes': self.table.stat().st_size}})
        self.forget_parts()

    def forget_parts(self) -> None:
        """Remove the parts: what came of them is kept elsewhere."""
        shutil.rmtree(self._parts, ignore_errors=True)


def _stretch(path: Path) -> Stretch:
    first, last = map(int, path.stem.split('-'))
    return Stretch(first, last)


def _read_part(path: Path) -> Outcomes:
    with np.load(path) as part:
        pairs = json.loads(part['reasons'].tobytes().decode())
        return Outcomes(part['rows'], {int(i): text for i, text in pairs})


def _seconds(path: Path) -> float:
    with np.load(path) as part:
        return float(part['seconds']) if 'seconds' in part else 0.0


def _is_whole(path: Path, count: int) -> bool:
    """Say whether a part can be read, and holds the sets of its name, of ``count``."""
    try:
        first, last = _stretch(path)
        rows = _read_part(path).rows
    except Exception:  # numpy's, of zip files, of JSON, the operating system's
        return False
    return first < last <= count and rows.dtype == ROW and rows.shape == (last - first,)


def _is_empty(directory: Path) -> bool:
    """Say whether nothing is in a directory but what somebody began to write."""
    return all(path.name.startswith(DRAFT) for path in directory.iterdir())


def _write(path: Path, text: str) -> None:
    with writing(path) as file:
        file.write_bytes(text.encode())


def _short(value: Any) -> str:
    text = ' '.join(str(value).split()) or 'none'
    return text if len(text) <= 60 else f'{text[:57]}...'
