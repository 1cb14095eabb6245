# SPDX-License-Identifier: Apache-2.0
"""The choices of the hold, measured: which one, and over how long a time it draws a line.

Run ``PYTHONPATH=. python bench/horizon.py`` from the top of the repository; a minute with numba.
Prints the tables of docs/delays.md; ``--reach inf`` prints them for a hold that takes every line
for one, however far it leads (see ``REACH`` in eventreg_ros/simulation/hold.py).
"""

from __future__ import annotations

import argparse

import numpy as np

from eventreg_ros import scenario
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_of
from eventreg_ros.analysis.verdict import Report, judge
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.evaluator import Evaluator, Setting
from eventreg_ros.robustness.margins import limit
from eventreg_ros.simulation import hold
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import SampledLoop

HORIZONS = (0.0, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
SCENARIOS = ('exact', 'mismatch', 'open', 'linear')
STEPS = (0.05, 0.01)
DELAYS = (0.0, 0.1, 0.2)
T = {'mismatch': 400.0, 'open': 800.0}
"""Model time of a run; the pulses of `open` go on until 730."""

FAR = 3.0
"""A |y| beyond it counts as out of bounds; spikes stay below 2.8."""

LINEAR = 'linear'


def horizon_table(h: float) -> list[str]:
    """Return the first delay that fails, by horizon and scenario, at steps of ``h``."""
    lines = [
        f'First delay (model time) that fails; linear hold, h = {h:g}, reach {hold.REACH:g};',
        f'* at some delay up to 1, |y| goes beyond {FAR:g} (not asked of the linear motif)',
        '',
        '| horizon | ' + ' | '.join(f'`{name}`' for name in SCENARIOS) + ' |',
        '|---|' + '---|' * len(SCENARIOS),
    ]
    usual = hold.HORIZON
    for hold.HORIZON in HORIZONS:
        cells = [first_failure(scenario.load(name), h) for name in SCENARIOS]
        lines.append(f'| {hold.HORIZON:g} | ' + ' | '.join(cells) + ' |')
    hold.HORIZON = usual
    return lines


def first_failure(setup: scenario.Scenario, h: float) -> str:
    """Return the first delay at which the linear hold, with the horizon of now, is not rejected."""
    rate = setup.time_scale / h
    found = limit(Evaluator(setup, 'linear', rate, Setting()), 'delay')
    first = f'> {found.scanned_to:g}' if found.fails_at is None else f'{found.fails_at:.2f}'
    return f'{first}*' if setup.name != LINEAR and out_of_bounds(setup, rate) else first


def out_of_bounds(setup: scenario.Scenario, rate: float) -> bool:
    """Say whether a delay of 0, 0.05, ... 1 drives |y| beyond :data:`FAR`."""
    loop = network(setup, 'linear', rate)
    return any(peak(loop, 0.05 * i) > FAR for i in range(21))


def peak(loop: SampledLoop, delay: float) -> float:
    """Return the largest |y| of a run, infinite when the state stops being finite."""
    try:
        run = loop.run(400.0, Impairment(delay=delay))
    except EventregError:
        return np.inf
    return float(np.abs(run.signals['y']).max())


def network(setup: scenario.Scenario, kind: str, rate: float) -> SampledLoop:
    """Return the scenario's loop with one hold on all blocks, at one rate."""
    return SampledLoop(setup.loop.sampled_at(rate, kind))


def hold_table() -> list[str]:
    """Return the residual of `mismatch` and the spurious events of `open`, for both holds."""
    lines = [
        'max |y - y_r| after 100 of both, and spurious events of `open`, zero hold and linear hold',
        '',
        '| h | delay | `mismatch` zero | linear | `open` zero | linear | spurious zero | linear |',
        '|---|---|---|---|---|---|---|---|',
    ]
    for h in STEPS:
        for delay in DELAYS:
            both = {(n, k): judged(n, k, h, delay) for n in T for k in hold.HOLDS}
            residuals = [f'{report.residual.max_abs:.3f}' for report in both.values()]
            counts = [f'{both["open", kind].rejection.spurious}' for kind in hold.HOLDS]
            lines.append(f'| {h:g} | {delay:g} | ' + ' | '.join([*residuals, *counts]) + ' |')
    return lines


def judged(name: str, kind: str, h: float, delay: float) -> Report:
    """Return the report on a run of scenario ``name``."""
    setup = scenario.load(name)
    run = network(setup, kind, setup.time_scale / h).run(T[name], Impairment(delay=delay))
    signals = {signal: Signal(run.t, x) for signal, x in run.signals.items()}
    return judge(signals, subject_of(setup, signals))


if __name__ == '__main__':
    parser = argparse.ArgumentParser()
    parser.add_argument('--reach', type=float, default=hold.REACH)
    hold.REACH = parser.parse_args().reach  # before anything is compiled with it
    print('\n'.join(hold_table()) + '\n', flush=True)
    for step in STEPS:
        print('\n'.join(horizon_table(step)) + '\n', flush=True)
