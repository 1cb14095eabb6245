# SPDX-License-Identifier: Apache-2.0
"""The border between rejected and not, over two parameters, followed on a fine grid.

A coarse grid is run first. Between known points of a row or a column that differ, it is bisected
down to neighbours on the fine grid that differ; from there the border is followed from one fine
cell to the next, until it closes or leaves the grid. What is smaller than a coarse cell and touches
none of its points can be missed.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..analysis.rejection import REJECTED, UNDECIDED
from ..errors import EventregError
from .axes import Array, Axis
from .evaluations import Evaluations
from .outcome import VERDICTS
from .plan import Plan
from .sets import Sets
from .store import Store
from .sweep import Progress, pool_here

COARSE = 8
"""Fine steps in a step of the coarse grid."""

Point = tuple[int, int]
Curve = npt.NDArray[np.float64]
Evaluate = Callable[[Sequence[Point]], Sequence[bool]]
Grid = npt.NDArray[np.int8]
Flags = npt.NDArray[np.bool_]

UNKNOWN = -1
"""What a place of the fine grid is that was not run; 1 is rejected, 0 is not."""


@dataclass(frozen=True)
class Border:
    """The border over the axes ``names`` (x, y), found with ``runs`` of ``grid`` runs.

    ``places`` are its pieces, each of shape (n, 2), in steps of the grid, half a step from points
    that differ. ``known`` maps the places in the grid that were run to whether they were rejected;
    ``x`` and ``y`` are the values of the grid. Of the sets that count as not rejected ``undecided``
    were so, and ``bad`` have no verdict: they were refused or diverged, the first because of
    ``why``.
    """

    names: tuple[str, str]
    x: tuple[float, ...]
    y: tuple[float, ...]
    known: dict[Point, bool]
    places: list[Curve]
    undecided: int = 0
    bad: int = 0
    why: str = ''

    @property
    def curves(self) -> list[Curve]:
        """The pieces in the units of the axes."""
        return [_placed(places, self.x, self.y) for places in self.places]

    @property
    def turned(self) -> Border:
        """The same with x for y."""
        known = {(j, i): rejected for (i, j), rejected in self.known.items()}
        places = [each[:, ::-1] for each in self.places]
        return replace(self, names=self.names[::-1], x=self.y, y=self.x, known=known, places=places)

    @property
    def points(self) -> dict[bool, list[tuple[float, float]]]:
        """The places that were run, by whether they were rejected."""
        found: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
        for (i, j), rejected in self.known.items():
            found[rejected].append((self.x[i], self.y[j]))
        return found

    @property
    def runs(self) -> int:
        """How many sets were run."""
        return len(self.known)

    @property
    def grid(self) -> int:
        """How many sets the whole grid has."""
        return len(self.x) * len(self.y)


def find_border(
    plan: Plan,
    names: Sequence[str],
    progress: Progress = lambda done, count: None,
    store: Store | None = None,
) -> Border:
    """Find the border over the two axes of a plan, both ranges with a number of values.

    ``names`` are theirs, x first; ``store`` keeps what is run. Raises EventregError when the plan
    has others.
    """
    axes = plan.axes
    _need_both(axes, names)
    known, words, bad = dict[Point, bool](), Counter[str](), list[list[Array]]()
    runs = Evaluations(plan, store, lambda done: progress(done, 0))
    with pool_here() as pool:

        def evaluate(points: Sequence[Point]) -> Sequence[bool]:
            places = np.array(points).T
            columns = [axis.nth(at) for axis, at in zip(axes, places, strict=True)]
            rows = runs.run(columns, pool)
            found = [VERDICTS[verdict] for verdict in rows['verdict'].tolist()]
            words.update(found)
            if '' in found and not bad:
                at = found.index('')
                bad.append([column[at : at + 1] for column in columns])
            return [verdict == REJECTED for verdict in found]

        shape = len(axes[0].values), len(axes[1].values)
        cells = refine(evaluate, shape, known)
    x, y = (tuple(map(float, axis.values)) for axis in axes)
    places = [np.array(curve) for curve in joined(cells, known)]
    why = Sets(plan).run(bad[0]).reasons.get(0, '') if bad else ''
    border = Border(
        (axes[0].name, axes[1].name), x, y, known, places, words[UNDECIDED], words[''], why
    )
    return border if names[0] == axes[0].name else border.turned


def _need_both(axes: Sequence[Axis], names: Sequence[str]) -> None:
    """Raise EventregError unless the axes are two ranges of numbers, of these names."""
    if (
        len(axes) != 2
        or sorted(names) != sorted(axis.name for axis in axes)
        or any(len(axis.values) < 2 or not isinstance(axis.values[0], float) for axis in axes)
    ):
        raise EventregError(
            f'--border X,Y takes the two ranges A..B/N that are given and no other; got '
            f'{",".join(names)} and the ranges {", ".join(axis.name for axis in axes) or "none"}'
        )


def refine(evaluate: Evaluate, shape: tuple[int, int], known: dict[Point, bool]) -> list[Point]:
    """Fill ``known`` along the border of a grid of that shape; return the cells on it.

    A cell is named by its lowest corner, and on the border where its corners differ.
    """
    grid = np.full(shape, UNKNOWN, dtype=np.int8)
    lines = [sorted({*range(0, size - 1, COARSE), size - 1}) for size in shape]
    points = [(i, j) for i in lines[0] for j in lines[1]]
    while points:
        grid[tuple(np.array(points).T)] = evaluate(points)
        points = _along(grid) or _between(grid, COARSE) or _between(grid, max(shape))
    places = np.argwhere(grid != UNKNOWN).tolist()
    known.update({(i, j): bool(grid[i, j]) for i, j in places})
    across, up = _edges(grid), _edges(grid.T).T
    mixed = across[:, :-1] | across[:, 1:] | up[:-1] | up[1:]
    return [(i, j) for i, j in np.argwhere(mixed).tolist()]


def _edges(grid: Grid) -> Flags:
    """Return where a point and the next one along the first axis differ, as far as known."""
    known = grid != UNKNOWN
    edges: Flags = known[:-1] & known[1:] & (grid[:-1] != grid[1:])
    return edges


def _along(grid: Grid) -> list[Point]:
    """Return the unknown corners of all cells that have an edge whose ends differ."""
    wanted = np.zeros(grid.shape, dtype=bool)
    for edges, of in ((_edges(grid), wanted), (_edges(grid.T), wanted.T)):
        for beside, edge in ((of[:, 1:], edges[:, :-1]), (of[:, :-1], edges[:, 1:])):
            beside[:-1] |= edge
            beside[1:] |= edge
    return [(i, j) for i, j in np.argwhere(wanted & (grid == UNKNOWN)).tolist()]


def _between(grid: Grid, longest: int) -> list[Point]:
    """Return the points midway in the gaps of rows and columns, of at most ``longest`` steps."""
    rows = {(i, j) for i, j in _gaps(grid, longest)}
    return sorted(rows | {(i, j) for j, i in _gaps(grid.T, longest)})


def _gaps(grid: Grid, longest: int) -> list[list[int]]:
    """Return the places midway between known ones of a row that differ, and none is between."""
    i, j = np.nonzero(grid != UNKNOWN)
    wide = np.diff(j)
    gap = (i[:-1] == i[1:]) & (wide > 1) & (wide <= longest)
    gap &= grid[i[:-1], j[:-1]] != grid[i[1:], j[1:]]
    middle = (j[:-1] + j[1:]) // 2
    return np.column_stack([i[:-1], middle])[gap].tolist()  # type: ignore[no-any-return]


def joined(cells: Sequence[Point], known: dict[Point, bool]) -> list[list[tuple[float, float]]]:
    """Return the border through cells as curves of points half way between grid points."""
    neighbours: dict[tuple[float, float], list[tuple[float, float]]] = defaultdict(list)
    for i, j in cells:
        around = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1), (i, j)]
        crossings = [
            ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
            for a, b in pairwise(around)
            if known[a] != known[b]
        ]
        for a, b in zip(crossings[::2], crossings[1::2], strict=True):
            neighbours[a].append(b)
            neighbours[b].append(a)
    curves = []
    ends = [point for point, others in sorted(neighbours.items()) if len(others) == 1]
    for start in [*ends, *sorted(neighbours)]:
        curve = [start]
        while neighbours[curve[-1]]:
            after = neighbours[curve[-1]].pop()
            neighbours[after].remove(curve[-1])
            curve.append(after)
        if len(curve) > 1:
            curves.append(curve)
    return curves


def _placed(places: Curve, x: Sequence[float], y: Sequence[float]) -> Curve:
    return np.column_stack(
        [np.interp(places[:, i], np.arange(len(values)), values) for i, values in enumerate((x, y))]
    )


def border_csv(border: Border) -> str:
    """Return the border as the text of a csv file: curve number, x, y."""
    lines = [f'curve,{border.names[0]},{border.names[1]}']
    for number, curve in enumerate(border.curves):
        lines += [f'{number},{a!r},{b!r}' for a, b in curve.tolist()]
    return '\n'.join(lines) + '\n'
