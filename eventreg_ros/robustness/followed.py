# SPDX-License-Identifier: Apache-2.0
"""A border that was followed, as a result: its pieces, what is to be said of them, the csv file."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .axes import Array
from .border import Border, Curve
from .orbit_rules import Line

NEAR = 1.5
"""Distance within which the grid's border and the curve are the same, in steps of the grid."""


class Piece(NamedTuple):
    """A piece of the curve, all in steps of the grid.

    ``places`` has shape (n, 2). ``off`` is how far beyond each point, on the side that is not
    rejected, runs have their border by the peak of the run at the point; ``within``, how far beside
    it on either side two runs differ. Both have shape (n,).
    """

    places: Curve
    off: Array
    within: Array


class Followed(NamedTuple):
    """The followed border; ``pieces`` are the stretches that runs confirm.

    ``apart`` is the largest distance of a point from the grid's border, in steps of the grid;
    ``missed`` is how many points of the latter are more than :data:`NEAR` from the curve, and
    ``dropped`` how many points were found and not confirmed. ``reason`` says why there is no curve,
    or not everywhere; '' where there is nothing to say.
    """

    pieces: list[Piece]
    apart: float = 0.0
    missed: int = 0
    dropped: int = 0
    reason: str = ''

    @property
    def points(self) -> int:
        """How many points it has."""
        return sum(len(piece.places) for piece in self.pieces)

    @property
    def within(self) -> float:
        """How far beside the curve two runs differ at all of its points."""
        return max((float(piece.within.max()) for piece in self.pieces), default=0.0)

    @property
    def summary(self) -> dict[str, Any]:
        """What there is to say beside the curve itself, as --json writes it."""
        words = {name: getattr(self, name) for name in self._fields if name != 'pieces'}
        return {'points': self.points, 'within': self.within, **words}


def orbit_curves(border: Border, followed: Followed) -> list[Curve]:
    """Return the pieces of the curve in the units of the border's axes, shape (n, 2) each."""
    if not followed.pieces:
        return []
    x, y = Line(border.x), Line(border.y)
    return [np.column_stack([x(p.places[:, 0]), y(p.places[:, 1])]) for p in followed.pieces]


def orbit_csv(border: Border, followed: Followed) -> str:
    """Return the curve as the text of a csv file: piece, x, y, and what runs say of each point."""
    lines = [f'curve,{",".join(border.names)},off,within']
    curves = orbit_curves(border, followed)
    for number, (curve, piece) in enumerate(zip(curves, followed.pieces, strict=True)):
        numbers = np.column_stack([curve, piece.off, piece.within])
        lines += [','.join([str(number), *map(repr, row)]) for row in numbers.tolist()]
    return '\n'.join(lines) + '\n'
