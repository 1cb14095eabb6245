# SPDX-License-Identifier: Apache-2.0
"""Where an edge is looked for: a coarse scan, then bisection; all in whole multiples of a unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Sequence
from itertools import pairwise
from typing import TypeVar

T = TypeVar('T')
Result = TypeVar('Result')

LOSS_UNIT = 0.005
AHEAD = 4
"""Steps of a bisection for which everything is run that they may ask for."""

Found = tuple[int | None, int | None, tuple[int, ...]]
"""The last number that passes before the first failure (None: not even the first of the scan), the
first failure (None: there is none), and the numbers of the scan beyond it that pass again."""

FARTHEST_DELAY, FARTHEST_JITTER = 2.0, 20.0
"""Model time up to which is scanned."""

FARTHEST_PREDICTED = 100.0
"""The same for the delay of a loop that predicts; beyond FARTHEST_DELAY until it first fails."""

FINER = 10
"""Values of that scan in each factor of 10."""


def scan_of(kind: str, h: float) -> tuple[list[int], float]:
    """Return the values of the coarse scan as whole multiples of a unit, and that unit.

    Delay: one sample, and every 0.1 of model time; loss: every 0.05 to 0.95, and 0.99; jitter: one
    sample, and each about 1.4 times the one before. (With everything lost nothing disturbs the
    plant either; so 1 is left out.)
    """
    if kind == 'loss':
        return [*range(0, 200, 10), 198], LOSS_UNIT
    if kind == 'delay':
        tenths = range(round(10.0 * FARTHEST_DELAY) + 1)
        return sorted({round(0.1 * i / h) for i in tenths} | {1}), h
    most = max(round(FARTHEST_JITTER / h), 1)
    powers = range(2 * most.bit_length() + 1)
    return sorted({min(round(2.0 ** (i / 2)), most) for i in powers} | {0}), h


def search(passes: Callable[[int], bool], scan: Sequence[int]) -> Found:
    """Find the edge of ``passes`` over the increasing whole numbers of ``scan``.

    Between two numbers of ``scan``, ``passes`` is taken for monotone.
    """
    return finished(searching(passes, scan, list))


def searching(
    passes: Callable[[int], bool],
    scan: Sequence[int],
    asked: Callable[[Iterable[int]], T],
    ahead: int = AHEAD,
) -> Generator[T, None, Found]:
    """Search step by step: yield what is ``asked`` of numbers that will be tried next, then go on.

    In the bisection these are all that may be tried in so many steps ``ahead``.
    """
    yield asked(scan)
    if not passes(scan[0]):
        return None, scan[0], ()
    good = [True, *(passes(k) for k in scan[1:])]
    if all(good):
        return scan[-1], None, ()
    first = good.index(False)
    again = tuple(k for k, g in zip(scan[first:], good[first:], strict=True) if g)
    low, high = scan[first - 1], scan[first]
    while high - low > 1:
        yield asked(_middles(low, high, ahead))
        for _ in range(ahead):
            if high - low > 1:
                middle = (low + high) // 2
                low, high = (middle, high) if passes(middle) else (low, middle)
    return low, high, again


def finished(
    steps: Generator[T, None, Result], take: Callable[[T], object] = lambda asked: None
) -> Result:
    """Go through all steps of a search, handing each to ``take``; return what it finds."""
    while True:
        try:
            take(next(steps))
        except StopIteration as end:
            found: Result = end.value
            return found


def _middles(low: int, high: int, depth: int) -> set[int]:
    """Return what a bisection from ``low`` to ``high`` may ask for in its next ``depth`` steps."""
    if depth == 0 or high - low <= 1:
        return set()
    middle = (low + high) // 2
    return {middle} | _middles(low, middle, depth - 1) | _middles(middle, high, depth - 1)


def further(h: float) -> list[int]:
    """Return the delays beyond those of the scan up to FARTHEST_PREDICTED, in steps of ``h``."""
    count = round(FINER * math.log10(FARTHEST_PREDICTED / FARTHEST_DELAY))
    delays = [FARTHEST_DELAY * 10.0 ** (i / FINER) for i in range(1, count)]
    return sorted({round(delay / h) for delay in [*delays, FARTHEST_PREDICTED]})


def search_on(passes: Callable[[int], bool], scan: Sequence[int]) -> tuple[int, int | None]:
    """Find the edge beyond ``scan[0]``, which passes, looking no further than the first failure."""
    for low, high in pairwise(scan):
        if not passes(high):
            found, failure, _ = search(passes, [low, high])
            return low if found is None else found, failure
    return scan[-1], None
