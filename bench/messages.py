# SPDX-License-Identifier: Apache-2.0
"""In how many messages the loop does: every sample, on delta, spikes; verdicts, rates, CPU.

Run ``PYTHONPATH=. python bench/messages.py`` from the top of the repository, for the verdicts of
simulations (two minutes); with ``--live`` also runs of the real nodes, which need ROS 2 and Linux
(three minutes). Prints the tables of docs/narrow_link.md and ends with exit code 1 when a limit is
broken. Model time, h = 0.05; links on y and u are late by ``delay``, and the lead is the same.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from eventreg_ros import Run, judge, load, simulate
from eventreg_ros.analysis.messages import energies, messages
from eventreg_ros.analysis.recorded import analyze

TRUE_PLANT = ('reference.k:=1', f'reference.tau:={1 / 11}')
SCENARIOS = {'exact': (), 'mismatch': (), 'open': TRUE_PLANT}
LEARN = 'controller.adapt:=0.04'
PREDICT = 'controller.predict:=true'
SPIKES = (PREDICT, 'controller.coding:=spikes')
MOST_ON_DELTA, MOST_SPIKES = 2.5, 0.06
MOST_CPU = 2.0
"""Times that of a run with every sample and without prediction."""


broken: list[str] = []


def run(name: str, delay: float, *overrides: str) -> Run:
    """Return a run of 800 of model time; with prediction the generator is learned."""
    learns = (LEARN,) if PREDICT in overrides and name != 'exact' else ()
    more = SCENARIOS[name] if PREDICT in overrides else ()
    scenario = load(name, f'/**.lead:={delay}', *overrides, *learns, *more)
    return simulate(scenario, 800.0, sampled=True, delay=delay, on='yu')


def cell(found: Run, settle: float, most: float, what: str) -> str:
    """Return verdict and messages a unit; note what is not rejected or too much."""
    report, rate = judge(found, settle), found.messages['u'] / 800.0
    if report.verdict != 'rejected' or rate > most:
        broken.append(f'{what}: {report.verdict} with {rate:.3g} messages a unit, at most {most}')
    bad = report.rejection.spurious + report.rejection.missed
    return f'{report.verdict if not bad else f"**{bad} wrong**"}, {rate:.3g}'


def delta_table() -> None:
    """Print u sent on delta, without prediction, all other signals sample by sample."""
    print('u on delta, no delay: verdict after 100, messages of u a unit (every sample: 20)\n')
    print('| delta | ' + ' | '.join(SCENARIOS) + ' |\n|---|' + '---|' * len(SCENARIOS))
    for delta in (0.05, 0.1, 0.2, 0.3):
        cells = []
        for name in SCENARIOS:
            found = run(name, 0.0, f'controller.send_on_delta:={delta}')
            most = MOST_ON_DELTA if delta == 0.1 else 20.0
            what = f'{name}, delta {delta:g}'
            cells.append(cell(found, 100.0, most, what))
            if delta == 0.3:
                broken[:] = [each for each in broken if not each.startswith(what)]
        print(f'| {delta:g} | {" | ".join(cells)} |', flush=True)


def spike_table() -> None:
    """Print u in spikes, with prediction; y sample by sample and on delta."""
    for delta in (0.0, 0.05):
        way = f'on delta {delta:g}' if delta else 'every sample'
        print(f'\nu in spikes, y {way}: verdict after 300, messages of u a unit', end='')
        print(', of y\n' if delta else '\n')
        print('| delay | ' + ' | '.join(SCENARIOS) + ' |\n|---|' + '---|' * len(SCENARIOS))
        for delay in (0.0, 0.4, 2.0, 8.0):
            cells = []
            for name in SCENARIOS:
                found = run(name, delay, *SPIKES, f'plant.send_on_delta:={delta}')
                what = f'spikes, {name} at {delay:g}, y {delta:g}'
                most = MOST_SPIKES
                words = cell(found, 300.0, most, what)
                cells.append(words + (f', {found.messages["y"] / 800.0:.2g}' if delta else ''))
            print(f'| {delay:g} | {" | ".join(cells)} |', flush=True)


LIVE = {
    'every sample': (),
    'u on delta 0.1': ('controller.send_on_delta:=0.1',),
    'all on delta 0.1': ('/**.send_on_delta:=0.1',),
    'predict, lead 1': (PREDICT, '/**.lead:=1'),
    'predict, u in spikes, lead 1': (*SPIKES, '/**.lead:=1'),
}


def live_table(seconds: float) -> None:
    """Print runs of the real nodes: verdict, messages, CPU."""
    from realtime import BLOCKS, Watched, own_environment

    print('\nreal nodes, `exact`, 200 steps per second')
    print(
        '| | verdict | u: messages/s | per event of w | energy of u per event '
        '| CPU of plant, % | of controller, % |'
    )
    print('|---|---|---|---|---|---|---|')
    plain: dict[str, float] = {}
    for name, overrides in LIVE.items():
        with tempfile.TemporaryDirectory() as scratch, own_environment():
            session = Watched(load('exact', *overrides), Path(scratch) / 'bag', seconds)
            with redirect_stdout(StringIO()):
                session.perform()
            report = analyze(session.bag).report
        sent = messages(report)['u']
        cpu = ' | '.join(f'{100.0 * session.cpu[block]:.1f}' for block in BLOCKS[1:])
        spent = energies(report)['u'] / (sent.number / (sent.per_event or 1.0))
        print(
            f'| {name} | {report.verdict} | {sent.per_second:.3g} | {sent.per_event or 0.0:.3g} '
            f'| {spent:.3g} | {cpu} |',
            flush=True,
        )
        plain = plain or session.cpu
        broken.extend(
            f'{name}: {block} takes {session.cpu[block] / plain[block]:.2f} times the CPU, at most '
            f'{MOST_CPU:g}'
            for block in BLOCKS[1:]
            if session.cpu[block] > MOST_CPU * plain[block]
        )
    print(f'load average {os.getloadavg()[0]:.2f}')


def main(arguments: Sequence[str] | None = None) -> int:
    """Print everything; 1 when a limit is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--live', action='store_true', help='runs of the real nodes too')
    parser.add_argument('--seconds', type=float, default=25.0, help='of such a run (25)')
    args = parser.parse_args(arguments)
    delta_table()
    spike_table()
    if args.live:
        live_table(args.seconds)
    print('\n' + ('\n'.join(broken) or 'all within their limits'))
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
