"""The grid of samples: time is a step count times a step size."""

from __future__ import annotations

import numpy as np

from ..errors import EventregError
from .trajectory import Array

MAX_STEPS = 20_000_000
"""More samples per signal than this are refused rather than running out of memory."""


def count_steps(duration: float, h: float) -> int:
    """Return how many whole steps of ``h`` fit into ``duration``, both in model time.

    Raises EventregError when ``duration`` is negative or asks for more than MAX_STEPS.
    """
    if not duration >= 0.0:
        raise EventregError(f'duration must be >= 0, got {duration!r}')
    if not duration / h <= MAX_STEPS:
        raise EventregError(
            f'duration {duration:g} at h = {h:g} is more than {MAX_STEPS} steps; '
            f'take a shorter duration or a larger time_scale / rate'
        )
    return int(duration / h + 1e-9)


def model_times(steps: int, time_scale: float, rate: float = 1.0) -> Array:
    """Return the model times of samples 0 to ``steps``: n * time_scale / rate, never a sum."""
    return np.arange(steps + 1, dtype=np.float64) * time_scale / rate
