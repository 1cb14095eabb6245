# SPDX-License-Identifier: Apache-2.0
"""What adaptive controllers have learned, when they locked, and whether two are alike."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..bags.finding import Finding
from ..control.adaptive import GAIN, LARGEST
from ..scenario import Scenario
from ..simulation.block import BlockSpec
from .changes import Change
from .signal import NOTHING, Array, Signals

LOCKED = 0.05
"""|ln(learned / generator's)| within which a controller counts as locked."""

ALIKE = 0.01
"""|ln| of the ratio of two learned values within which they are those of one generator."""

SAME_GENERATOR, LARGE_GAIN, NO_GENERATOR = 'same-generator', 'large-gain', 'no-generator'
"""Codes of what is to be said of learning; none of them changes a verdict."""


class Learner(NamedTuple):
    """An adaptive controller as it is judged: what it publishes, and what there is to learn.

    ``signal`` carries ``parameter``; ``gain`` is that of the learning; ``generators`` are the
    exosystems with their values of the parameter.
    """

    controller: str
    signal: str
    parameter: str
    gain: float
    generators: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Learned:
    """What a controller learned over a run; times are in model time.

    ``generator`` is the exosystem whose value of the parameter, ``value``, is nearest to the last
    one learned; both None where there is none. ``locked_at`` is the time from which on what was
    learned stays within :data:`LOCKED` of it, None if it does not.
    """

    signal: str
    parameter: str
    first: float
    last: float
    generator: str | None = None
    value: float | None = None
    locked_at: float | None = None


def learners_of(scenario: Scenario) -> tuple[Learner, ...]:
    """Return the adaptive controllers of ``scenario``, with the generators of their namespace."""
    blocks = scenario.blocks
    return tuple(
        Learner(
            name,
            f'{spec.output}/{parameter}',
            parameter,
            float(scenario.nodes[name][GAIN]),
            tuple(_values(scenario, name, parameter, blocks)),
        )
        for name, spec in blocks.items()
        for parameter in spec.model.learned
    )


def _values(
    scenario: Scenario, controller: str, parameter: str, blocks: Mapping[str, BlockSpec]
) -> Iterable[tuple[str, float]]:
    home = scenario.name_of(controller).namespace
    for name, spec in blocks.items():
        known = parameter in (each.name for each in spec.model.parameters)
        if spec.role == 'exosystem' and known and scenario.name_of(name).namespace == home:
            yield name, float(scenario.nodes[name][parameter])


def after(learners: Iterable[Learner], changes: Iterable[Change]) -> tuple[Learner, ...]:
    """Return the learners with the generators as they are after the last of ``changes``."""
    set_to = {}
    for change in changes:
        parameter, _, text = change.what.partition(':=')
        if (value := _positive(text)) is not None:
            set_to[change.node.strip('/'), parameter] = value
    return tuple(
        each._replace(
            generators=tuple(
                (node, set_to.get((node, each.parameter), value)) for node, value in each.generators
            )
        )
        for each in learners
    )


def _positive(text: str) -> float | None:
    """Return the number that ``text`` is, if it is positive and finite."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0.0 < value < math.inf else None


def learned(signals: Signals, learners: Iterable[Learner]) -> tuple[Learned, ...]:
    """Return what the ``learners`` have learned, as far as it was recorded."""
    found = []
    for each in learners:
        t, x = signals.get(each.signal, NOTHING)
        keep = np.isfinite(x) & (x > 0.0)
        if keep.any():
            found.append(_compared(each, t[keep], x[keep]))
    return tuple(found)


def _compared(learner: Learner, t: Array, x: Array) -> Learned:
    known, first, last = dict(learner.generators), float(x[0]), float(x[-1])
    if not known:
        return Learned(learner.signal, learner.parameter, first, last)
    name = min(known, key=lambda node: distance(last, known[node]))
    value = known[name]
    at = locked_at(t, x, value)
    return Learned(learner.signal, learner.parameter, first, last, name, value, at)


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


def foreseen(learners: Iterable[Learner]) -> list[Finding]:
    """Return what is to be said of the learning before it begins."""
    said = []
    for each in learners:
        if each.gain > LARGEST:
            text = (
                f'{each.controller} learns with {GAIN} {each.gain:g}, and above {LARGEST:g} it '
                'need not converge; lower it'
            )
            said.append(Finding(LARGE_GAIN, each.signal, None, text))
        if not each.generators:
            text = (
                f'{each.controller} has no generator to learn {each.parameter} of; without w '
                f'{each.parameter} runs to its upper bound'
            )
            said.append(Finding(NO_GENERATOR, each.signal, None, text))
    return said


def findings(learners: Iterable[Learner], found: Sequence[Learned], spurious: int) -> list[Finding]:
    """Return what is to be said of the learning; ``spurious`` events were left of the plants."""
    said = foreseen(learners)
    for a, b in combinations(found, 2) if spurious else ():
        if a.parameter == b.parameter and distance(a.last, b.last) < ALIKE:
            text = (
                f'{a.signal} and {b.signal} are within {100 * ALIKE:g} % of each other while y '
                'still has events: both follow one generator; start them further apart'
            )
            said.append(Finding(SAME_GENERATOR, b.signal, None, text))
    return said


def words(each: Learned) -> str:
    """Return one line: what was learned, what the generator has, when it locked."""
    line = f'{each.signal} went from 1/{1 / each.first:.4f} to 1/{1 / each.last:.4f}'
    if each.value is None:
        return line
    line += f'; {each.generator} has 1/{1 / each.value:.4f}'
    if each.locked_at is None:
        return f'{line}, not within {100 * LOCKED:g} % of it at the end'
    return f'{line}, within {100 * LOCKED:g} % of it from {each.locked_at:.1f} on'
