# SPDX-License-Identifier: Apache-2.0
"""What a simulation returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """Signals on a common grid: ``t`` of shape (n,) in model time, every signal of shape (n,)."""

    t: Array
    signals: dict[str, Array]
