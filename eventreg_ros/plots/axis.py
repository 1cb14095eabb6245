# SPDX-License-Identifier: Apache-2.0
"""Axes: what range is shown, where the ticks are, and what they are called."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from .decimate import LARGEST, Array

FAR = 4.0
"""A sample is off the scale when it is so many times further out than all but one in a thousand."""

USUAL = (0.1, 50.0, 99.9)
MANY = 100_000
"""Samples enough for percentiles."""

PAD = 0.05
"""Part of the range that is left free above and below."""


class Axis(NamedTuple):
    """What a panel shows: values from ``low`` to ``high``, or ten to the power of them."""

    low: float
    high: float
    logarithmic: bool = False

    def place(self, x: Array) -> Array:
        """Return where values are, from 0 at ``low`` to 1 at ``high``; shape (n,) as ``x``."""
        return (x - self.low) / (self.high - self.low)

    def ticks(self, most: int) -> list[tuple[float, str]]:
        """Return at most ``most`` round values with their labels."""
        if not self.logarithmic:
            return ticks(self.low, self.high, most)
        step = max(1, math.ceil((self.high - self.low) / most))
        exponents = range(math.ceil(self.low), math.floor(self.high) + 1)
        return [(float(n), power(n)) for n in exponents if n % step == 0]


def around(samples: Iterable[Array], levels: Sequence[float] = ()) -> Axis:
    """Return the axis that shows ``levels`` and all ``samples``, arrays of shape (n,).

    But for those that are far off all others: they would squeeze the rest.
    """
    low, high = (min(levels), max(levels)) if levels else (math.inf, -math.inf)
    for each in samples:
        x = each[np.abs(each) < LARGEST]
        if len(x):
            bottom, top = _usual(x)
            x = x[(x >= bottom) & (x <= top)]
            low, high = min(low, float(x.min())), max(high, float(x.max()))
    if low > high:
        low, high = -1.0, 1.0
    pad = PAD * (high - low) or 0.1 * abs(high) or 1.0
    return Axis(low - pad, high + pad)


def _usual(x: Array) -> tuple[float, float]:
    """Return the range beyond which samples are far off; all of it where they hardly differ."""
    bottom, middle, top = np.percentile(x[:: 1 + len(x) // MANY], USUAL).tolist()
    if not bottom < middle < top:
        return float(x.min()), float(x.max())
    return middle - FAR * (middle - bottom), middle + FAR * (top - middle)


def decades(x: Array, floor: float) -> tuple[Axis, Array]:
    """Return a logarithmic axis for magnitudes ``x`` >= 0, and their logarithms, shape (n,).

    The axis leaves out the lowest 3 %, where a signal passes through 0, and what is more than ten
    times as large as all but one in a thousand.
    """
    logs = np.log10(np.maximum(x, floor))
    known = logs[np.isfinite(logs)]
    if not len(known):
        return Axis(-1.0, 1.0, True), logs
    low, usual = np.percentile(known, (3.0, 99.9)).tolist()
    high = min(float(known.max()), usual + 1.0)
    return Axis(low - 0.5, max(high + 0.5, low + 1.0), True), logs


def ticks(low: float, high: float, most: int) -> list[tuple[float, str]]:
    """Return at most about ``most`` round values from ``low`` to ``high``, with their labels."""
    step = round_step((high - low) / most)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [(n * step, label(n * step, step)) for n in range(first, last + 1)]


def round_step(least: float) -> float:
    """Return the smallest of 1, 2, 5, 10, 20, ... and their tenths that is >= ``least`` > 0."""
    size: float = 10.0 ** math.floor(math.log10(least))
    return next(m * size for m in (1, 2, 5, 10) if m * size >= least * (1.0 - 1e-9))


def label(value: float, step: float) -> str:
    """Return a multiple of ``step`` in as many digits as it needs, with a real minus sign."""
    if abs(value) >= 1e5 or 0.0 < abs(value) < 1e-3:
        digits, exponent = f'{value:.5e}'.split('e')
        text = f'{float(digits):g}e{int(exponent)}'
    else:
        text = f'{value:.{max(0, -math.floor(math.log10(step) + 1e-9))}f}' if value else '0'
    return text.replace('-', '\u2212')


def power(n: int) -> str:
    """Return ten to the power of ``n`` in words of numbers: 0.1, 1, 10, and with exponents."""
    if -3 <= n <= 3:
        return f'{10.0**n:g}'
    return '10' + str(n).translate(str.maketrans('-0123456789', '\u207b⁰¹²³⁴⁵⁶⁷⁸⁹'))
