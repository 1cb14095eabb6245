# SPDX-License-Identifier: Apache-2.0
"""An identification in words."""

from __future__ import annotations

import math

from .result import Identification


def table(found: Identification) -> str:
    """Return what ``eventreg identify`` prints."""
    lines = [
        f'{found.signal}: {found.samples} samples over {found.duration:.4g} of model time, '
        f'residual {found.residual_rms:.2g} (root mean square)'
    ]
    for each in found.all:
        low, high = each.interval()
        digits = _digits(each.tau_sd / each.tau)
        lines.append(
            f'tau     {each.tau:.{digits}g} = 1/{1.0 / each.tau:.{digits}g}; '
            f'95 %: {low:.{digits}g} to {high:.{digits}g}'
        )
        lines.append(f'k       {_k(each)}')
        lines.append(f'period  {each.period:.6g} of model time')
    if (found.gain, found.offset) != (1.0, 0.0):
        lines.append(f'sensor  gain {found.gain:.6g}, offset {found.offset:.6g}')
    return '\n'.join(lines)


def _k(found: Identification) -> str:
    interval = found.k_interval()
    if found.k is None or found.k_sd is None or interval is None:
        return f'not identifiable: {found.reason}'
    digits = _digits(found.k_sd / found.k)
    low, high = interval
    return f'{found.k:.{digits}g}; 95 %: {low:.{digits}g} to {high:.{digits}g}; {found.reason}'


def _digits(relative: float) -> int:
    """Return how many significant digits a value has whose relative error is ``relative``."""
    return 3 if relative <= 0.0 or relative > 0.1 else min(2 + math.ceil(-math.log10(relative)), 12)
