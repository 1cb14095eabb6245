"""What adaptive controllers have learned, when they locked, and whether two are alike."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from ..scenario import Scenario

Array = npt.NDArray[np.float64]

LOCKED = 0.05
"""|ln(learned / generator's)| within which a controller counts as locked."""

ALIKE = 0.01
"""|ln| of the ratio of two learned values within which they are those of one generator."""


@dataclass(frozen=True)
class Learned:
    """A parameter that a controller learned, published as ``signal``; times are in model time.

    ``generator`` is the exosystem whose value of the parameter, ``value``, is nearest to the last
    one learned; both None where there is none. ``locked_at`` is the time from which on what was
    learned stays within :data:`LOCKED` of it, None if it is not.
    """

    signal: str
    parameter: str
    first: float
    last: float
    generator: str | None = None
    value: float | None = None
    locked_at: float | None = None


def learned(signals: Mapping[str, tuple[Array, Array]], scenario: Scenario) -> list[Learned]:
    """Return what the adaptive controllers of ``scenario`` learned, as far as it was recorded.

    ``signals`` maps each name to (t, values), both of shape (n,), t in model time.
    """
    found = []
    for spec in scenario.blocks.values():
        for parameter in spec.model.learned:
            signal = f'{spec.output}/{parameter}'
            t, x = signals.get(signal, (np.empty(0), np.empty(0)))
            keep = np.isfinite(x)
            if keep.any():
                known = _known(scenario, spec.name, parameter)
                found.append(_compared(signal, parameter, t[keep], x[keep], known))
    return found


def _known(scenario: Scenario, controller: str, parameter: str) -> dict[str, float]:
    """Return the value of ``parameter`` of each exosystem in the controller's namespace."""
    home = scenario.name_of(controller).namespace
    return {
        name: float(scenario.nodes[name][parameter])
        for name, spec in scenario.blocks.items()
        if spec.role == 'exosystem'
        and scenario.name_of(name).namespace == home
        and parameter in (each.name for each in spec.model.parameters)
    }


def _compared(
    signal: str, parameter: str, t: Array, x: Array, known: Mapping[str, float]
) -> Learned:
    first, last = float(x[0]), float(x[-1])
    if not known:
        return Learned(signal, parameter, first, last)
    generator = min(known, key=lambda node: distance(last, known[node]))
    value = known[generator]
    return Learned(signal, parameter, first, last, generator, value, locked_at(t, x, value))


def distance(learned: float, value: float) -> float:
    """Return |ln(learned / value)|, both positive."""
    return abs(math.log(learned / value))


def locked_at(t: Array, x: Array, value: float) -> float | None:
    """Return the time from which on ``x`` stays within :data:`LOCKED` of ``value``; None: never.

    ``t`` and ``x`` > 0 have shape (n,), n > 0.
    """
    away = np.flatnonzero(np.abs(np.log(x / value)) >= LOCKED)
    if len(away) == 0:
        return float(t[0])
    return float(t[away[-1] + 1]) if away[-1] + 1 < len(t) else None


def alike(found: Sequence[Learned]) -> list[tuple[Learned, Learned]]:
    """Return the pairs of controllers that have learned the same value, within :data:`ALIKE`."""
    return [(a, b) for a, b in combinations(found, 2) if distance(a.last, b.last) < ALIKE]


def words(each: Learned) -> str:
    """Return one line: what was learned, what the generator has, when it locked."""
    line = f'{each.signal} went from 1/{1 / each.first:.4f} to 1/{1 / each.last:.4f}'
    if each.value is None:
        return line
    line += f'; {each.generator} has 1/{1 / each.value:.4f}'
    if each.locked_at is None:
        return f'{line}, not within {100 * LOCKED:g} % of it at the end'
    return f'{line}, within {100 * LOCKED:g} % of it from {each.locked_at:.1f}'


def alike_words(a: Learned, b: Learned) -> str:
    """Return the warning that two controllers serve the same generator, for a y with events."""
    return (
        f'{a.signal} and {b.signal} have learned the same ({a.last:.6g}, within {100 * ALIKE:g} %) '
        f'while y still has events: both follow one generator; start them further apart'
    )
