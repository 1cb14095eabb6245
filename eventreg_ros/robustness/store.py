# SPDX-License-Identifier: Apache-2.0
"""Where a sweep is kept: what was asked for, what is done so far, and the table in the end.

DIR holds ``sweep.json`` (the plan, and the result once there is one), ``scenario.yaml``, and
``sweep.parquet``, or ``sweep.csv`` where DIR ends in .csv. Until the table is written, what is done
lies in ``parts``, a file per stretch of sets; each appears whole or not at all.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import EventregError
from ..files import writing
from .outcome import Outcomes
from .plan import Plan


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
        _write(path / 'scenario.yaml', plan.text)
        if not self._json.exists():
            self._note({})

    @property
    def table(self) -> Path:
        """The file that holds the table in the end."""
        return self.path / ('sweep.csv' if self.path.suffix == '.csv' else 'sweep.parquet')

    @property
    def _json(self) -> Path:
        return self.path / 'sweep.json'

    def _need_same_plan(self) -> None:
        if not self._json.exists():
            if self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
                raise EventregError(f'{self.path} is there and holds no sweep; name another --out')
            return
        try:
            before = json.loads(self._json.read_text(encoding='utf-8'))['plan']
        except (OSError, ValueError, KeyError, TypeError):
            raise EventregError(
                f'{self._json} does not say what the sweep was; remove it or name another --out'
            ) from None
        now = self.plan.as_dict()
        for name, value in now.items():
            if before.get(name) != value:
                raise EventregError(
                    f'{self.path} holds another sweep: its {name} was {_short(before.get(name))}, '
                    f'not {_short(value)}; name another --out or remove it'
                )

    def _note(self, result: dict[str, Any]) -> None:
        text = json.dumps({'plan': self.plan.as_dict(), **result}, indent=1)
        _write(self._json, text + '\n')

    @property
    def result(self) -> dict[str, Any] | None:
        """What was found, once the table is written."""
        if not self.table.exists():
            return None
        found: dict[str, Any] | None = json.loads(self._json.read_text(encoding='utf-8')).get(
            'result'
        )
        return found

    # Parts

    def save(self, stretch: Stretch, outcomes: Outcomes) -> None:
        """Keep the outcomes of a stretch."""
        path = self._parts / f'{stretch.first:012d}-{stretch.last:012d}.npz'
        path.parent.mkdir(exist_ok=True)
        reasons = np.frombuffer(json.dumps(list(outcomes.reasons.items())).encode(), np.uint8)
        with writing(path) as file:
            np.savez(file, rows=outcomes.rows, reasons=reasons)

    def done(self) -> list[Stretch]:
        """Return the stretches that are done, in order, none twice."""
        found = sorted(
            Stretch(*map(int, path.stem.split('-'))) for path in self._parts.glob('*-*.npz')
        )
        kept: list[Stretch] = []
        for stretch in found:
            if not kept or stretch.first >= kept[-1].last:
                kept.append(stretch)
        return kept

    def missing(self, count: int) -> list[Stretch]:
        """Return the stretches of ``count`` sets that are not done, in order."""
        gaps, at = [], 0
        for stretch in [*self.done(), Stretch(count, count)]:
            if stretch.first > at:
                gaps.append(Stretch(at, stretch.first))
            at = max(at, stretch.last)
        return gaps

    def outcomes(self) -> Iterator[tuple[Stretch, Outcomes]]:
        """Yield what is done, in order."""
        for stretch in self.done():
            with np.load(self._parts / f'{stretch.first:012d}-{stretch.last:012d}.npz') as part:
                pairs = json.loads(part['reasons'].tobytes().decode())
                yield stretch, Outcomes(part['rows'], {int(i): text for i, text in pairs})

    def finish(self, result: dict[str, Any]) -> None:
        """Note the result, once the table is there, and leave the parts behind."""
        self._note({'result': result})
        shutil.rmtree(self._parts, ignore_errors=True)


def _write(path: Path, text: str) -> None:
    with writing(path) as file:
        file.write_text(text, encoding='utf-8')


def _short(value: Any) -> str:
    text = ' '.join(str(value).split())
    return text if len(text) <= 60 else f'{text[:57]}...'
