# SPDX-License-Identifier: Apache-2.0
"""The figures as one table: the paper's, those that it argues in words, and those beyond it."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import EventregError
from ..scenario.hint import hint
from .figure import Case, Drawable, PaperFigure, compute_runs
from .figures_in_paper import SHOWN
from .figures_of_claims import ARGUED
from .figures_of_learning import IDENTIFIED, LEARNED, SWEPT
from .figures_of_links import DELAY_MARGIN, MESSAGES
from .gallery import Figure, gallery
from .identified import IdentifiedFigure, compute_identified
from .swept import SweptFigure, compute_swept

__all__ = [
    'FIGURES',
    'Case',
    'Drawable',
    'PaperFigure',
    'SweptFigure',
    'compute',
    'find',
    'gallery',
]

FIGURES: dict[str, Figure] = {
    figure.name: figure
    for figure in (*SHOWN, *ARGUED, *LEARNED, *SWEPT, IDENTIFIED, DELAY_MARGIN, MESSAGES)
}
"""All figures by name, in the order in which they are made."""


def compute(figure: Figure, overrides: Iterable[str] = ()) -> Drawable:
    """Return the data of a figure, its runs or sweeps each with ``overrides`` on top of its own.

    Raises EventregError when an override does not fit one of the scenarios.
    """
    if isinstance(figure, SweptFigure):
        return compute_swept(figure, overrides)
    if isinstance(figure, IdentifiedFigure):
        return compute_identified(figure, overrides)
    return compute_runs(figure, overrides)


def find(names: Iterable[str]) -> list[Figure]:
    """Return the figures of these names, or all if there is none. Raises EventregError."""
    names = list(names)
    if unknown := [name for name in names if name not in FIGURES]:
        raise EventregError(f'no figure {unknown[0]!r}{hint(unknown[0], FIGURES, "there are")}')
    return [figure for name, figure in FIGURES.items() if name in names or not names]
