# SPDX-License-Identifier: Apache-2.0
"""Where things stand in a chart: parts of its span, units of its curves, and single marks."""

from __future__ import annotations

import numpy as np

from ..analysis.signal import Span
from .decimate import Array

ACROSS = 100_000
"""The width of a chart in the units of its curves."""

FINE = 10
"""Units of a curve's height in a pixel."""

GLYPHS = {
    'spurious': 'M-4.5-4.5L4.5 4.5M-4.5 4.5L4.5-4.5',
    'missed': 'M-5-4.5L5-4.5L0 5Z',
    'above': 'M0 1L4 8L-4 8Z',
    'below': 'M0-1L4-8L-4-8Z',
}
"""Marks by what they stand for; each has its own shape, for readers without its colour."""


def part(t: float, span: Span) -> float:
    """Return where ``t`` is in ``span``, from 0 to 1."""
    return (t - span[0]) / ((span[1] - span[0]) or 1.0)


def glyph(kind: str, path: str, a: float, y: float, more: str = '') -> str:
    """Return a mark at the part ``a`` of the span and at ``y`` pixels from the top."""
    return (
        f'<svg class="glyph" x="{a:.4%}" y="{y:.1f}" data-a="{a:.6f}">'
        f'<path class="{kind}" d="{path}"/>{more}</svg>'
    )


def within(t: Array, x: Array, span: Span) -> tuple[Array, Array]:
    """Return a signal from the last sample before ``span`` to the first one after it."""
    first = max(int(np.searchsorted(t, span[0], 'left')) - 1, 0)
    last = int(np.searchsorted(t, span[1], 'right')) + 1
    return t[first:last], x[first:last]


def short(name: str, most: int) -> str:
    """Return a name, cut in its middle to ``most`` characters."""
    half = (most - 1) // 2
    return name if len(name) <= most else f'{name[:half]}\u2026{name[-half:]}'
