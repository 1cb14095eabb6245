# SPDX-License-Identifier: Apache-2.0
"""What a figure of the paper is: runs of scenarios, columns derived from them, and a layout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from ..api import Run, load, simulate
from ..control.adaptive import fixed
from ..models import NEURON, OSCILLATOR
from ..plots.figures import Layout, Panel
from ..scenario import Scenario
from ..simulation.block import BlockSpec
from ..simulation.trajectory import Array

Columns = Mapping[str, Array]
Derived = Callable[[Columns], Array]

SYMBOLS = {'plant': '_p', 'reference': '_r', 'exosystem': '_w', 'controller': r'_\eta'}
PER_LINE = 3
"""Pairs of parameters on one line above a figure."""


@dataclass(frozen=True)
class Case:
    """One simulation of a figure: a scenario, what it overrides, and what is done during the run.

    ``at`` holds interventions, T:ACTION with T in model time; ``sampled``: sample by sample.
    """

    scenario: str
    overrides: tuple[str, ...] = ()
    at: tuple[str, ...] = ()
    sampled: bool = False


@dataclass(frozen=True)
class PaperFigure:
    """One figure.

    ``source`` says where the paper has it, ``caption`` what it shows; ``duration`` is in model
    time. The signals of the case called '' are columns by their own names, those of any other case
    are CASE.SIGNAL, and ``derived`` adds columns computed from these. ``symbols`` are the indices
    of k and tau by role; with ``per_panel`` each panel is titled with its own parameters.
    """

    name: str
    source: str
    caption: str
    cases: Mapping[str, Case]
    duration: float
    layout: Layout
    derived: Mapping[str, Derived] = field(default_factory=dict)
    symbols: Mapping[str, str] = field(default_factory=lambda: SYMBOLS)
    per_panel: bool = False


@dataclass(frozen=True)
class Drawable:
    """The data of a figure, and its layout with the words that depend on the parameters.

    ``t`` has shape (n,), in model time, and so has each of ``columns``.
    """

    t: Array
    columns: dict[str, Array]
    layout: Layout
    notes: list[str]
    threshold: float
    reset: float


def compute_runs(figure: PaperFigure, overrides: Iterable[str] = ()) -> Drawable:
    """Run the cases of ``figure``, each with ``overrides`` on top of its own.

    Raises EventregError when an override does not fit one of the scenarios.
    """
    scenarios = scenarios_of(figure, overrides)
    runs = {
        name: simulate(scenarios[name], figure.duration, at=case.at, sampled=case.sampled)
        for name, case in figure.cases.items()
    }
    columns = _columns(runs)
    columns |= {name: function(columns) for name, function in figure.derived.items()}
    layout, notes = figure.layout, parameters(scenarios.values(), figure.symbols)
    if figure.per_panel:
        layout, notes = _titled(layout, scenarios, figure.symbols), []
    limits = next(iter(scenarios.values())).criteria
    t = next(iter(runs.values())).t
    return Drawable(t, columns, layout, notes, limits.threshold, limits.reset)


def scenarios_of(figure: PaperFigure, overrides: Iterable[str] = ()) -> dict[str, Scenario]:
    """Return the scenario of each case."""
    given = tuple(overrides)
    return {n: load(case.scenario, *case.overrides, *given) for n, case in figure.cases.items()}


def _columns(runs: Mapping[str, Run]) -> dict[str, Array]:
    return {
        f'{name}.{signal}' if name else signal: x
        for name, run in runs.items()
        for signal, x in run.signals.items()
    }


def _titled(
    layout: Layout, scenarios: Mapping[str, Scenario], symbols: Mapping[str, str]
) -> Layout:
    """Title each panel with the parameters of the cases that it draws."""

    def titled(panel: Panel) -> Panel:
        cases = {curve.column.rpartition('.')[0] for curve in panel.curves}
        words = parameters([scenarios[case] for case in sorted(cases)], symbols)
        return replace(panel, title=', '.join(words))

    return replace(layout, panels=tuple(map(titled, layout.panels)))


def parameters(scenarios: Iterable[Scenario], symbols: Mapping[str, str] = SYMBOLS) -> list[str]:
    """Return the parameters of scenarios as lines of mathtext, as in the paper's captions."""
    names: dict[str, list[str]] = {}
    all_blocks = [scenario.blocks for scenario in scenarios]
    for role, index in symbols.items():
        for block in (blocks[role] for blocks in all_blocks if role in blocks):
            if pair := _symbols(block, role, index):
                same = names.setdefault(f'({", ".join(map(_number, pair[1]))})', [])
                same += [pair[0]] if pair[0] not in same else []
    pairs = [f'${" = ".join(same)} = {values}$' for values, same in names.items()]
    return [', '.join(pairs[i : i + PER_LINE]) for i in range(0, len(pairs), PER_LINE)]


def _symbols(block: BlockSpec, role: str, index: str) -> tuple[str, tuple[float, ...]] | None:
    """Return the symbols of a block's parameters, and their values; None when it has none."""
    alone = fixed(block)
    if alone.model in (NEURON, OSCILLATOR):
        return rf'(k{index}, \tau{index})', alone.params[:2]
    if role == 'controller':
        return r'(k_y, K_{\eta_1}, K_{\eta_2})', block.params
    return None


def _number(value: float) -> str:
    """Return ``value`` as the paper writes it: 1/12 as a fraction, 0.1 not."""
    short, nice = f'{value:.4g}', Fraction(value).limit_denominator(100)
    exact = abs(nice - Fraction(value)) < 1e-12 and len(str(nice)) < len(short)
    return str(nice) if exact else short


def starts(
    scenario: str, prefix: str, states: Iterable[Mapping[str, str]], *more: str
) -> dict[str, Case]:
    """Return cases PREFIX_1, PREFIX_2, ..., one per initial state: x0 as YAML, by role."""
    return {
        f'{prefix}_{i}': Case(
            scenario, (*more, *(f'{role}.x0:={x0}' for role, x0 in state.items()))
        )
        for i, state in enumerate(states, 1)
    }


def total(a: str, b: str) -> Derived:
    """Return the function that adds two columns."""
    return lambda columns: columns[a] + columns[b]


def difference(a: str, b: str) -> Derived:
    """Return the function that subtracts column ``b`` from ``a``."""
    return lambda columns: columns[a] - columns[b]


def spread(*names: str) -> Derived:
    """Return the function that takes max - min over some columns, at each time."""
    return lambda columns: np.asarray(np.ptp([columns[name] for name in names], axis=0))
