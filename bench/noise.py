# SPDX-License-Identifier: Apache-2.0
"""False and missed events of a noisy y, with the detector's limits and without.

Run ``PYTHONPATH=. python bench/noise.py`` from the top of the repository (seconds). White
noise is added to the recorded y of the sampled simulation, as in a noisy sensor that the loop does
not hear. An event is false when no event of the clean y is within 5 of it, and missed the other
way round. Prints the tables of docs/noise.md: the mean of 20 seeds over 400 of model time.
"""

from __future__ import annotations

import argparse

import numpy as np

from eventreg_ros import simulate
from eventreg_ros.analysis.events import detect
from eventreg_ros.analysis.noise import Array, examine
from eventreg_ros.analysis.trains import coincidence
from eventreg_ros.scenario.criteria import Criteria

LEVELS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
FIXED = {
    'off': Criteria(),
    'refractory 15': Criteria(refractory=15.0),
    'min_width 2': Criteria(min_width=2.0),
    'both': Criteria(refractory=15.0, min_width=2.0),
    'both, reset -0.9': Criteria(refractory=15.0, min_width=2.0, reset=-0.9),
}


def found(t: Array, y: Array, limits: Criteria) -> list[float]:
    """Return the events of y."""
    return detect(t, y, *limits.detector)


def wrong(t: Array, noisy: Array, limits: Criteria, truth: list[float]) -> tuple[int, int]:
    """Return how many events are false, and how many are missed."""
    events = found(t, noisy, limits)
    matched = coincidence(events, truth).matched
    return len(events) - matched, len(truth) - matched


def row(t: Array, y: Array, sd: float, seeds: int) -> str:
    """Return the line of the table for one noise level."""
    truth = found(t, y, Criteria())
    counts: dict[str, list[tuple[int, int]]] = {name: [] for name in (*FIXED, 'suggested')}
    for seed in range(seeds):
        noisy = y + np.random.default_rng(seed).normal(0.0, 1.0, len(y)) * sd
        for name, limits in FIXED.items():
            counts[name].append(wrong(t, noisy, limits, truth))
        suggestion = examine(t, noisy).suggestion
        limits = suggestion.criteria if suggestion else Criteria()
        counts['suggested'].append(wrong(t, noisy, limits, truth))
    cells = [' + '.join(f'{mean:.4g}' for mean in np.mean(c, axis=0)) for c in counts.values()]
    return f'| {sd:g} | ' + ' | '.join(cells) + ' |'


def main() -> None:
    """Print a table per scenario."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--scenarios', nargs='+', default=['exact', 'uncontrolled', 'open'])
    parser.add_argument('--seeds', type=int, default=20)
    args = parser.parse_args()
    for name in args.scenarios:
        run = simulate(name, 400.0, sampled=True)
        print(f'\n{name}: {len(found(run.t, run["y"], Criteria()))} events of y; false + missed\n')
        print('| sd | ' + ' | '.join((*FIXED, 'suggested')) + ' |')
        print('|---:|' + '---:|' * (len(FIXED) + 1))
        for sd in LEVELS:
            print(row(run.t, run['y'], sd, args.seeds), flush=True)


if __name__ == '__main__':
    main()
