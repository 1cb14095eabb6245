# SPDX-License-Identifier: Apache-2.0
"""What a simulation returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """Signals on a common grid: ``t`` of shape (n,) in model time, every signal of shape (n,).

    ``messages``: in how many those were sent of which not every sample was.
    """

    t: Array
    signals: dict[str, Array]
    messages: Mapping[str, int] = field(default_factory=dict)
