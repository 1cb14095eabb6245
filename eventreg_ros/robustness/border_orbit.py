# SPDX-License-Identifier: Apache-2.0
"""The border as a curve: the periodic orbit whose largest y is the threshold, followed.

The orbit is that of the sampled loop (:mod:`..theory.orbit`), from where the loop's own initial
state leads. Nothing is given out on the word of the theory alone: for each point two runs like
those of the grid, one on either side of the curve, have to differ.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from ..analysis.rejection import NOT_REJECTED, REJECTED
from ..errors import EventregError
from ..simulation.model_errors import ANYTHING
from ..theory.continuation import Plane, Walk
from ..theory.orbit import Orbit, Orbits
from ..theory.waves import OrbitError
from .axes import Array
from .border import Border, Curve
from .followed import NEAR, Followed, Piece
from .orbit_rules import Line, Numbers, unsound
from .outcome import VERDICTS
from .plan import Plan
from .sets import Sets
from .sweep import pool_here

STARTS = 24
"""Points of the grid's border from which the curve is looked for, at most."""

LONGEST, SHARE = 2.0, 0.01
"""Longest step along the curve; like all lengths here in steps of the grid. On a large grid it is
that part of its size."""

FAILED = 8.0
"""Distance from a start that fails within which no other is tried."""

SAME = 0.5
"""Distance within which two curves are the same."""

FINEST, WIDER = 0.001, (0.05, 0.25, 1.0)
"""How far beside the curve runs are made at least; and where, if those do not differ."""

LONGER, SETTLED = 2.0, 100_000
"""Runs of the grid, but at most so many steps, after which the loop is on its orbit."""

TOGETHER = 256
"""Points whose distances are measured at a time: this bounds the memory."""

LIMIT = 5.0
"""Seconds of processor time that following may take at most, if nothing else is said."""


class OnBorder(NamedTuple):
    """A point of the curve; ``value`` is by how much the peak of y exceeds the threshold."""

    orbit: Orbit
    value: float

    @property
    def point(self) -> Array:
        """The point, shape (2,)."""
        return self.orbit.point

    @property
    def slope(self) -> Array:
        """The gradient of ``value`` there, shape (2,)."""
        return self.orbit.slope

    @property
    def exact(self) -> bool:
        """Whether ``value`` is known as well as it will be."""
        return self.orbit.exact


def follow(plan: Plan, border: Border, limit: float = LIMIT) -> Followed:
    """Follow the border that was found for a plan; x and y are those of ``border``.

    After ``limit`` seconds of processor time no more is looked for.
    """
    count = sum(map(len, border.places))
    reason = unsound(plan) if count else 'there is no border to begin at'
    if reason:
        return Followed([], missed=count, reason=reason)
    turned = border.names[0] != plan.axes[0].name
    try:
        with pool_here() as pool:
            found = _Follower(plan, border.turned if turned else border, pool, limit).found()
    except EventregError as error:
        return Followed([], missed=count, reason=str(error))
    except ANYTHING as error:  # numba's about models of other packages, and their own
        if not plan.scenario.loop.foreign_models:
            raise
        return Followed([], missed=count, reason=f'a model fails ({type(error).__name__})')
    if not turned:
        return found
    return found._replace(pieces=[p._replace(places=p.places[:, ::-1]) for p in found.pieces])


class _Follower:
    """Follows the border of a plan, in steps of its grid; x is the plan's first axis."""

    def __init__(self, plan: Plan, border: Border, pool: ThreadPoolExecutor, limit: float) -> None:
        self._border, self._sets, self._pool = border, Sets(plan), pool
        self._until = time.process_time() + limit
        self._lines = Line(border.x), Line(border.y)
        loop, criteria = plan.scenario.loop, plan.subject.criteria
        self._threshold, self._reset = criteria.threshold, criteria.reset
        time_scale, rate = loop.grid
        self._time = min(LONGER * plan.duration, SETTLED * time_scale / rate)
        exosystem, output = next(iter(loop.of_role('exosystem'))), plan.subject.plants[0].output
        self._orbits = Orbits(loop, exosystem, output, Numbers(self._sets, self._lines))
        high = np.array([len(border.x) - 1.0, len(border.y) - 1.0])
        self._plane = Plane(self._near, high, max(LONGEST, SHARE * float(high.max())))

    def found(self) -> Followed:
        """Return the curve, confirmed by runs."""
        reasons, walks = list[str](), list[Walk[OnBorder]]()
        self._walk(walks, reasons)
        pieces, dropped = list[Piece](), 0
        for walk in walks:
            off, within = self._confirmed(walk.points)
            pieces += _pieces(walk, off, within)
            dropped += len(walk.points)
        dropped -= sum(len(piece.places) for piece in pieces)
        pieces = _once(pieces)
        if dropped:
            reasons.append('runs on both sides of it do not differ')
        curves, places = [piece.places for piece in pieces], self._border.places
        missed = int((_distance(np.vstack(places), curves) > NEAR).sum())
        apart = max((float(_distance(curve, places).max()) for curve in curves), default=0.0)
        if not (missed or dropped):
            return Followed(pieces, apart)
        said = '; '.join(dict.fromkeys(reasons)) or 'the curve next to them is elsewhere'
        return Followed(pieces, apart, missed, dropped, said)

    def _columns(self, points: Array) -> list[Array]:
        return [line(points[:, i]) for i, line in enumerate(self._lines)]

    def _need_time(self) -> None:
        if time.process_time() > self._until:
            raise OrbitError('it takes too long; give smaller ranges, or fewer values')

    def _near(self, point: Array, near: OnBorder) -> OnBorder:
        self._need_time()
        return self._of(self._orbits.at(point, near.orbit))

    def _of(self, orbit: Orbit) -> OnBorder:
        """Return what an orbit says of the border. Raises OrbitError where it says nothing."""
        if orbit.exact and not orbit.attracts:
            raise OrbitError('the orbit does not attract')
        if orbit.exact and orbit.low > self._reset:
            raise OrbitError(f'y does not come down to the reset, {self._reset:g}')
        return OnBorder(orbit, orbit.peak - self._threshold)

    def _walk(self, walks: list[Walk[OnBorder]], reasons: list[str]) -> None:
        """Follow the curve until all of the grid's border is found or was tried."""
        todo = np.vstack(self._border.places)
        for _ in range(STARTS):
            if not len(todo):
                break
            start, away = todo[len(todo) // 2], NEAR
            try:
                self._need_time()
                walk = self._plane.curve(self._of(self._orbits.settled(start, self._time)))
            except EventregError as error:
                reasons.append(str(error))
                away = FAILED
            else:
                reasons += filter(None, walk.ends)
                curve = _curve(walk)
                if _is_new(curve, list(map(_curve, walks))):
                    walks[:] = [w for w in walks if _is_new(_curve(w), [curve])]
                    walks.append(walk)
                todo = todo[_distance(todo, [curve]) > NEAR]
            todo = todo[np.linalg.norm(todo - start, axis=1) > away]
        if len(todo):
            reasons.append(f'it was looked for from {STARTS} points and no more')

    def _confirmed(self, points: Sequence[OnBorder]) -> tuple[Array, Array]:
        """Return ``off`` and ``within`` of points; the latter is 0 where no two runs differ."""
        places = np.array([point.point for point in points])
        slopes = np.array([point.slope for point in points])
        sizes = np.linalg.norm(slopes, axis=1)
        peaks = self._sets.run(self._columns(places), self._pool).rows['peak']
        off = np.nan_to_num((self._threshold - peaks) / sizes, nan=np.inf)
        within = np.zeros(len(points))
        for wanted in (
            FINEST + 2.0 * np.abs(off),
            *map(np.full_like, [off] * len(WIDER), WIDER),
        ):
            tried = np.flatnonzero((within == 0.0) & (wanted <= 1.0) & (np.abs(off) <= 1.0))
            if not len(tried):
                continue
            beside = wanted[tried, None] * slopes[tried] / sizes[tried, None]
            both = np.vstack([places[tried] - beside, places[tried] + beside])
            verdicts = self._sets.run(self._columns(both), self._pool).rows['verdict']
            inside, outside = np.split(verdicts, 2)
            differ = inside == VERDICTS.index(REJECTED)
            differ &= outside == VERDICTS.index(NOT_REJECTED)
            within[tried[differ]] = wanted[tried[differ]]
        return off, within


def _curve(walk: Walk[OnBorder]) -> Curve:
    return np.array([point.point for point in (*walk.points, walk.points[-1])])


def _pieces(walk: Walk[OnBorder], off: Array, within: Array) -> Iterator[Piece]:
    """Yield the stretches of a walk that runs confirm."""
    good, places = np.flatnonzero(within > 0.0), _curve(walk)[:-1]
    for part in np.split(good, np.flatnonzero(np.diff(good) > 1) + 1):
        if len(part) > 1:
            yield Piece(places[part], off[part], within[part])


def _once(pieces: Sequence[Piece]) -> list[Piece]:
    """Return the pieces without those that go along others: walks may differ only beyond these."""
    kept: list[Piece] = []
    for piece in sorted(pieces, key=lambda piece: -len(piece.places)):
        if _is_new(piece.places, [each.places for each in kept]):
            kept.append(piece)
    return [piece for piece in pieces if any(piece is each for each in kept)]


def _is_new(curve: Curve, curves: Sequence[Curve]) -> bool:
    """Say whether a curve is anywhere else than others."""
    return bool(_distance(curve, curves).max() > SAME)


def _distance(points: Array, curves: Sequence[Curve]) -> Array:
    """Return how far points, shape (n, 2), are from the nearest curve, shape (n,)."""
    nearest = np.full(len(points), np.inf)
    for curve in curves:
        start, along = curve[:-1], np.diff(curve, axis=0)
        length = np.maximum((along**2).sum(axis=1), 1e-300)
        for i in range(0, len(points), TOGETHER):
            apart = points[i : i + TOGETHER, None] - start
            part = np.clip((apart * along).sum(axis=2) / length, 0.0, 1.0)
            left = np.linalg.norm(apart - part[..., None] * along, axis=2).min(axis=1)
            nearest[i : i + TOGETHER] = np.minimum(nearest[i : i + TOGETHER], left)
    return nearest
