# SPDX-License-Identifier: Apache-2.0
"""By how much u is ahead of its time stamps, and what to say when that is too little."""

from __future__ import annotations

import math
from typing import NamedTuple


class Lead(NamedTuple):
    """The lead in whole steps of ``h``, in model time, ``time_scale`` of which make a second."""

    steps: int = 0
    h: float = 1.0
    time_scale: float = 1.0

    @property
    def lead(self) -> float:
        """The lead in model time."""
        return self.steps * self.h

    @property
    def seconds(self) -> float:
        """The lead in seconds."""
        return self.lead / self.time_scale

    def needed(self, delay: float) -> float:
        """Return the lead (model time) that covers a delay of ``delay`` seconds."""
        return math.ceil(delay * self.time_scale / self.h - 1e-6) * self.h

    def complaint(self, signal: str, delay: float, late: int) -> str:
        """Say that ``late`` samples, which took up to ``delay`` seconds, came after their time."""
        return (
            f'{late} samples of {signal} came after their time and were held: they took up to '
            f'{delay * 1e3:.0f} ms ({delay * self.time_scale:.3f} of model time), lead is '
            f'{self.lead:g}; set -p /**.lead:={self.needed(delay):g}'
        )
