# SPDX-License-Identifier: Apache-2.0
"""The fit of one generator in antiphase, which moves as one uncoupled neuron."""

from __future__ import annotations

import numpy as np

from .apparent import Apparent
from .fit import MISFIT, ROUGH, Fit, solve
from .layout import Array, Layout
from .model import Forward
from .recorded import Recorded

STARTS = 3
"""How many of the best starts are tried where the first does not fit."""

TAUS = (0.88, 0.93, 1.0, 1.07, 1.14)
"""Where tau is looked for, as parts of what the period says."""

SHORT, LARGE = 24.0, (0.4, 0.5, 0.65, 0.8)
"""Periods below the one (model time) may be those of a large tau, too."""


def fit_antiphase(recorded: Recorded, seen: Apparent) -> Fit:
    """Return the best fit of one generator in antiphase."""
    windows = [1.5 * seen.period * 3**n for n in range(8) if 3**n * seen.period < recorded.t[-1]]
    best: Fit | None = None
    for start in starts(recorded, seen):
        fit = solve(recorded, recorded.layout, start, windows)
        if best is None or fit.squares < best.squares:
            best = fit
        if best.misfit < MISFIT * seen.gain:
            break
    assert best is not None
    return best


def starts(recorded: Recorded, seen: Apparent) -> list[Array]:
    """Return starts for one generator in antiphase, the best first.

    A grid over tau, around what the period says, and over the generator's initial state is compared
    with the first one and a half periods of the apparent disturbance.
    """
    about = 2.2726 / max(seen.period - 10.275, 3.0)  # the period is near 10.275 + 2.2726 / tau
    taus = [about * part for part in TAUS] + list(LARGE if seen.period < SHORT else ())
    grid = np.meshgrid(np.log(taus), np.linspace(-2, 2, 5), np.linspace(-1.2, 1.2, 7))
    lanes = np.stack([each.ravel() for each in grid])
    first = seen.t <= 1.5 * seen.period
    found = Forward(Layout(), seen.t[first], ROUGH).predict(lanes)
    order = np.argsort(np.sum((found - seen.w[first, None]) ** 2, axis=0))
    return [extended(recorded, seen, lanes[:, i]) for i in order[:STARTS]]


def extended(recorded: Recorded, seen: Apparent, generator: Array) -> Array:
    """Append what is unknown of plant and sensor to what is unknown of the generator."""
    parts = [generator]
    if recorded.plant is not None:
        parts.append(np.array([(recorded.x[0] - seen.offset) / seen.gain, 0.0]))
        if not recorded.plant_known:
            parts.append(np.log(recorded.plant))
    if recorded.affine:
        parts.append(np.array([seen.gain, seen.offset]))
    return np.concatenate(parts)
