"""How regularly a recorded signal came."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

GAP = 2.0
"""An interval of this many median periods or more is a gap: at least one sample is missing."""


def timing(stamps: npt.NDArray[np.int64]) -> dict[str, float | int | None]:
    """Return rate, percentiles of the period and number of gaps from stamps in nanoseconds.

    ``stamps`` has shape (n,); the figures are in seconds, None for fewer than two samples.
    """
    if len(stamps) < 2:
        return {
            'rate': None,
            'period_p50': None,
            'period_p99': None,
            'period_max': None,
            'gaps': 0,
        }
    periods = np.diff(stamps) * 1e-9
    median = float(np.median(periods))
    span = float(stamps[-1] - stamps[0]) * 1e-9
    return {
        'rate': len(periods) / span if span > 0.0 else None,
        'period_p50': median,
        'period_p99': float(np.percentile(periods, 99)),
        'period_max': float(periods.max()),
        'gaps': int(np.count_nonzero(periods >= GAP * median)) if median > 0.0 else 0,
    }
