# SPDX-License-Identifier: Apache-2.0
"""How regularly a recorded signal came."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

GAP = 1.5
"""An interval of this many median periods or more may be a gap; see :func:`count_gaps`."""


class Timing(NamedTuple):
    """How regularly a signal came: samples per second, periods in seconds, and gaps.

    All but ``gaps`` are None where there are fewer than two samples.
    """

    rate: float | None
    period_p50: float | None
    period_p99: float | None
    period_max: float | None
    gaps: int


def timing(stamps: npt.NDArray[np.int64], patience: float | None = None) -> Timing:
    """Return how regularly a signal came, from its stamps in nanoseconds, shape (n,).

    Where not every sample is sent, an interval is a gap when it is longer than ``patience``
    (seconds).
    """
    if len(stamps) < 2:
        return Timing(None, None, None, None, 0)
    periods = np.diff(stamps) * 1e-9
    median = float(np.median(periods))
    span = float(stamps[-1] - stamps[0]) * 1e-9
    return Timing(
        rate=len(periods) / span if span > 0.0 else None,
        period_p50=median,
        period_p99=float(np.percentile(periods, 99)),
        period_max=float(periods.max()),
        gaps=(
            count_gaps(periods, median)
            if patience is None
            else int(np.count_nonzero(periods > patience))
        ),
    )


def count_gaps(periods: npt.NDArray[np.float64], median: float) -> int:
    """Return how many intervals are too long because at least one sample is missing.

    A sample that is merely late makes one interval longer and the next one shorter by as much; a
    missing one is not made up for. So a gap is an interval of 1.5 median periods or more that is,
    with the next, 2.5 or more. The last interval has no next: it must be 2 or more.
    """
    following = np.append(periods[1:], 0.5 * median)
    long = (periods >= GAP * median) & (periods + following >= (GAP + 1.0) * median)
    return int(np.count_nonzero(long)) if median > 0.0 else 0
