# SPDX-License-Identifier: Apache-2.0
"""White noise on what blocks publish: what a sensor adds to every sample."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import EventregError
from .trajectory import Array


@dataclass(frozen=True)
class Noise:
    """Gaussian noise on every sample of the signals ``on``, sample by sample independent.

    ``sd`` is its standard deviation, in the signals' unit. Every signal has random numbers of its
    own, which depend on ``seed`` and its place among ``on`` only: a longer run begins alike. Raises
    EventregError for a bad value.
    """

    sd: float = 0.0
    seed: int = 0
    on: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not 0.0 <= self.sd < float('inf'):
            raise EventregError(f'noise must be >= 0 and finite, got {self.sd!r}')
        if self.seed < 0:
            raise EventregError(f'seed must be >= 0, got {self.seed}')

    def reaches(self, signal: str) -> bool:
        """Return whether ``signal`` is noisy."""
        return self.sd > 0.0 and signal in self.on

    def draw(self, samples: int) -> Iterator[tuple[str, Array]]:
        """Yield each noisy signal and what is added to its samples, shape (samples,)."""
        for place, signal in enumerate(self.on):
            if self.reaches(signal):
                draws = np.random.default_rng((self.seed, place, 2))
                yield signal, draws.normal(0.0, self.sd, samples)


SILENCE = Noise()
