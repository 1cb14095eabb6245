# SPDX-License-Identifier: Apache-2.0
"""Draws a sweep: the verdict and the residual over two parameters, or over one; and a border."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .style import BLACK, BLUE, GREY, ORANGE, style

if TYPE_CHECKING:
    import numpy.typing as npt

    Array = npt.NDArray[Any]

SIZE, LINE = (7.6, 2.6), (6.4, 2.9)
"""Of maps, and of lines: inches."""

FINE = 100
"""Cells beyond which a map is drawn as an image, in vector formats too."""

FINEST = 1000
"""Values of a parameter that a map shows at most: more than its panel has dots."""

KINDS = (
    ('rejected', BLUE),
    ('undecided', GREY),
    ('not rejected', ORANGE),
    (None, 'white'),
)
"""The verdicts in the order of their numbers in a map, and their colours."""


def draw_sweep(columns: Mapping[str, Array], names: Sequence[str], title: str) -> Any:
    """Return a matplotlib figure of a sweep over a grid of one or two parameters ``names``.

    ``columns`` are the table's, shape (n,) each. Two parameters give maps of the verdict, of the
    wrong events and of the residual; one gives the residual as a line. Words stand side by side.
    """
    return (_line if len(names) == 1 else _maps)(columns, names, title)


class _Ruler:
    """The values of one parameter along an axis: as they are, or words side by side."""

    def __init__(self, name: str, column: Array) -> None:
        self._name = name
        self._words: list[str] = []
        if column.dtype == object:
            texts = np.array([str(value) for value in column])
            found, self.places = np.unique(texts, return_inverse=True)
            self._words = found.tolist()
            self.values = np.arange(len(found), dtype=np.float64)
        else:
            self.values, self.places = np.unique(column, return_inverse=True)
        self._log = not self._words and in_equal_ratios(self.values)

    @property
    def edges(self) -> Array:
        """The edges of cells around the values, shape (n + 1,)."""
        at = np.log(self.values) if self._log else self.values
        if len(at) == 1:
            half = 0.5 * abs(at[0]) or 0.5
            return np.array([at[0] - half, at[0] + half])
        middle = 0.5 * (at[1:] + at[:-1])
        edges: Array = np.array([2.0 * at[0] - middle[0], *middle, 2.0 * at[-1] - middle[-1]])
        return np.exp(edges) if self._log else edges

    def thin(self) -> slice:
        """Keep at most :data:`FINEST` values; return which."""
        kept = slice(None, None, -(-len(self.values) // FINEST))
        self.values = self.values[kept]
        return kept

    def mark(self, axis: Any, across: bool) -> None:
        """Name an axis, and scale it."""
        (axis.set_xlabel if across else axis.set_ylabel)(self._name)
        if self._words:
            ticks = axis.set_xticks if across else axis.set_yticks
            ticks(self.values, self._words)
        elif self._log:
            set_log(axis, across, self.values)


def set_log(axis: Any, across: bool, values: Array) -> None:
    """Make an axis logarithmic, with numbers at its ticks also where it spans no decade."""
    from matplotlib.ticker import LogLocator, NullFormatter, NullLocator, ScalarFormatter

    (axis.set_xscale if across else axis.set_yscale)('log')
    if values[-1] / values[0] < 100.0:
        line = axis.xaxis if across else axis.yaxis
        line.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0)))
        line.set_major_formatter(ScalarFormatter())
        line.set_minor_locator(NullLocator())
        line.set_minor_formatter(NullFormatter())


def in_equal_ratios(values: Array) -> bool:
    """Say whether increasing values are so spaced that their axis is best logarithmic."""
    if len(values) < 3 or values[0] <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-6 * ratios[0] and ratios[0] > 1.0)


def _maps(columns: Mapping[str, Array], names: Sequence[str], title: str) -> Any:
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    x, y = (_Ruler(name, columns[name]) for name in names)
    kind = np.full((len(y.values), len(x.values)), len(KINDS) - 1)
    numbers = {word: i for i, (word, _) in enumerate(KINDS)}
    kind[y.places, x.places] = [numbers[word] for word in columns['verdict']]
    wrong, size = np.full(kind.shape, np.nan), np.full(kind.shape, np.nan)
    wrong[y.places, x.places] = _number(columns['spurious']) + _number(columns['missed'])
    size[y.places, x.places] = np.maximum(_number(columns['residual_max_abs']), 1e-12)
    shown = y.thin(), x.thin()
    kind, wrong, size = kind[shown], wrong[shown], size[shown]
    with style():
        figure = Figure(figsize=SIZE, layout='constrained')
        panels = figure.subplots(1, 3, sharex=True, sharey=True)
        mesh = {'rasterized': kind.size > FINE}
        colours = ListedColormap([colour for _, colour in KINDS])
        panels[0].pcolormesh(x.edges, y.edges, kind, cmap=colours, vmin=0, vmax=len(KINDS) - 1,
                             **mesh)  # fmt: skip
        for panel, values, norm in (
            (panels[1], wrong, _counts(wrong)),
            (panels[2], size, _log(size)),
        ):
            drawn = panel.pcolormesh(x.edges, y.edges, values, cmap='cividis', norm=norm, **mesh)
            figure.colorbar(drawn, ax=panel, pad=0.02)
        for panel, words in zip(
            panels, ('verdict', 'wrong events', 'largest |y - y_r|'), strict=True
        ):
            panel.set_title(words, loc='left')
            x.mark(panel, across=True)
        y.mark(panels[0], across=False)
        _key(figure, {word for word, _ in KINDS if word in set(columns['verdict'])})
        figure.suptitle(f'{title}: {len(columns["verdict"])} sets', x=0.01, ha='left', fontsize=8.0)
    return figure


def _number(column: Array) -> Array:
    return np.asarray(column, dtype=np.float64)


def _counts(values: Array) -> Any:
    """Return the scale of the colours of counts, from 0."""
    from matplotlib.colors import Normalize

    known = values[np.isfinite(values)]
    return Normalize(0.0, max(known.max(initial=0.0), 1.0))


def _log(values: Array) -> Any:
    """Return the logarithmic scale of the colours of sizes."""
    from matplotlib.colors import LogNorm

    known = values[np.isfinite(values)]
    low = max(known.min(initial=np.inf), 1e-6)
    return LogNorm(low, max(known.max(initial=0.0), 10.0 * low)) if len(known) else LogNorm(0.1, 1)


def _key(figure: Any, words: set[str | None]) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=colour, edgecolor=GREY, label=word or 'no verdict')
        for word, colour in KINDS
        if word in words
    ]
    figure.legend(handles=handles, loc='outside upper right', ncols=len(handles), handlelength=1.2)


def _line(columns: Mapping[str, Array], names: Sequence[str], title: str) -> Any:
    from matplotlib.figure import Figure

    ruler = _Ruler(names[0], columns[names[0]])
    order = np.argsort(ruler.places, kind='stable')
    x, size = ruler.values[ruler.places][order], _number(columns['residual_max_abs'])[order]
    verdicts = columns['verdict'][order]
    with style():
        figure = Figure(figsize=LINE, layout='constrained')
        axis = figure.subplots()
        axis.plot(x, size, color=GREY, linewidth=0.8, zorder=1)
        for word, colour in KINDS:
            chosen = verdicts == word
            if word is None and chosen.any():
                axis.plot(x[chosen], np.full(chosen.sum(), 0.02), '|', color=GREY, markersize=6.0,
                          label='no verdict', transform=axis.get_xaxis_transform())  # fmt: skip
            elif chosen.any():
                axis.plot(x[chosen], size[chosen], '.', color=colour, markersize=4.0, label=word)
        axis.set_ylabel('largest |y - y_r|')
        ruler.mark(axis, across=True)
        figure.legend(loc='outside upper right', ncols=4)
        axis.set_title(f'{title}: {len(x)} sets', loc='left')
    return figure


def draw_border(
    names: Sequence[str],
    curves: Sequence[Array],
    points: Mapping[bool, Sequence[tuple[float, float]]],
    title: str,
    followed: Sequence[Array] = (),
    logs: tuple[bool, bool] = (False, False),
) -> Any:
    """Return a matplotlib figure of a border and of the sets that were run to find it.

    ``curves`` on the grid, and the pieces ``followed`` as an orbit, have shape (n, 2), in the units
    of the axes ``names``; ``points`` are by whether they were rejected. ``logs``: which of the axes
    are logarithmic.
    """
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(4.4, 3.4), layout='constrained')
        axis = figure.subplots()
        for rejected, colour, word in ((True, BLUE, 'rejected'), (False, ORANGE, 'not rejected')):
            if points[rejected]:
                x, y = np.array(points[rejected]).T
                axis.plot(x, y, '.', color=colour, markersize=2.5, markeredgewidth=0.0, label=word,
                          rasterized=len(x) > FINE)  # fmt: skip
        both = bool(curves and followed)
        for some, colour, word in (
            (curves, GREY if followed else BLACK, 'on the grid'),
            (followed, BLACK, 'as an orbit'),
        ):
            for i, curve in enumerate(some):
                axis.plot(*curve.T, color=colour, linewidth=1.2,
                          label=word if both and not i else None)  # fmt: skip
        axis.set_xlabel(names[0])
        axis.set_ylabel(names[1])
        for across, of_axis in ((True, 0), (False, 1)):
            values = np.unique([point[of_axis] for some in points.values() for point in some])
            if logs[of_axis]:
                set_log(axis, across, values)
        axis.set_title(title, loc='left', color=BLACK)
        if any(points.values()):
            figure.legend(loc='outside upper right', ncols=4 if both else 2, labelcolor=BLACK)
    return figure
