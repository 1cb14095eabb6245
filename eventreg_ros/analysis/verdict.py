"""The verdict on a run, recorded or simulated: one report, in the shape that the contract gives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from ..models.roles import SIGNALS
from .events import RESET, THRESHOLD, detect
from .rejection import SETTLE, WINDOW, reject

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
    events = {name: detect(t, x, threshold, reset) for name, (t, x) in signals.items()}
    rejection = reject(events.get('w', []), events['y'], events.get('y_r', []), settle, window)
    return {
        'scenario': scenario,
        'time_scale': time_scale,
        'duration': max(float(t[-1]) for t, _ in signals.values() if len(t)),
        'settle': settle,
        'verdict': rejection.verdict,
        'rejection': {**vars(rejection), 'ratio': rejection.ratio},
        'residual': _difference(signals, 'y', 'y_r', settle, required=False),
        'synchronisation': _difference(signals, 'w', 'u', settle, required=True),
        'signals': {name: _summary(*signals[name], events[name]) for name in _ordered(signals)},
    }


def _ordered(signals: Signals) -> list[str]:
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


def _difference(
    signals: Signals, a: str, b: str, settle: float, *, required: bool
) -> dict[str, float | None]:
    """Return max_abs and rms of a - b after ``settle``, at the times of a, b interpolated.

    The rms weighs each interval by its length. Without b: of a alone, or nothing if ``required``.
    """
    nothing: dict[str, float | None] = {'max_abs': None, 'rms': None}
    if a not in signals or (required and b not in signals):
        return nothing
    t, x = _finite(*signals[a])
    if b in signals:
        other = _finite(*signals[b])
        if len(other[0]) == 0:
            return nothing
        inside = (t >= other[0][0]) & (t <= other[0][-1])
        t, x = t[inside], x[inside]
        x = x - np.interp(t, *other)
    t, x = t[t >= settle], x[t >= settle]
    if len(t) == 0:
        return nothing
    return {'max_abs': float(np.abs(x).max()), 'rms': _rms(t, x)}


def _finite(t: Array, x: Array) -> tuple[Array, Array]:
    keep = np.isfinite(x)
    return t[keep], x[keep]


def _rms(t: Array, x: Array) -> float:
    span = float(t[-1] - t[0])
    if span <= 0.0:
        return float(np.sqrt(np.mean(x * x)))
    return math.sqrt(float(np.sum(0.5 * (x[1:] ** 2 + x[:-1] ** 2) * np.diff(t))) / span)


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
