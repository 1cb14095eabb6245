# SPDX-License-Identifier: Apache-2.0
"""Which sets are run: a grid, or a random sample; any stretch of them, in any order, alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from .axes import MOST_SETS, Array, Axis

SAMPLINGS = ('random', 'sobol', 'saltelli')

BLOCK = 1024
"""Sets whose random numbers are drawn together."""


@dataclass(frozen=True)
class Design:
    """The sets of a sweep: a value of each axis for each set.

    With ``sampling`` ``grid`` the last axis runs fastest; ``random`` and ``sobol`` are ``sets``
    draws (Sobol's sequence, scrambled); ``saltelli`` is the sample of Saltelli's indices over
    ``sets`` draws. Make one with :func:`design_of`.
    """

    axes: tuple[Axis, ...]
    sampling: str
    sets: int
    seed: int

    @property
    def count(self) -> int:
        """How many sets there are."""
        if self.sampling == 'grid':
            return math.prod(len(axis.values) for axis in self.axes)
        return self.sets * (len(self.axes) + 2 if self.sampling == 'saltelli' else 1)

    def columns(self, first: int, last: int) -> list[Array]:
        """Return the values of sets ``first`` to ``last`` - 1, one array per axis."""
        if self.sampling == 'grid':
            shape = tuple(len(axis.values) for axis in self.axes)
            places = np.unravel_index(np.arange(first, last), shape) if shape else ()
            return [axis.nth(at) for axis, at in zip(self.axes, places, strict=True)]
        u = self._uniform(first, last)
        return [axis.at(u[:, i]) for i, axis in enumerate(self.axes)]

    def _uniform(self, first: int, last: int) -> npt.NDArray[np.float64]:
        """Return numbers from 0 to 1, shape (last - first, axes)."""
        width = len(self.axes)
        if self.sampling == 'random':
            blocks = range(first // BLOCK, -(-last // BLOCK))
            u = np.concatenate(
                [np.random.default_rng((self.seed, b)).random((BLOCK, width)) for b in blocks]
            )
            return u[first - blocks[0] * BLOCK :][: last - first]
        if self.sampling == 'saltelli':
            return saltelli(width, self.sets, self.seed)[first:last]
        return _sobol(width, self.seed, first, last - first)


def _sobol(width: int, seed: int, first: int, count: int) -> npt.NDArray[np.float64]:
    from scipy.stats.qmc import Sobol

    engine = Sobol(width, scramble=True, seed=np.random.default_rng(seed))
    if first:
        engine.fast_forward(first)
    numbers: npt.NDArray[np.float64] = engine.random(count)
    return numbers


@lru_cache(maxsize=1)
def saltelli(width: int, sets: int, seed: int) -> npt.NDArray[np.float64]:
    """Return SALib's sample for first-order and total indices, shape (sets (width + 2), width).

    Raises EventregError when SALib is not installed.
    """
    try:
        from SALib.sample.sobol import sample
    except ImportError:
        raise EventregError(
            "--indices needs SALib; pip install '.[indices]' in the sources"
        ) from None
    numbers: npt.NDArray[np.float64] = sample(
        problem(width), sets, calc_second_order=False, seed=seed
    )
    return numbers


def problem(width: int) -> dict[str, object]:
    """Return what SALib calls a problem: so many parameters, from 0 to 1."""
    names = [str(i) for i in range(width)]
    return {'num_vars': width, 'names': names, 'bounds': [[0.0, 1.0]] * width}


def design_of(
    axes: Sequence[Axis], sets: int | None = None, seed: int = 0, sampling: str = 'grid'
) -> Design:
    """Return the design that is asked for.

    Raises EventregError where axes and sets do not fit, or for more than :data:`.axes.MOST_SETS`.
    """
    design = _design_of(axes, sets, seed, sampling)
    if design.count > MOST_SETS:
        raise EventregError(
            f'a sweep has at most {MOST_SETS} sets, got {design.count:.3g}; take fewer values'
        )
    return design


def _design_of(axes: Sequence[Axis], sets: int | None, seed: int, sampling: str) -> Design:
    if sets is None:
        for axis in axes:
            if axis.is_law:
                raise EventregError(
                    f'{axis.name} is drawn at random; say how often with --sets N, '
                    f'or write {axis.name}:=A..B/N for N values'
                )
        return Design(tuple(axes), 'grid', 0, seed)
    if not axes:
        raise EventregError('sets draw parameters, and none is varied; give -p NODE.PARAM:=A..B')
    sampling = 'random' if sampling == 'grid' else sampling
    if sampling not in SAMPLINGS:
        known = ', '.join(SAMPLINGS)
        raise EventregError(f'sampling must be one of {known}, got {sampling!r}')
    if sets < 1:
        raise EventregError(f'sets must be a whole number >= 1, got {sets}; draw one at least')
    if sampling in ('sobol', 'saltelli') and sets & (sets - 1):
        raise EventregError(f'this sample needs a power of 2, got --sets {sets}; take 1024, say')
    return Design(tuple(axes), sampling, sets, seed)
