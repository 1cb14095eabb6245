"""The verdict on a run, recorded or simulated: one report, in the shape that the contract gives."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from ..models.model import output_beside
from ..models.roles import SIGNALS
from .criteria import RESET, SETTLE, THRESHOLD, WINDOW
from .events import detect
from .rejection import reject

Array = npt.NDArray[np.float64]
Signals = Mapping[str, tuple[Array, Array]]
Report = dict[str, Any]

EXIT_CODES = {'rejected': 0, 'not rejected': 1, 'undecided': 3}
"""What run, simulate and analyze exit with, by verdict."""


def judge(
    signals: Signals,
    *,
    scenario: str,
    time_scale: float,
    threshold: float = THRESHOLD,
    reset: float = RESET,
    settle: float = SETTLE,
    window: float = WINDOW,
) -> Report:
    """Return the report on ``signals``, ready for JSON.

    ``signals`` maps each name to (t, values), both of shape (n,), t in model time, not decreasing,
    not necessarily uniform. Raises EventregError when there is no y to judge.
    """
    if 'y' not in signals or len(signals['y'][0]) == 0:
        found = ', '.join(name for name in signals if len(signals[name][0])) or 'none'
        raise EventregError(
            f"no samples of y, the plant's output, to judge (signals found: {found}); "
            'record or remap it'
        )
    events = {
        name: [] if output_beside(name, signals) else detect(t, x, threshold, reset)
        for name, (t, x) in signals.items()
    }
    rejection = reject(events.get('w', []), events['y'], events.get('y_r', []), settle, window)
    return {
        'scenario': scenario,
        'time_scale': time_scale,
        'duration': max(float(t[-1]) for t, _ in signals.values() if len(t)),
        'settle': settle,
        'verdict': rejection.verdict,
        'rejection': {**vars(rejection), 'ratio': rejection.ratio},
        'residual': _size(*residual(signals), settle),
        'synchronisation': _size(*synchronisation(signals), settle),
        'signals': {name: _summary(*signals[name], events[name]) for name in ordered(signals)},
    }


def ordered(signals: Collection[str]) -> list[str]:
    """Return the names of ``signals``: the paper's in its order, then the others by name."""
    known = [name for name in SIGNALS if name in signals]
    return known + sorted(set(signals) - set(known))


def _summary(t: Array, values: Array, events: list[float]) -> dict[str, Any]:
    finite = values[np.isfinite(values)]
    return {
        'samples': len(t),
        'min': float(finite.min()) if len(finite) else None,
        'max': float(finite.max()) if len(finite) else None,
        'events': events,
    }


def residual(signals: Signals) -> tuple[Array, Array]:
    """Return (t, y - y_r), both of shape (n,), at the times of y; y itself without a reference."""
    y, y_r = _finite(signals, 'y'), _finite(signals, 'y_r')
    return _difference(y, y_r) if len(y_r[0]) else y


def synchronisation(signals: Signals) -> tuple[Array, Array]:
    """Return (t, w - u), both of shape (n,), at the times of w; n = 0 when either is missing."""
    return _difference(_finite(signals, 'w'), _finite(signals, 'u'))


def _finite(signals: Signals, name: str) -> tuple[Array, Array]:
    t, x = signals.get(name, (np.empty(0), np.empty(0)))
    keep = np.isfinite(x)
    return t[keep], x[keep]


def _difference(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return a - b at the times of a that lie within those of b, between which b is a line."""
    t, x = a
    if len(b[0]) == 0:
        return t[:0], x[:0]
    inside = (t >= b[0][0]) & (t <= b[0][-1])
    with np.errstate(over='ignore'):
        return t[inside], x[inside] - np.interp(t[inside], *b)


def _size(t: Array, x: Array, settle: float) -> dict[str, float | None]:
    """Return the largest magnitude and the rms after ``settle``; each interval weighs its length.

    The square runs straight from sample to sample (trapezoids).
    """
    t, x = t[t >= settle], x[t >= settle]
    largest = float(np.abs(x).max(initial=0.0))
    if len(t) == 0 or not math.isfinite(largest):
        return {'max_abs': None, 'rms': None}
    square = (x / (largest or 1.0)) ** 2  # at most 1: it must not overflow
    length = np.diff(t)
    if length.sum() > 0.0:
        square = 0.5 * (square[1:] + square[:-1])
        mean = float(np.average(square, weights=length))
    else:
        mean = float(np.mean(square))
    return {'max_abs': largest, 'rms': largest * math.sqrt(mean)}


def table(report: Report) -> str:
    """Return the report as a short plain table that ends with the verdict."""
    settle = report['settle']
    lines = [
        f'{report["scenario"]}: {report["duration"]:.1f} model time units, '
        f'counted after {settle:g}',
        f'{"signal":>8} {"samples":>8} {"min":>9} {"max":>9} {"events":>7} {"after":>6}',
    ]
    for name, s in report['signals'].items():
        after = sum(t >= settle for t in s['events'])
        lines.append(
            f'{name:>8} {s["samples"]:8d} {_number(s["min"])} {_number(s["max"])} '
            f'{len(s["events"]):7d} {after:6d}'
        )
    r = report['rejection']
    ratio = '-' if r['ratio'] is None else f'{r["ratio"]:.2f}'
    lines += [
        f'disturbance {r["disturbance_events"]}, reference {r["reference_events"]}, '
        f'preserved {r["preserved"]}, spurious {r["spurious"]}, missed {r["missed"]}, '
        f'ratio {ratio}',
        f'residual      y - y_r: max {_number(report["residual"]["max_abs"])}  '
        f'rms {_number(report["residual"]["rms"])}',
        f'synchronisation w - u: max {_number(report["synchronisation"]["max_abs"])}  '
        f'rms {_number(report["synchronisation"]["rms"])}',
        f'verdict: {report["verdict"]}',
    ]
    return '\n'.join(lines)


def _number(value: float | None) -> str:
    return f'{"-":>9}' if value is None else f'{value:9.3g}'
