# SPDX-License-Identifier: Apache-2.0
"""Long recorded signals as lines that can be drawn: broken where samples lack, and thinned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

PARTS = 1500
"""A line is drawn with at most four points in each of so many parts."""

GAP = 10.0
"""A line is broken where nothing came for so many median periods."""


LARGEST = 1e300
"""Larger values cannot be drawn: the span of an axis would overflow."""


def broken(t: Array, x: Array) -> tuple[Array, Array]:
    """Return the signal, both arrays of shape (n,), with NaN in gaps and for infinite values."""
    x = np.where(np.abs(x) < LARGEST, x, np.nan)
    periods = np.diff(t)
    if len(periods) < 2:
        return t, x
    gaps = np.flatnonzero(periods > GAP * np.median(periods)) + 1
    return np.insert(t, gaps, t[gaps]), np.insert(x, gaps, np.nan)


def min_max_decimate(t: Array, x: Array, parts: int = PARTS) -> tuple[Array, Array]:
    """Return the first, lowest and highest point of each of ``parts`` equal parts of the signal.

    Drawn no wider than ``parts`` pixels, the line looks the same. A part's first NaN stays too.
    """
    size = len(t) // parts
    if size < 5:
        return t, x
    rows = x[: len(t) // size * size].reshape(-1, size)
    nan = np.isnan(rows)
    inside = np.stack(
        [
            np.zeros(len(rows), dtype=np.intp),
            np.where(nan, np.inf, rows).argmin(axis=1),
            np.where(nan, -np.inf, rows).argmax(axis=1),
            nan.argmax(axis=1),
        ]
    )
    kept = np.unique(inside + size * np.arange(len(rows)))
    kept = np.append(kept, np.arange(rows.size, len(t)))
    return t[kept], x[kept]
