# SPDX-License-Identifier: Apache-2.0
"""A recorded signal, cleaned, with what is known of how it came about."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ...errors import EventregError
from .layout import Array, Layout, Plant
from .model import Forward

LONGEST = 1000.0
"""Model time that is fitted, at most: enough for any precision, little enough for a second."""

MOST = 40_000
"""Samples that are fitted, at most; of more, every second, third, ... is."""

FEWEST = 20
"""Samples that are fitted, at least."""

TRANSIENT, TRANSIENT_PART = 60.0, 0.2
"""Model time that generators take to go into antiphase, and the most of it that is left out."""

THIN = 0.5
"""What else drives the plant may have no wider gaps than this (model time), or five intervals."""


@dataclass(frozen=True)
class Recorded:
    """A recorded signal and what is known of how it came about.

    ``t``, from 0 in model time, and ``x`` have shape (n,), as has ``given``, what else drives the
    plant (v - u). Without a plant the signal is a generator's own. ``affine``: a sensor's gain and
    offset are unknown.
    """

    signal: str
    t: Array
    x: Array
    given: Array | None = None
    plant: Plant | None = None
    plant_known: bool = True
    affine: bool = False

    @property
    def layout(self) -> Layout:
        """What is unknown, with one generator in antiphase."""
        return Layout(plant=self.plant, plant_known=self.plant_known, affine=self.affine)

    def until(self, end: float) -> Recorded:
        """Return the first part, up to ``end``."""
        return self.part(slice(0, int(np.searchsorted(self.t, end, side='right'))))

    def beginning(self, end: float, least: int) -> Recorded:
        """Return the samples up to ``end``, and no fewer than ``least`` if there are as many."""
        return self.until(max(end, float(self.t[min(least, len(self.t)) - 1])))

    def settled(self) -> Recorded:
        """Return it without its beginning, in which a generator may be out of antiphase."""
        start = min(TRANSIENT, TRANSIENT_PART * float(self.t[-1]))
        return self.part(slice(int(np.searchsorted(self.t, start)), None))

    def part(self, where: slice | npt.NDArray[np.int64]) -> Recorded:
        """Return a part of the samples; its time begins at 0 again."""
        given = None if self.given is None else self.given[where]
        return replace(self, t=self.t[where] - self.t[where][0], x=self.x[where], given=given)

    def forward(
        self, layout: Layout, h: float, straight: bool = False, late: float = 0.0
    ) -> Forward:
        """Return what predicts ``x``, integrated in steps of ``h`` (model time).

        What is given is interpolated smoothly between its samples, or by ``straight`` lines; it
        acts on the plant ``late`` by so much model time.
        """
        if self.given is None:
            return Forward(layout, self.t, h)
        from scipy.interpolate import PchipInterpolator

        distinct = np.append(np.diff(self.t) > 0.0, True)
        t, given = self.t[distinct], self.given[distinct]
        curve = PchipInterpolator(t, given)

        def at(times: Array) -> Array:
            times = np.clip(times - late, t[0], t[-1])
            return np.asarray(np.interp(times, t, given) if straight else curve(times))

        return Forward(layout, self.t, h, at)


def cleaned(
    signal: str,
    t: npt.ArrayLike,
    x: npt.ArrayLike,
    u: npt.ArrayLike | None = None,
    v: npt.ArrayLike | None = None,
) -> Recorded:
    """Return the finite samples, as many as are fitted, from t = 0 on.

    Where u or v drive the plant, only the longest part without a gap in it. Raises EventregError
    where the arrays do not fit together, or little is left.
    """
    rows = [np.asarray(a, dtype=np.float64) for a in (t, x, v, u) if a is not None]
    if len({a.shape for a in rows}) > 1 or rows[0].ndim != 1:
        raise EventregError(
            f'{signal}: times and samples must be arrays of one length, got the shapes '
            f'{", ".join(str(a.shape) for a in rows)}'
        )
    driven = u is not None or v is not None
    if driven:
        signs = [1.0] * (v is not None) + [-1.0] * (u is not None)
        rows[2:] = [sum((s * a for s, a in zip(signs, rows[2:], strict=True)), np.zeros(()))]
    table = np.stack(rows)
    table = table[:, np.isfinite(table).all(axis=0)]
    if (np.diff(table[0]) < 0.0).any():
        at = table[0][np.argmax(np.diff(table[0]) < 0.0)]
        raise EventregError(f'{signal}: times must not decrease, but do after {at:g}; sort them')
    if driven:
        table = table[:, _longest(table[0])]
    if table.shape[1] < FEWEST:
        raise EventregError(
            f'{signal} has {table.shape[1]} finite samples of {len(rows[0])}; at least {FEWEST} '
            f'are needed: record longer'
        )
    found = Recorded(signal, table[0], table[1], table[2] if driven else None)
    found = found.part(slice(None)).until(LONGEST)
    return found.part(slice(None, None, -(-len(found.t) // MOST)))


def _longest(t: Array) -> slice:
    """Return the longest part of the times without a gap."""
    intervals = np.diff(t)
    if not len(intervals):
        return slice(None)
    gaps = np.flatnonzero(intervals > max(THIN, 5.0 * float(np.median(intervals)))) + 1
    ends = [0, *gaps.tolist(), len(t)]
    first, last = max(pairwise(ends), key=lambda part: t[part[1] - 1] - t[part[0]])
    return slice(first, last)
