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

    ``sd`` is its standard deviation in the signals' unit, one for all of them or one each. Every
    signal has random numbers of its own, which depend on ``seed`` and its place among ``on`` only:
    a longer run begins alike. Raises EventregError for a bad value.
    """

    sd: float | tuple[float, ...] = 0.0
    seed: int = 0
    on: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for sd in self.sd if isinstance(self.sd, tuple) else (self.sd,):
            if not 0.0 <= sd < float('inf'):
                raise EventregError(f'noise must be >= 0 and finite, got {sd!r}')
        if self.seed < 0:
            raise EventregError(f'seed must be >= 0, got {self.seed}')

    @property
    def sds(self) -> tuple[float, ...]:
        """The standard deviation of each of ``on``."""
        return self.sd if isinstance(self.sd, tuple) else (self.sd,) * len(self.on)

    def reaches(self, signal: str) -> bool:
        """Return whether ``signal`` is noisy."""
        return any(sd > 0.0 and name == signal for name, sd in zip(self.on, self.sds, strict=True))

    def draw(self, samples: int) -> Iterator[tuple[str, Array]]:
        """Yield each noisy signal and what is added to its samples, shape (samples,)."""
        for place, (signal, sd) in enumerate(zip(self.on, self.sds, strict=True)):
            if sd > 0.0:
                yield signal, sd * draws(self.seed, place, samples)


def draws(seed: int, place: int, samples: int) -> Array:
    """Return normal numbers of mean 0 and standard deviation 1, shape (samples,)."""
    return np.random.default_rng((seed, place, 2)).standard_normal(samples)


SILENCE = Noise()
