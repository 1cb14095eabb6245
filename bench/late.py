# SPDX-License-Identifier: Apache-2.0
"""What observer and prediction tolerate: delay, a wrong model, a wrong lead, loss, jitter, noise.

Run ``PYTHONPATH=. python bench/late.py`` from the top of the repository; two minutes with numba.
Prints the tables of docs/slow_network.md, each value with its limit behind it, and ends with exit
code 1 when one is broken. Model time, h = 0.05, the linear hold; links on y and u are impaired.
"""

from __future__ import annotations

import argparse
import math
import sys
import timeit
from collections.abc import Sequence

import numpy as np

from eventreg_ros import Run, judge, load, simulate
from eventreg_ros.control.predictor import Foresight, make_predictor
from eventreg_ros.models import OSCILLATOR
from eventreg_ros.simulation.numbered import Reader

PREDICT = 'controller.predict:=true'
ADAPT = 'controller.adapt:=0.04'
CASES = {
    'exact': (2, 1 / 12, 2, 1 / 12),
    'mismatch': (1, 1 / 12, 3, 1 / 16),
    'slow': (2, 1 / 12, 1, 1 / 20),
    'fast': (2, 1 / 20, 1, 1 / 12),
}
"""k and tau of the generator, k and first tau of the controller."""

NAMES = ('exosystem.k', 'exosystem.tau', 'controller.k', 'controller.tau')
TRUE_PLANT = ('reference.k:=1', f'reference.tau:={1 / 11}')
LIMIT_US = 60.0

broken: list[str] = []


def run(
    name: str,
    delay: float,
    duration: float,
    *overrides: str,
    lead: float | None = None,
    seed: int = 0,
    **impairments: float,
) -> Run:
    """Return the loop with links on y and u that are late by ``delay``, and a lead that fits."""
    scenario = load(name, PREDICT, f'/**.lead:={delay if lead is None else lead}', *overrides)
    return simulate(
        scenario, duration, sampled=True, delay=delay, on='yu', seed=seed, **impairments
    )


def checked(what: str, value: float, low: float = -math.inf, high: float = math.inf) -> str:
    """Return a cell of the table; note where the value is out of its limits."""
    if not low <= value <= high:
        broken.append(f'{what}: {value:g} is not within {low:g} and {high:g}')
    return f'{value:.4g}'


def events_after(run: Run, start: float) -> int:
    """Return how many events y has after ``start``."""
    return sum(t > start for t in run.events['y'])


def largest(run: Run, start: float) -> float:
    """Return the largest |y| from ``start`` on."""
    return float(np.abs(run['y'][run.t >= start]).max())


def exact_table() -> None:
    """Print what `exact` tolerates without learning, and where `mismatch` ends."""
    print('| delay | `exact`: verdict | largest y after 300 (limit 0.005) |\n|---|---|---|')
    for delay in (0.5, 1.0, 2.0, 4.0, 8.0, 20.0):
        found = run('exact', delay, 400.0)
        checked(f'exact at {delay:g}', found.verdict == 'rejected', 1.0)
        value = checked(f'exact at {delay:g}', largest(found, 300.0), high=0.005)
        print(f'| {delay:g} | {found.verdict} | {value} |')
    for delay, wanted in ((0.8, 'rejected'), (0.85, 'not rejected')):
        found = run('mismatch', delay, 400.0)
        checked(f'mismatch at {delay:g}', found.verdict == wanted, 1.0)
        print(f'\n`mismatch` at {delay:g}: {found.verdict} (wanted: {wanted})')


def learning_table() -> None:
    """Print events after 300, 1/tau at the end (limit 0.1 %), and |y| over the last 100."""
    delays = (0.0, 0.4, 2.0, 8.0)
    print('\n| case | ' + ' | '.join(f'delay {delay:g}' for delay in delays) + ' |')
    print('|---|' + '---|' * len(delays))
    for case, values in CASES.items():
        given = [f'{name}:={value}' for name, value in zip(NAMES, values, strict=True)]
        cells = []
        for delay in delays:
            found, what = run('exact', delay, 800.0, ADAPT, *given), f'{case} at {delay:g}'
            late = checked(what, events_after(found, 300.0), high=0.0)
            tau, wanted = 1.0 / found['u/tau'][-1], 1.0 / values[1]
            learned = checked(what, tau, wanted * 0.999, wanted * 1.001)
            whole = len(found.events['y'])
            cells.append(f'{late} / {whole}, {learned}, {largest(found, 700.0):.1e}')
        print(f'| {case} | ' + ' | '.join(cells) + ' |', flush=True)


def open_table() -> None:
    """Print the events of `open` that are spurious or missed, with the true plant as model."""
    print('\n| delay | `open`: events of y_r after 300 | spurious | missed |\n|---|---|---|---|')
    for delay in (0.0, 0.4, 2.0, 8.0):
        found = run('open', delay, 800.0, ADAPT, *TRUE_PLANT)
        rejection = judge(found, settle=300.0).rejection
        cells = [
            checked(f'open at {delay:g}', getattr(rejection, k), high=0)
            for k in ('spurious', 'missed')
        ]
        print(f'| {delay:g} | {rejection.reference_events} | {" | ".join(cells)} |', flush=True)


WRONG: dict[str, tuple[dict[str, float], float]] = {
    'lead 20 % too long at 2': ({'delay': 2.0, 'lead': 2.4}, 0.01),
    'lead 20 % too short at 2': ({'delay': 2.0, 'lead': 1.6}, 0.2),
    'loss 0.5 at 2': ({'delay': 2.0, 'loss': 0.5}, 0.06),
    'jitter 4, lead 5': ({'delay': 0.0, 'jitter': 4.0, 'lead': 5.0}, 0.005),
    'jitter 4, lead 2': ({'delay': 0.0, 'jitter': 4.0, 'lead': 2.0}, 0.1),
    'noise sd 0.1 on y at 2': ({'delay': 2.0, 'noise': 0.1}, 1.0),
}
"""What is not as it should be, and the limit of |y| after 300; noise counts in y."""


def wrong_table() -> None:
    """Print what `exact` makes of wrong leads, loss, jitter and noise; the worst of three seeds."""
    print('\n| `exact` | events after 100 | largest y after 300 | limit |\n|---|---|---|---|')
    for what, (case, limit) in WRONG.items():
        seeds = range(3 if case.keys() & {'loss', 'jitter', 'noise'} else 1)
        found = [run('exact', duration=400.0, seed=seed, **case) for seed in seeds]
        late = checked(what, max(events_after(each, 100.0) for each in found), high=0.0)
        most = checked(what, max(largest(each, 300.0) for each in found), high=limit)
        print(f'| {what} | {late} | {most} | {limit:g} |', flush=True)


def cost() -> None:
    """Print what one step of the predictor costs at a delay of 2 of model time, in plain Python."""
    lead = delay = 40
    u, y = [0.1] * 400, [0.1] * 400
    reader = Reader(lambda n, past: n - delay, lambda s, past: s, lambda s, past: y[s])
    step = make_predictor(OSCILLATOR, [reader], lambda s, past: u[s])
    foresight = Foresight((2.0, 1 / 12), (1.0, 1 / 11), lead, 100, 4, 8.0, (), 0.0)
    state = (0.5, 0.1, -0.5, 0.2, 0.1, 0.1, 59.0, 0.1, 1.0, 0.0)
    times = timeit.repeat(lambda: step(100, state, foresight, 0.05, None), number=100, repeat=50)
    value = checked('microseconds per step', min(times) * 1e4, high=LIMIT_US)
    print(f'\none step at a delay of 2, plain Python: {value} us (limit {LIMIT_US:g})')


def main(arguments: Sequence[str] | None = None) -> int:
    """Print everything; 1 when a limit is broken."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args(arguments)
    for table in (exact_table, learning_table, open_table, wrong_table, cost):
        table()
    print('\n' + ('\n'.join(broken) or 'all within their limits'))
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
