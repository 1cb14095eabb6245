# SPDX-License-Identifier: Apache-2.0
"""The yield of devices that are not as they should be: its interval, and what matters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import EventregError
from ..scenario import Scenario
from ..simulation.impairment import Impairment
from ..simulation.noise import Noise
from .axes import Array
from .design import problem
from .plan import Plan
from .sets import Sets
from .sweep import Sweep
from .worst import OF_BADNESS, badness

CONFIDENCE = 0.95


class Yield(NamedTuple):
    """The share of sets that are rejected, and Wilson's interval at :data:`CONFIDENCE`."""

    share: float
    low: float
    high: float


def yield_of(rejected: int, sets: int) -> Yield:
    """Return the yield where so many of ``sets`` > 0 are rejected."""
    from scipy.stats import binomtest

    interval = binomtest(rejected, sets).proportion_ci(CONFIDENCE, method='wilson')
    return Yield(rejected / sets, float(interval.low), float(interval.high))


class Index(NamedTuple):
    """How much of a quantity's variance one parameter explains: alone, and with the others.

    Half-widths of the intervals at 95 % come after them.
    """

    parameter: str
    quantity: str
    first: float
    first_within: float
    total: float
    total_within: float


def indices(sweep: Sweep) -> list[Index]:
    """Return Sobol's indices of the share rejected and of the residual's rms, by SALib.

    Sets that cannot be run are not rejected; where there are any, the rms has no indices. Raises
    EventregError unless the sweep is a sample of Saltelli's.
    """
    if sweep.plan.sampling != 'saltelli':
        raise EventregError(
            f'indices need a sample of their own, got {sweep.plan.sampling}; add --indices'
        )
    from SALib.analyze.sobol import analyze

    names = [axis.name for axis in sweep.plan.axes]
    found = []
    quantities = {
        'rejected': (sweep['verdict'] == 'rejected').astype(np.float64),
        'residual_rms': np.asarray(sweep['residual_rms'], dtype=np.float64),
    }
    for quantity, values in quantities.items():
        if not np.ptp(values) > 0.0:
            continue  # nothing varies, so nothing explains it, or it is not known of all
        s = analyze(problem(len(names)), values, calc_second_order=False, seed=sweep.plan.seed)
        keys = ('S1', 'S1_conf', 'ST', 'ST_conf')
        numbers = zip(*(s[key].tolist() for key in keys), strict=True)
        found += [Index(name, quantity, *four) for name, four in zip(names, numbers, strict=True)]
    return found


def worst_of(columns: Mapping[str, Array]) -> int | None:
    """Return the place of the set with most spurious and missed events, then largest residual.

    None where no set has a verdict.
    """
    bad = badness(columns)
    at = int(np.argmax(bad)) if len(bad) else -1
    return at if at >= 0 and bad[at] >= 0.0 else None


def worst_set(sweep: Sweep) -> list[Any] | None:
    """Return the values of the worst set, see :func:`worst_of`."""
    at = worst_of(sweep.only(OF_BADNESS))
    if at is None:
        return None
    return [column[0] for column in sweep.plan.design.columns(at, at + 1)]


MARGINS = 0.1, 0.25, 0.5
"""Shares of the way from the threshold to the reset that y - y_r may have to keep clear."""


class AtMargin(NamedTuple):
    """The yield of sets that are rejected and whose y - y_r stays below ``level`` after settling.

    ``margin`` is the share of the way from threshold to reset that lies above.
    """

    margin: float
    level: float
    share: float
    low: float
    high: float


def yield_of_sweep(sweep: Sweep) -> Yield:
    """Return the yield of a sweep of random sets."""
    rejected = _independent(sweep, sweep['verdict'] == 'rejected')
    return yield_of(int(rejected.sum()), len(rejected))


def yields_at_margins(sweep: Sweep) -> list[AtMargin]:
    """Return the yield of a sweep of random sets for each of :data:`MARGINS`."""
    columns, criteria = sweep.only(['verdict', 'peak']), sweep.plan.subject.criteria
    found = []
    for margin in MARGINS:
        level = criteria.threshold - margin * (criteria.threshold - criteria.reset)
        good = (columns['verdict'] == 'rejected') & (columns['peak'] <= level)
        rejected = _independent(sweep, good)
        share = yield_of(int(rejected.sum()), len(rejected))
        found.append(AtMargin(margin, level, *share))
    return found


def _independent(sweep: Sweep, of_sets: Array) -> Array:
    """Return what is known of those sets that are independent of each other.

    Of a sample of Saltelli's these are the first and the last of each base.
    """
    if sweep.plan.sampling != 'saltelli':
        return of_sets
    found: Array = of_sets.reshape(-1, len(sweep.plan.axes) + 2)[:, [0, -1]].ravel()
    return found


def scenario_text(plan: Plan, values: Sequence[Any]) -> str:
    """Return a set as the text of a scenario, above it the commands that simulate and run it."""
    sets = Sets(plan)
    links, noise = sets.imperfections(values)
    scenario = sets.scenario(values)
    limits = {'settle': plan.settle, 'window': plan.window}
    judged = [f'--{name} {value!r}' for name, value in limits.items() if value is not None]
    options = [
        f'--{name} {getattr(links, name)!r}'
        for name in ('delay', 'loss', 'jitter', 'seed')
        if getattr(links, name)
    ]
    options += [f'--on {",".join(sorted(links.on))}'] if links.on else []
    command = f'# eventreg simulate THIS.yaml --sampled --duration {plan.duration!r}'
    text = ' '.join([command, *judged, *options, *_noise_options(noise, links.seed)])
    run = ' '.join([_run(scenario, plan.duration, links), *judged])
    return f'{text}\n{run}\n{scenario.to_yaml()}'


def _run(scenario: Scenario, duration: float, links: Impairment) -> str:
    """Return the command that runs a set as nodes, whose links and times are in seconds.

    Without losses and jitter it does so in lockstep, to the bits of the simulation.
    """
    scale, rate = scenario.time_scale, scenario.rate
    of_link = {
        'delay': round(links.delay * rate / scale) / rate if np.isfinite(links.delay) else 0.0,
        'loss': links.loss,
        'jitter': links.jitter / scale,
        'seed': links.seed,
    }
    words = ','.join(f'{name}={value!r}' for name, value in of_link.items() if value)
    heard = dict.fromkeys(signal for _, signal in scenario.loop.links)
    signals = [each for each in heard if links.on is None or each in links.on]
    given = [f'--link {signal}:{words}' for signal in signals] if words else []
    lockstep = [] if links.random else ['--lockstep']
    seconds = f'--duration {duration / scale!r}'
    return ' '.join(['# eventreg run THIS.yaml', seconds, *lockstep, *given])


def _noise_options(noise: Noise, seed: int) -> list[str]:
    """Return the options of ``simulate`` for a noise; a comment where it has none for it."""
    sds = set(noise.sds)
    if len(sds) <= 1:
        given = [f'--noise {sd!r}' for sd in sds if sd > 0.0]
        return given + ([f'--seed {noise.seed}'] if given and not seed else [])
    each = ', '.join(f'{s} {sd!r}' for s, sd in zip(noise.on, noise.sds, strict=True))
    return [f'\n# and a noise of its own on each output: {each}']
