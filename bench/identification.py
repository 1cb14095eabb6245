# SPDX-License-Identifier: Apache-2.0
"""How well a generator is identified: error of tau, time of a fit, coverage of the intervals.

Run ``PYTHONPATH=. python bench/identification.py`` from the top of the repository, in some minutes
(``--cases 20`` for less). Needs scipy; numba makes it faster. Prints the tables of docs/unknown.md.

Random generators: tau log-uniform from 1/25 to 1/6, k from 0.7 to 4, x0 uniform in [-2, 2]^4 (or in
antiphase), integrated by scipy (DOP853) for T = 200; in the closed loop a controller with random k
and tau.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from eventreg_ros.analysis.identification import (
    Identification,
    identify_from_plant,
    identify_generator,
    identify_generators,
)
from eventreg_ros.errors import EventregError

T = 200.0
K_P, TAU_P = 1.0, 1 / 11
WAYS = {
    'w': 'from w',
    'y': 'from y, u = 0',
    'y?': 'from y, plant unknown',
    'yu': 'from y and u of a loop',
}
LIMITS = {
    ('w', 0.05, 0.0): 1e-7,
    ('w', 0.05, 0.01): 2e-5,
    ('w', 0.05, 0.05): 2e-4,
    ('yu', 0.05, 0.05): 1e-4,
}


class Case(NamedTuple):
    """One recording without noise, and the truth."""

    tau: float
    k: float
    t: np.ndarray
    w: np.ndarray
    y: np.ndarray
    u: np.ndarray


@dataclass
class Row:
    """What came out for one kind of recording."""

    errors: list[float] = field(default_factory=list)
    scores: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    k_scores: list[float] = field(default_factory=list)
    refused: int = 0

    def add(self, found: Identification, case: Case, seconds: float) -> None:
        """Take one identification."""
        low, high = np.log(found.interval(0.95))
        middle, half = (low + high) / 2.0, (high - low) / 2.0
        self.errors.append(abs(middle - np.log(case.tau)))
        self.scores.append(abs(middle - np.log(case.tau)) / half)
        self.seconds.append(seconds)
        if (k := found.k_interval(0.95)) is not None:
            self.k_scores.append(float(k.low <= case.k <= k.high))


def fhn(v: float, r: float, drive: float, k: float, tau: float) -> tuple[float, float]:
    """Return the derivative of a neuron, written down once more."""
    return v - v**3 / 3.0 - r + k * (drive - v), tau * (v - r)


def case(random: np.random.Generator, every: float, way: str, antiphase: bool) -> Case:
    """Return a random recording, a sample ``every`` of model time."""
    from scipy.integrate import solve_ivp

    tau, tau_c = np.exp(random.uniform(np.log(1 / 25), np.log(1 / 6), 2))
    k, k_c = random.uniform(0.7, 4.0, 2)
    x0 = random.uniform(-2.0, 2.0, 4)
    if antiphase:
        x0[2:] = -x0[:2]

    def loop(_: float, x: np.ndarray) -> tuple[float, ...]:
        a, b, c, d, y, q, e, f, g, h = x.tolist()
        on = way == 'yu'
        return (
            *fhn(a, b, -c, k, tau),
            *fhn(c, d, -a, k, tau),
            *fhn(y, q, a - e * on, K_P, TAU_P),
            *fhn(e, f, y - g, k_c, tau_c),
            *fhn(g, h, -e, k_c, tau_c),
        )

    t = np.arange(0.0, T + 1e-9, every)
    start = [*x0, 0.0, 0.0, 0.5, 0.0, -0.5, 0.0]
    x = solve_ivp(loop, (0.0, T), start, 'DOP853', t, rtol=1e-10, atol=1e-12).y
    return Case(float(tau), float(k), t, x[0], x[4], x[6])


def identify(way: str, one: Case, noise: np.ndarray) -> Identification:
    """Identify the generator of a case."""
    if way == 'w':
        return identify_generator(one.t, one.w + noise)
    if way == 'y?':
        return identify_from_plant(one.t, one.y + noise, plant=None)
    return identify_from_plant(one.t, one.y + noise, one.u if way == 'yu' else None)


def measure(way: str, every: float, sd: float, antiphase: bool, cases: int, seed: int) -> Row:
    """Identify ``cases`` random generators with white noise of standard deviation ``sd``."""
    random, row = np.random.default_rng(seed), Row()
    for _ in range(cases):
        one = case(random, every, way, antiphase)
        noise = sd * random.standard_normal(len(one.t))
        start = time.process_time()
        try:
            found = identify(way, one, noise)
        except EventregError as error:
            row.refused += 1
            print(f'refused, 1/tau {1 / one.tau:.4g}, k {one.k:.3g}: {error}')
            continue
        row.add(found, one, time.process_time() - start)
    return row


def settings() -> Iterator[tuple[str, float, float, bool]]:
    """Yield what is measured: the way, the interval of the samples, the noise, antiphase."""
    for every in (0.05, 2.0):
        for sd in (0.0, 0.01, 0.05, 0.2):
            yield 'w', every, sd, True
    for sd in (0.0, 0.01, 0.05):
        yield 'w', 0.05, sd, False
    for way in ('y', 'yu', 'y?'):
        for sd in (0.0, 0.01, 0.05):
            yield way, 0.05, sd, True
    yield 'y', 0.05, 0.05, False
    yield 'yu', 0.05, 0.05, False
    yield 'yu', 2.0, 0.05, True


def table(cases: int, seed: int) -> None:
    """Print errors, coverage and times; coverage should be 90 to 99 % where there is noise."""
    head = 'recording | every | noise | median error | required | coverage | k | CPU s | slowest'
    print(f'| {head} |')
    print('|---|---:|---:|---:|---:|---:|---:|---:|---:|')
    for way, every, sd, antiphase in settings():
        row = measure(way, every, sd, antiphase, cases, seed)
        limit = LIMITS.get((way, every, sd)) if antiphase else None
        what = WAYS[way] + ('' if antiphase else ', random start')
        k = f'{len(row.k_scores)}' + (f', {np.mean(row.k_scores):.0%}' if row.k_scores else '')
        print(
            f'| {what} | {every:g} | {sd:g} | {np.median(row.errors):.1e} '
            f'| {"" if limit is None else format(limit, ".0e")} '
            f'| {np.mean(np.array(row.scores) <= 1.0):.1%} | {k} '
            f'| {np.median(row.seconds):.2f} | {max(row.seconds):.2f} |',
            flush=True,
        )


def pairs(cases: int, seed: int) -> None:
    """Print how often two generators are found in the sum of their signals."""
    print('\n| two generators, T | noise | found | refused | median error | slowest |')
    print('|---:|---:|---:|---:|---:|---:|')
    for length in (200.0, 600.0):
        found, refused, errors, seconds = 0, 0, [], []
        random = np.random.default_rng(seed)
        for _ in range(cases):
            t, x, taus = pair(random, length)
            start = time.process_time()
            try:
                both = identify_generators(t, x + 0.05 * random.standard_normal(len(t)), 2)
            except EventregError:
                refused += 1
                continue
            seconds.append(time.process_time() - start)
            error = max(abs(np.log(np.array([each.tau for each in both]) / taus)))
            errors.append(error)
            found += error < 0.01
        print(
            f'| {length:g} | 0.05 | {found} of {cases} | {refused} | {np.median(errors):.1e} '
            f'| {max(seconds):.2f} |'
        )


def pair(random: np.random.Generator, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return t, w_1 + w_2, and the taus, from 1/30 to 1/8 and at least 5 % apart."""
    from scipy.integrate import solve_ivp

    t, total = np.arange(0.0, length, 0.05), 0.0
    taus = np.zeros(2)
    while abs(np.log(taus[1] / taus[0])) < 0.05 if taus.all() else True:
        taus = np.sort(1.0 / random.uniform(8.0, 30.0, 2))
    for tau in taus:
        start = random.uniform(-1.5, 1.5, 2)
        total = total + solve_ivp(
            lambda _, x, tau=tau: fhn(x[0], x[1], 0.0, 0.0, tau),
            (0.0, length), start, 'DOP853', t, rtol=1e-9, atol=1e-10,
        ).y[0]  # fmt: skip
    return t, np.asarray(total), taus


def main() -> None:
    """Measure everything and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--cases', type=int, default=50, help='random generators a row (50)')
    parser.add_argument('--seed', type=int, default=0)
    args = parser.parse_args()
    table(args.cases, args.seed)
    pairs(args.cases, args.seed)


if __name__ == '__main__':
    main()
