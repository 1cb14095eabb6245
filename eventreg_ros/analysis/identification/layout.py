# SPDX-License-Identifier: Apache-2.0
"""What is unknown of generators, plant and sensor, as one vector.

In this order: ln tau of each generator; ln k of the only one, unless it is taken to be in
antiphase; the initial states; of a plant its initial state and, where it is not known, ln k_p and
ln tau_p; a sensor's gain and offset, where they are unknown too.

In antiphase a generator moves as one uncoupled neuron (k = 0), so two states describe it; else it
is the oscillator with four.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

LOG_TAU, LOG_K, STATE, LOG_PLANT = (-5.7, -0.05), (-4.0, 1.8), (-4.0, 4.0), (-4.6, 2.3)
"""Bounds of the unknowns: tau from 1/300 to 0.95, k from 0.02 to 6."""


class Plant(NamedTuple):
    """The neuron through which a generator is seen: conductance k_p, time constant tau_p."""

    k: float
    tau: float


@dataclass(frozen=True)
class Layout:
    """What is unknown, and where in the vector it stands."""

    generators: int = 1
    antiphase: bool = True
    plant: Plant | None = None
    plant_known: bool = True
    affine: bool = False

    @property
    def width(self) -> int:
        """States of one generator."""
        return 2 if self.antiphase else 4

    @property
    def log_k(self) -> int:
        """Where ln k stands, if the generator is not in antiphase."""
        return self.generators

    def states(self, generator: int) -> slice:
        """Say where the initial state of a generator stands."""
        first = self.generators + (not self.antiphase) + generator * self.width
        return slice(first, first + self.width)

    @property
    def plant_state(self) -> slice:
        """Where the plant's initial state stands."""
        first = self.states(self.generators).start
        return slice(first, first + 2 * (self.plant is not None))

    @property
    def log_plant(self) -> slice:
        """Where ln k_p and ln tau_p stand."""
        first = self.plant_state.stop
        return slice(first, first + 2 * (self.plant is not None and not self.plant_known))

    @property
    def sensor(self) -> slice:
        """Where gain and offset stand."""
        first = self.log_plant.stop
        return slice(first, first + 2 * self.affine)

    @property
    def size(self) -> int:
        """How many numbers are unknown."""
        return int(self.sensor.stop)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The lower and the upper bounds, both of shape (size,)."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        states = slice(self.states(0).start, self.plant_state.stop)
        for where, (least, most) in (
            (slice(0, self.generators), LOG_TAU),
            (slice(self.generators, states.start), LOG_K),
            (states, STATE),
            (self.log_plant, LOG_PLANT),
        ):
            low[where], high[where] = least, most
        return low, high
