# SPDX-License-Identifier: Apache-2.0
"""What is imperfect around the blocks of each set: its links, and the sensors on its plants."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from ..errors import EventregError
from ..simulation.impairment import Impairment
from ..simulation.noise import Noise
from .axes import LINKS, NOISE, Array
from .plan import Plan, impairment, whole_seed


class Imperfections(NamedTuple):
    """What happens on the links of sets, and what is added to their plants' outputs.

    Each has one entry for all sets, or one per set.
    """

    impairments: Sequence[Impairment]
    noises: Sequence[Noise]

    def of(self, places: Sequence[int]) -> Imperfections:
        """Return those of some of the sets."""
        links, noises = (
            each if len(each) == 1 else [each[i] for i in places]
            for each in (self.impairments, self.noises)
        )
        return Imperfections(links, noises)  # type: ignore[arg-type]

    def at(self, i: int) -> tuple[Impairment, Noise]:
        """Return those of one set."""
        links, noises = self.of([i])
        return links[0], noises[0]


class Imperfect:
    """Gives the imperfections of any sets of a plan."""

    def __init__(self, plan: Plan) -> None:
        self._axes, self._impairment, self._noise = plan.axes, plan.impairment, plan.noise
        self._of_links = [i for i, axis in enumerate(self._axes) if axis.node == LINKS]
        self._of_noise = [i for i, axis in enumerate(self._axes) if axis.node == NOISE]

    def of(
        self, columns: Sequence[Array], count: int, reasons: dict[int, str] | None = None
    ) -> Imperfections:
        """Return those of ``count`` sets with these values, one array per axis.

        Why a set is refused is put into ``reasons``, by its place, unless something is there;
        without ``reasons`` it is raised.
        """
        found = Imperfections([self._impairment], [self._noise])
        if self._of_links:
            found = found._replace(impairments=self._impairments(columns, count, reasons))
        if self._of_noise or (self._noise.on and len(found.impairments) > 1):
            found = found._replace(noises=self._noises(columns, count, reasons))
        return found

    def _impairments(
        self, columns: Sequence[Array], count: int, reasons: dict[int, str] | None
    ) -> list[Impairment]:
        base, found = self._impairment, []
        fixed = {name: getattr(base, name) for name in ('delay', 'loss', 'jitter', 'seed')}
        names = [self._axes[i].parameter for i in self._of_links]
        rows = zip(*(columns[i].tolist() for i in self._of_links), strict=True)
        for at, values in enumerate(rows):
            varied = tuple(zip(names, values, strict=True))
            try:
                found.append(_impairment(varied, tuple(fixed.items()), base.on))
            except EventregError as error:
                _note(reasons, at, error)
                found.append(base)
        return found

    def _noises(
        self, columns: Sequence[Array], count: int, reasons: dict[int, str] | None
    ) -> list[Noise]:
        base, found = self._noise, []
        rows: list[list[float]] = [[sd] * count for sd in base.sds]
        for i in self._of_noise:
            rows[base.on.index(self._axes[i].parameter)] = columns[i].tolist()
        seeds = [base.seed] * count
        for i in self._of_links:
            seeds = columns[i].tolist() if self._axes[i].parameter == 'seed' else seeds
        for at, (seed, *sds) in enumerate(zip(seeds, *rows, strict=True)):
            try:
                found.append(Noise(tuple(sds), whole_seed(seed), base.on))
            except EventregError as error:
                _note(reasons, at, error)
                found.append(base)
        return found


def _note(reasons: dict[int, str] | None, at: int, error: EventregError) -> None:
    if reasons is None:
        raise error
    reasons.setdefault(at, str(error))


@lru_cache(maxsize=4096)
def _impairment(
    varied: tuple[tuple[str, float], ...],
    fixed: tuple[tuple[str, float], ...],
    on: frozenset[str] | None,
) -> Impairment:
    return impairment(**{**dict(fixed), **dict(varied)}, on=on)
