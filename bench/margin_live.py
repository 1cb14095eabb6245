# SPDX-License-Identifier: Apache-2.0
"""The margins of `eventreg margin`, found again with the real nodes and the node ``link``.

Run ``PYTHONPATH=. python bench/margin_live.py`` from the top of the repository (twelve minutes);
needs ROS 2. Links on w, u and y delay, lose or jitter the samples, on both sides of the limit that
the sampled simulation finds for a run of the same length, with the zero hold: the blocks do not
know of a link's delay. Prints the table of docs/links.md.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from realtime import own_environment

from eventreg_ros import scenario as scenarios
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.robustness.evaluator import Evaluator, Setting
from eventreg_ros.robustness.margins import KINDS, limit
from eventreg_ros.session.session import Session

SECONDS, SETTLE = 17.0, 40.0
"""The shortest run that holds three events of w after settling (model time)."""

AROUND = {'delay': (-2, -1, 0, 1, 2), 'loss': (-30, -15, 0, 15, 30), 'jitter': (-8, -4, 0, 4, 8)}
"""What is tried, in steps of the search from the limit: 0.05, 0.005 and 0.05."""


def offline(name: str, kind: str) -> float:
    """Return the limit of a scenario by simulations as long as the runs."""
    scenario = scenarios.load(name)
    setting = Setting(SECONDS * scenario.time_scale, SETTLE, seeds=5, rate=scenario.rate)
    found = limit(Evaluator(scenario, 'zero', scenario.rate, setting), kind)
    assert found.largest is not None
    return found.largest


def live(name: str, kind: str, value: float) -> str:
    """Return the verdict of a run with links on w, u and y; ``value`` in seconds or a part."""
    links = [f'{signal}:{kind}={value}' for signal in 'wuy']
    scenario = scenarios.load(name, ['/**.hold:=zero']).with_links(links)
    with tempfile.TemporaryDirectory() as scratch, own_environment():
        bag = Path(scratch) / 'bag'
        with redirect_stdout(StringIO()):
            Session(scenario, bag, SECONDS).perform()
        report = analyze(bag, settle=SETTLE).report
    spurious = report.rejection.spurious
    return 'rejected' if report.verdict == 'rejected' else f'**{spurious} spurious**'


def main() -> None:
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--scenarios', nargs='+', default=['exact', 'mismatch'])
    parser.add_argument('--kinds', nargs='+', default=list(KINDS), choices=KINDS)
    args = parser.parse_args()
    print(f'load average {os.getloadavg()[0]:.2f}')
    print('| scenario | | limit offline | at | | | | |')
    print('|---|---|---:|---|---|---|---|---|')
    for name in args.scenarios:
        scale = scenarios.load(name).time_scale
        for kind in args.kinds:
            largest = offline(name, kind)
            unit = 0.005 if kind == 'loss' else scale / scenarios.load(name).rate
            cells = []
            for steps in AROUND[kind]:
                value = max(largest + steps * unit, 0.0)
                found = live(name, kind, value if kind == 'loss' else value / scale)
                cells.append(f'{value:g}: {found}')
            print(f'| {name} | {kind} | {largest:g} | ' + ' | '.join(cells) + ' |', flush=True)
    print(f'load average {os.getloadavg()[0]:.2f}')


if __name__ == '__main__':
    main()
