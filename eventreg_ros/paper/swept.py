# SPDX-License-Identifier: Apache-2.0
"""Figures over a parameter instead of time: what a sweep found, set by set."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..api import load
from ..plots.figures import Layout
from ..robustness.plan import Plan
from ..robustness.sweep import run_sweep
from ..scenario.criteria import RESET, THRESHOLD
from ..simulation.trajectory import Array
from .figure import Drawable

Columns = Mapping[str, Array]


@dataclass(frozen=True)
class SweptCase:
    """One sweep of a figure: a scenario, what is fixed and what is varied, as on a command line.

    ``duration`` and ``settle`` are in model time; ``on`` are the signals whose links are impaired,
    all where it is empty.
    """

    scenario: str
    parameters: tuple[str, ...]
    duration: float
    settle: float
    on: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        """The command line that makes the table of this sweep."""
        words = ['eventreg sweep', self.scenario, *(f'-p "{each}"' for each in self.parameters)]
        words += [f'--on {",".join(self.on)}'] if self.on else []
        return ' '.join([*words, f'--duration {self.duration:g} --settle {self.settle:g}'])


@dataclass(frozen=True)
class SweptFigure:
    """One figure of sweeps.

    ``source`` says what it belongs to, ``caption`` what it shows. The columns of the case called
    NAME are NAME.COLUMN, as the sweep's table has them; ``along`` computes the horizontal axis from
    these, shape (n,), increasing, and ``derived`` what is drawn over it.
    """

    name: str
    source: str
    caption: str
    cases: Mapping[str, SweptCase]
    along: Callable[[Columns], Array]
    layout: Layout
    derived: Mapping[str, Callable[[Columns], Array]] = field(default_factory=dict)


def compute_swept(figure: SweptFigure, overrides: Iterable[str] = ()) -> Drawable:
    """Run the sweeps of ``figure``, each with ``overrides`` on top of its own parameters.

    Raises EventregError when an override does not fit one of the scenarios.
    """
    given, found = tuple(overrides), dict[str, Array]()
    for name, case in figure.cases.items():
        plan = Plan.of(
            load(case.scenario, *given),
            case.parameters,
            duration=case.duration,
            settle=case.settle,
            on=case.on or None,
        )
        found |= {f'{name}.{column}': x for column, x in run_sweep(plan).columns.items()}
    columns = {name: np.asarray(function(found)) for name, function in figure.derived.items()}
    return Drawable(figure.along(found), columns, figure.layout, [], THRESHOLD, RESET)


def rejected(case: str, columns: Columns) -> Array:
    """Return which sets of a case were rejected, shape (n,) of bool."""
    return np.asarray(columns[f'{case}.verdict'] == 'rejected')
