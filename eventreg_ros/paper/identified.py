# SPDX-License-Identifier: Apache-2.0
"""Figures over the noise of a recording: how well the generator is identified from it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ..analysis.identification import Plant, identify_from_plant, identify_generator
from ..api import Run, load, simulate
from ..errors import EventregError
from ..plots.figures import Layout
from ..scenario.criteria import RESET, THRESHOLD
from ..simulation.trajectory import Array
from .figure import Drawable

DURATION = 200.0
"""Model time of each recording."""

LEAST, MOST, LEVELS, DRAWS = 0.003, 0.3, 6, 5
"""Standard deviations of the noise, from and to, how many, and how often each is drawn."""


@dataclass(frozen=True)
class IdentifiedCase:
    """A scenario that is simulated, and the signal from which its exosystem is identified."""

    scenario: str
    signal: str

    @property
    def command(self) -> str:
        """The command line that does it without noise."""
        return f'eventreg identify {self.scenario} --from-signal {self.signal}'


@dataclass(frozen=True)
class IdentifiedFigure:
    """One figure: the column called as a case is the median of |d ln tau| over the noise."""

    name: str
    source: str
    caption: str
    cases: Mapping[str, IdentifiedCase]
    layout: Layout


def compute_identified(figure: IdentifiedFigure, overrides: Iterable[str] = ()) -> Drawable:
    """Simulate and identify the cases of ``figure``, each with ``overrides``.

    Raises EventregError when an override does not fit one of the scenarios.
    """
    given = tuple(overrides)
    sds = np.geomspace(LEAST, MOST, LEVELS)
    columns = {}
    for name, case in figure.cases.items():
        run = simulate(load(case.scenario, *given), DURATION)
        found = [[_error(run, case.signal, sd, seed) for seed in range(DRAWS)] for sd in sds]
        columns[name] = np.median(found, axis=1)
    return Drawable(sds, columns, figure.layout, [], THRESHOLD, RESET)


def _error(run: Run, signal: str, sd: float, seed: int) -> float:
    """Return |d ln tau| from a signal with white noise on it; not a number where it is refused."""
    nodes = run.scenario.nodes
    x: Array = run[signal] + sd * np.random.default_rng(seed).standard_normal(len(run.t))
    try:
        if signal == 'w':
            found = identify_generator(run.t, x)
        else:
            plant = Plant(nodes['plant']['k'], nodes['plant']['tau'])
            found = identify_from_plant(run.t, x, run.signals.get('u'), plant=plant)
    except EventregError:
        return float('nan')
    return float(abs(np.log(found.tau / nodes['exosystem']['tau'])))
