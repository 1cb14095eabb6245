# SPDX-License-Identifier: Apache-2.0
"""Signals over model time: sums, differences, sizes, and the order in which they are shown."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..models.model import output_beside
from ..models.roles import SIGNALS

Array = npt.NDArray[np.float64]


class Signal(NamedTuple):
    """A signal, both of shape (n,): ``t`` in model time, not decreasing, and the values ``x``."""

    t: Array
    x: Array


Signals = Mapping[str, Signal]

NOTHING = Signal(np.empty(0), np.empty(0))


class Size(NamedTuple):
    """How large a signal is: its largest magnitude and its rms; both None where there is none."""

    max_abs: float | None
    rms: float | None


Span = tuple[float, float]
"""From when to when, in model time, both included."""


def ordered(signals: Iterable[str]) -> list[str]:
    """Return the names of ``signals``: the paper's in its order, then the others by name.

    A name with a suffix (w_2) comes right after the one without, and after all outputs what is
    published beside one (u/tau).
    """
    places = {signal: i for i, signal in enumerate(SIGNALS)}
    known = frozenset(signals)

    def key(name: str) -> tuple[bool, int, str]:
        output = output_beside(name, known)
        return output is not None, places.get(family(output or name), len(SIGNALS)), name

    return sorted(known, key=key)


def with_events(signals: Iterable[str]) -> list[str]:
    """Return the names of the signals that may have events: all but those beside an output."""
    known = frozenset(signals)
    return [name for name in ordered(known) if output_beside(name, known) is None]


def family(name: str) -> str:
    """Return the longest of the paper's names of which ``name`` is; of none: ``name`` itself."""
    return max((s for s in SIGNALS if is_of(s, name)), key=len, default=name)


def is_of(signal: str, name: str) -> bool:
    """Say whether ``name`` is ``signal``, or that with a suffix: w_2 is of w."""
    return name == signal or name.startswith(f'{signal}_')


def total(signals: Signals, names: Iterable[str]) -> Signal:
    """Return the sum of the named signals at the times of the first; n = 0 when one is missing.

    The others run straight between their samples; where one of them is not known, nor is the sum.
    """
    found = [_finite(signals.get(name, NOTHING)) for name in names]
    if not found:
        return NOTHING
    first, *others = found
    for other in others:
        first = _combined(first, other, 1.0)
    return first


def difference(a: Signal, b: Signal) -> Signal:
    """Return a - b at the times of a that lie within those of b, between which b is a line."""
    return _combined(a, _finite(b), -1.0)


def _combined(a: Signal, b: Signal, sign: float) -> Signal:
    if len(b.t) == 0:
        return NOTHING
    inside = (a.t >= b.t[0]) & (a.t <= b.t[-1])
    with np.errstate(over='ignore'):
        t = a.t[inside]
        return Signal(t, a.x[inside] + sign * np.interp(t, b.t, b.x))


def _finite(signal: Signal) -> Signal:
    t, x = signal
    keep = np.isfinite(x)
    return Signal(t, x) if keep.all() else Signal(t[keep], x[keep])


def size(signal: Signal, span: Span) -> Size:
    """Return the size of ``signal`` within ``span``; each interval weighs its length.

    The square runs straight from sample to sample (trapezoids).
    """
    inside = (signal.t >= span[0]) & (signal.t <= span[1])
    t, x = signal.t[inside], signal.x[inside]
    largest = float(np.abs(x).max(initial=0.0))
    if len(t) == 0 or not math.isfinite(largest):
        return Size(None, None)
    square = (x / (largest or 1.0)) ** 2  # at most 1: it must not overflow
    length = np.diff(t)
    if length.sum() > 0.0:
        square = 0.5 * (square[1:] + square[:-1])
        mean = float(np.average(square, weights=length))
    else:
        mean = float(np.mean(square))
    return Size(largest, largest * math.sqrt(mean))


def together(sizes: Collection[Size]) -> Size:
    """Return the size of several signals: the largest magnitude, the root mean square of the rms.

    Those that are not known are left out.
    """
    known = [(s.max_abs, s.rms) for s in sizes if s.max_abs is not None and s.rms is not None]
    if not known:
        return Size(None, None)
    largest = max(most for most, _ in known)
    scale = max(rms for _, rms in known) or 1.0  # the squares must not overflow
    mean = sum((rms / scale) ** 2 for _, rms in known) / len(known)
    return Size(largest, known[0][1] if len(known) == 1 else scale * math.sqrt(mean))
