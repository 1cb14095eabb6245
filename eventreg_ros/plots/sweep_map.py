# SPDX-License-Identifier: Apache-2.0
"""Draws a sweep: the verdict and the residual over two parameters, or over one; and a border."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import EventregError
from .style import BLACK, BLUE, GREY, ORANGE, style

if TYPE_CHECKING:
    import numpy.typing as npt

    Array = npt.NDArray[Any]

SIZE = (6.4, 2.9)
"""Inches."""

FINE = 100
"""Cells beyond which a map is drawn as an image, in vector formats too."""

KINDS = (
    ('rejected', BLUE),
    ('undecided', GREY),
    ('not rejected', ORANGE),
    (None, 'white'),
)
"""The verdicts in the order of their numbers in a map, and their colours."""


def draw_sweep(columns: Mapping[str, Array], names: Sequence[str], title: str) -> Any:
    """Return a matplotlib figure of a sweep over a grid of the parameters ``names``.

    ``columns`` are the table's, shape (n,) each. Two parameters give maps of the verdict and of the
    residual; one gives the residual as a line. Raises EventregError for more, or for words.
    """
    words = any(columns[name].dtype == object for name in names)
    if not 1 <= len(names) <= 2 or words:
        raise EventregError(
            f'a picture shows one or two parameters that are numbers, got {", ".join(names)}; '
            f'leave out --plot and --report, and draw the table'
        )
    return (_line if len(names) == 1 else _maps)(columns, names, title)


def _maps(columns: Mapping[str, Array], names: Sequence[str], title: str) -> Any:
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.figure import Figure

    x, y = (np.unique(columns[name]) for name in names)
    shape = len(y), len(x)
    places = np.searchsorted(y, columns[names[1]]), np.searchsorted(x, columns[names[0]])
    kind, size = np.full(shape, 3), np.full(shape, np.nan)
    numbers = {word: i for i, (word, _) in enumerate(KINDS)}
    kind[places] = [numbers[word] for word in columns['verdict']]
    size[places] = np.maximum(np.asarray(columns['residual_max_abs'], float), 1e-12)
    with style():
        figure = Figure(figsize=SIZE, layout='constrained')
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        colours = ListedColormap([colour for _, colour in KINDS])
        left.pcolormesh(x, y, kind, cmap=colours, vmin=0, vmax=3, shading='nearest',
                        rasterized=kind.size > FINE)  # fmt: skip
        drawn = right.pcolormesh(x, y, size, cmap='cividis', shading='nearest',
                                 norm=LogNorm(max(np.nanmin(size), 1e-6), np.nanmax(size)),
                                 rasterized=kind.size > FINE)  # fmt: skip
        figure.colorbar(drawn, ax=right, pad=0.02)
        left.set_title('verdict', loc='left')
        right.set_title('largest |y - y_r| after settling', loc='left')
        left.set_ylabel(names[1])
        for axis in (left, right):
            axis.set_xlabel(names[0])
            _scales(axis, x, y)
        _key(figure, {word for word, _ in KINDS if word in set(columns['verdict'])})
        figure.suptitle(f'{title}: {kind.size} sets', x=0.01, ha='left', fontsize=8.0)
    return figure


def _scales(axis: Any, x: Array, y: Array) -> None:
    """Draw a logarithmic axis where the values are in equal ratios."""
    for values, scale in ((x, axis.set_xscale), (y, axis.set_yscale)):
        if len(values) > 2 and values[0] > 0.0:
            ratios = values[1:] / values[:-1]
            if np.ptp(ratios) < 1e-6 * ratios[0]:
                scale('log')


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

    order = np.argsort(columns[names[0]], kind='stable')
    x, size = columns[names[0]][order], np.asarray(columns['residual_max_abs'], float)[order]
    verdicts = columns['verdict'][order]
    with style():
        figure = Figure(figsize=SIZE, layout='constrained')
        axis = figure.subplots()
        axis.plot(x, size, color=GREY, linewidth=0.8, zorder=1)
        for word, colour in KINDS:
            chosen = verdicts == word
            if word is not None and chosen.any():
                axis.plot(x[chosen], size[chosen], '.', color=colour, markersize=4.0, label=word)
        axis.set_xlabel(names[0])
        axis.set_ylabel('largest |y - y_r|')
        axis.legend()
        axis.set_title(f'{title}: {len(x)} sets', loc='left')
    return figure


def draw_border(
    names: Sequence[str],
    curves: Sequence[Array],
    points: Mapping[bool, Sequence[tuple[float, float]]],
    title: str,
    followed: Sequence[Array] = (),
) -> Any:
    """Return a matplotlib figure of a border and of the sets that were run to find it.

    ``curves`` on the grid, and the pieces ``followed`` as an orbit, have shape (n, 2), in the units
    of the axes ``names``; ``points`` are by whether they were rejected.
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
        axis.set_title(title, loc='left', color=BLACK)
        if any(points.values()):
            figure.legend(loc='outside upper right', ncols=4 if both else 2, labelcolor=BLACK)
    return figure
