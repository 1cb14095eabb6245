"""The paper's figures: those that it shows and those that it argues in words, as one table."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import EventregError
from .figure import Case, Drawable, PaperFigure, compute
from .figures_in_paper import SHOWN
from .figures_of_claims import ARGUED
from .gallery import gallery

__all__ = ['FIGURES', 'Case', 'Drawable', 'PaperFigure', 'compute', 'find', 'gallery']

FIGURES = {figure.name: figure for figure in (*SHOWN, *ARGUED)}
"""All figures by name, in the order in which they are made."""


def find(names: Iterable[str]) -> list[PaperFigure]:
    """Return the figures of these names, or all if there is none. Raises EventregError."""
    names = list(names)
    if unknown := [name for name in names if name not in FIGURES]:
        raise EventregError(f'no figure {unknown[0]!r}; name one of {", ".join(FIGURES)}')
    return [figure for name, figure in FIGURES.items() if name in names or not names]
