# SPDX-License-Identifier: Apache-2.0
"""A curve f = 0 in the plane, followed by pseudo-arclength.

From a point of the curve a step is made along the tangent; from there Newton's method goes back to
the curve, at right angles to that tangent. The step grows while that is easy and shrinks where it
is not, so that the curve may turn round in either coordinate.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from ..errors import EventregError
from ..simulation.trajectory import Array

EXACT = 1e-9
"""|f| that counts as none."""

CORRECTIONS = 8
"""Newton steps after which a step is too long."""

EASY = 4
"""Newton steps up to which the next step is longer."""

TURN = 0.2
"""Radians by which the tangent may turn in a step."""

FIRST, SHORTEST = 0.25, 0.01
"""Length of the first step, and of the shortest, in the unit of the plane."""

MOST = 5000
"""Points of a curve after which it is not followed on."""


class Value(Protocol):
    """What is known at a point of the plane."""

    @property
    def point(self) -> Array:
        """The point, shape (2,)."""

    @property
    def value(self) -> float:
        """The value of f there."""

    @property
    def slope(self) -> Array:
        """The gradient of f there, shape (2,)."""

    @property
    def exact(self) -> bool:
        """Whether ``value`` is that of f, and not a guess that the next look there improves."""


V = TypeVar('V', bound=Value)
Evaluate = Callable[[Array, V], V]
"""Takes a point and what is known at a point nearby. Raises EventregError where f has no value."""


class LostError(EventregError):
    """The curve cannot be followed from here."""


class Walk(NamedTuple, Generic[V]):
    """Points along a curve; why it ends at either side, '' where it leaves the box or is closed."""

    points: list[V]
    closed: bool
    ends: tuple[str, str]


class Plane(Generic[V]):
    """A function over a box of the plane, 0 to ``high``, shape (2,).

    ``longest`` is the longest step.
    """

    def __init__(self, evaluate: Evaluate[V], high: Array, longest: float) -> None:
        self._evaluate, self._high, self._longest = evaluate, high, longest

    def curve(self, near: V) -> Walk[V]:
        """Return the curve through the point of it next to ``near``, in both directions.

        Raises EventregError where there is none nearby.
        """
        first = self._down(near)
        points, closed, end = self._walk(first, 1.0)
        if closed:
            return Walk(points, True, ('', ''))
        others, _, other_end = self._walk(first, -1.0)
        return Walk([*others[:0:-1], *points], False, (other_end, end))

    def _down(self, near: V) -> V:
        """Return the point of the curve that lies down the gradient from ``near``."""
        along = _tangent(near)
        found, _ = self._corrected(near.point, near, along, float(along @ near.point))
        if not self._inside(found.point):
            raise LostError('its nearest point is outside the ranges')
        return found

    def _corrected(self, point: Array, near: V, row: Array, at: float) -> tuple[V, int]:
        """Return the point of the curve with ``row`` . point = ``at`` next to ``point``.

        Besides, how many Newton steps it took. Raises EventregError.
        """
        for count in range(CORRECTIONS):
            near = self._evaluate(point, near)
            if near.exact and abs(near.value) < EXACT:
                return near, count
            system, gap = np.vstack([near.slope, row]), np.array([near.value, row @ point - at])
            if not abs(np.linalg.det(system)) > 1e-12:
                break
            move = np.linalg.solve(system, -gap)
            if not np.linalg.norm(move) < 2.0 * self._longest:
                break
            point = point + move
        raise LostError('Newton does not find its way back to the curve')

    def _walk(self, first: V, sense: float) -> tuple[list[V], bool, str]:
        points, length = [first], FIRST
        along = sense * _tangent(first)
        while len(points) < MOST:
            here = points[-1]
            try:
                after, count = self._step(here, along, length)
                turned = _tangent(after)
                turned = turned * np.sign(turned @ along)
                if turned @ along < np.cos(TURN) and length > SHORTEST:
                    raise LostError('it turns too quickly')
            except EventregError as error:
                if length <= SHORTEST:
                    return points, False, str(error)
                length = max(0.5 * length, SHORTEST)
                continue
            if not self._inside(after.point):
                return self._to_the_edge(points, after), False, ''
            points.append(after)
            if len(points) > 3 and _passes(here, after, first, sense):
                return [*points[:-1], first], True, ''
            along = turned
            length = min(1.5 * length, self._longest) if count <= EASY else length
        return points, False, f'it is longer than {MOST} points'

    def _step(self, here: V, along: Array, length: float) -> tuple[V, int]:
        point = here.point + length * along
        return self._corrected(point, here, along, float(along @ point))

    def _inside(self, point: Array) -> bool:
        return bool(((point >= 0.0) & (point <= self._high)).all())

    def _to_the_edge(self, points: list[V], outside: V) -> list[V]:
        """Return ``points`` and the one at which the curve leaves the box, where that is found."""
        here, there = points[-1].point, outside.point
        edge = np.clip(there, 0.0, self._high)
        out = np.flatnonzero((edge != there) & (edge != here))
        if not len(out):
            return points
        parts = ((edge - here) / np.where(there != here, there - here, 1.0))[out]
        i = int(out[np.argmin(parts)])
        guess = here + parts.min() * (there - here)
        guess[i] = edge[i]
        try:
            last, _ = self._corrected(guess, points[-1], np.eye(2)[i], float(edge[i]))
        except EventregError:
            return points
        return [*points, last] if self._inside(last.point) else points


def _tangent(at: Value) -> Array:
    """Return the direction along which f does not change. Raises LostError where it has none."""
    size = float(np.linalg.norm(at.slope))
    if not size > 1e-12:
        raise LostError('y does not change with the two parameters')
    return np.array([-at.slope[1], at.slope[0]]) / size


def _passes(before: Value, after: Value, start: Value, sense: float) -> bool:
    """Say whether a step passes ``start``, going as the curve began there, so that it is closed."""
    step, back = after.point - before.point, start.point - before.point
    length = float(np.linalg.norm(step))
    if not length > 0.0 or step @ (sense * _tangent(start)) <= 0.0:
        return False
    part = float(back @ step) / length**2
    beside = float(np.linalg.norm(back - part * step))
    return 0.0 <= part <= 1.0 and beside < 0.5 * length
