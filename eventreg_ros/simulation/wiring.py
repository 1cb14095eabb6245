"""What both simulations ask of a set of blocks: who publishes what, and the grid of samples."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..errors import EventregError
from .block import BlockSpec
from .trajectory import Array

MAX_STEPS = 20_000_000
"""More samples per signal than this are refused rather than running out of memory."""


def published(blocks: Mapping[str, BlockSpec], stimulus: str | None = None) -> list[str]:
    """Return all signals that are published: the stimulus' (if any), then each block's.

    Raises EventregError when two publish the same signal.
    """
    owner = {} if stimulus is None else {stimulus: 'stimulus'}
    for name, spec in blocks.items():
        if spec.output in owner:
            raise EventregError(
                f'{owner[spec.output]} and {name} both publish {spec.output!r}; '
                f'set {name}.output to another signal'
            )
        owner[spec.output] = name
    return list(owner)


def common_grid(blocks: Mapping[str, BlockSpec]) -> tuple[float, float]:
    """Return (time_scale, rate) of all blocks; a step is time_scale / rate of model time.

    Raises EventregError when there is no block or the blocks disagree.
    """
    if not blocks:
        raise EventregError('nothing to simulate: name at least one block, the plant say')
    found = {name: (spec.time_scale, spec.rate) for name, spec in blocks.items()}
    if len(set(found.values())) > 1:
        raise EventregError(
            'all blocks must have the same time_scale and rate, got '
            + ', '.join(f'{name} {scale:g} and {rate:g}' for name, (scale, rate) in found.items())
            + '; set them once with -p /**.time_scale:=VALUE -p /**.rate:=VALUE'
        )
    return next(iter(found.values()))


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
