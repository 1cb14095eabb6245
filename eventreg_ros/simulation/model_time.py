# SPDX-License-Identifier: Apache-2.0
"""The grid of samples: time is a step count times a step size."""

from __future__ import annotations

import numpy as np

from ..errors import EventregError
from .trajectory import Array

MAX_STEPS = 5_000_000
"""More steps than this are refused rather than running out of memory."""

MAX_NUMBERS = 120_000_000
"""So are more steps times numbers per step: a run stays below 2 GB."""


LONGEST = 2**53
"""Steps of a run whose samples are not kept in memory, at most: they are counted exactly."""


def count_steps(duration: float, h: float, numbers: int = 1) -> int:
    """Return how many whole steps of ``h`` fit into ``duration``, both in model time.

    ``numbers`` are what has to be kept in memory of each step; with 0 there is no limit of memory.
    Raises EventregError when ``duration`` is negative, or asks for more than :data:`MAX_STEPS` or
    :data:`MAX_NUMBERS`.
    """
    if not duration >= 0.0:
        raise EventregError(f'duration must be >= 0, got {duration!r}')
    if not h > 0.0:
        raise EventregError(f'the step must be > 0, got {h!r}; take another time_scale / rate')
    most = min(MAX_STEPS, MAX_NUMBERS // numbers) if numbers else LONGEST
    if not duration / h <= most:
        raise EventregError(
            f'duration {duration:g} at h = {h:g} is more than {most} steps, the most for this '
            f'scenario; take a shorter duration or a larger time_scale / rate'
        )
    return int(duration / h + 1e-9)


def steps_of(span: float, h: float) -> int:
    """Return the whole number of steps of ``h`` that is nearest to ``span``, both in model time."""
    return round(min(span / h, float(MAX_STEPS)))


def model_times(steps: int, time_scale: float, rate: float = 1.0) -> Array:
    """Return the model times of samples 0 to ``steps``: n * time_scale / rate, never a sum."""
    return np.arange(steps + 1, dtype=np.float64) * time_scale / rate
