# SPDX-License-Identifier: Apache-2.0
"""How punctual the nodes are in real time: per rate and hold, idle and with both cores busy.

Run ``PYTHONPATH=. python bench/realtime.py`` from the top of the repository; needs ROS 2 and Linux
(it reads /proc). Each row is a run of its own in its own ROS domain on the loopback. Prints the
tables of docs/time.md.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from itertools import product
from pathlib import Path

import numpy as np

from eventreg_ros import scenario as scenarios
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.runtime.tick_grid import TickGrid
from eventreg_ros.session.domain import loopback_domain
from eventreg_ros.session.processes import Processes, node_command
from eventreg_ros.session.session import Session
from eventreg_ros.simulation.block import Block, BlockSpec

BLOCKS = ('exosystem', 'plant', 'controller')
TICKS = os.sysconf('SC_CLK_TCK')
PRECISIONS = (0.0, 0.0001, 0.0002, 0.0003, 0.0005)
HEAD = (
    '| rate, Hz | our load | load average before | hold | precision, us | late p50, us | p99, us '
    '| max, us | caught up | dropped | drift, steps | CPU per block, % | residual | verdict |'
)


@contextmanager
def own_environment() -> Iterator[None]:
    """Leave the environment as it was: a session sets its domain in it."""
    before = dict(os.environ)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


@contextmanager
def busy(number: int) -> Iterator[None]:
    """Keep ``number`` cores busy with loops at the usual priority; they end with us for sure."""
    loops = Processes()
    try:
        for i in range(number):
            loops.start(f'loop {i}', [sys.executable, '-c', 'while True: pass'], dict(os.environ))
        yield
    finally:
        loops.stop()


class Watched(Session):
    """A session that notes how much CPU its processes used while the loop ran."""

    def _watch(self, client, elapsed) -> None:
        ended = threading.Event()
        samples: dict[str, list[tuple[float, float]]] = {}

        def look() -> None:
            while not ended.wait(1.0):
                for name, process in list(self.processes.running.items()):
                    used = cpu_seconds(process.pid)
                    samples.setdefault(name, []).append((time.monotonic(), used))

        watcher = threading.Thread(target=look)
        watcher.start()
        try:
            super()._watch(client, elapsed)
        finally:
            ended.set()
            watcher.join()
        self.cpu = {
            name: (each[-1][1] - each[0][1]) / (each[-1][0] - each[0][0])
            for name, each in samples.items()
            if len(each) > 1
        }


def cpu_seconds(pid: int) -> float:
    """Return the user and system time of a process, from /proc/PID/stat; 0 when it is gone."""
    try:
        fields = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / TICKS


def measure(
    rate: float, load: int, hold: str, precision: float, seconds: float, scenario: str
) -> str:
    """Return one row of the table, from one run."""
    before = os.getloadavg()[0]
    overrides = [f'/**.rate:={rate}', f'/**.hold:={hold}', f'/**.precision:={precision}']
    with tempfile.TemporaryDirectory() as scratch, busy(load), own_environment():
        bag = Path(scratch) / 'bag'
        session = Watched(scenarios.load(scenario, overrides), bag, seconds)
        with redirect_stdout(StringIO()):
            session.perform()
        report = analyze(bag, settle=min(100.0, 5.0 * seconds)).report
        drifted = drift(bag, session.scenario.blocks['exosystem'])
    said = [session.timing[block] for block in BLOCKS]
    late = [1e6 * max(float(s[f'lateness.{key}']) for s in said) for key in ('p50', 'p99', 'max')]
    caught, dropped = (sum(int(s[key]) for s in said) for key in ('caught_up', 'dropped'))
    cpu = 100.0 * sum(session.cpu[block] for block in BLOCKS) / len(BLOCKS)
    cells = [
        f'{rate:g}',
        f'{load} loops' if load else 'none',
        f'{before:.2f}',
        hold,
        f'{precision * 1e6:g}',
        *(f'{value:.0f}' for value in late),
        str(caught),
        str(dropped),
        str(drifted),
        f'{cpu:.1f}',
        f'{report.residual.max_abs:.4f}',
        report.verdict,
    ]
    return '| ' + ' | '.join(cells) + ' |'


def drift(bag: Path, spec: BlockSpec) -> int:
    """Return by how many steps w's model time fell behind the ROS clock from start to end.

    The exosystem has no inputs, so its sample n is known to the bit: a sample's value says which
    step it is, its stamp which instant of the grid it was sent at. Their difference, the median
    over a hundred samples since single ones are sent late, is compared at the start and the end.
    """
    stamps, values = (each.tolist() for each in read_bag(bag).signals['w'])
    grid, block = TickGrid(spec.rate), Block(spec)
    number = {block.y: 0}
    for n in range(grid.index(stamps[-1]) - grid.index(stamps[0]) + int(10 * spec.rate)):
        number[block.advance((), ())] = n + 1
    behind = [
        grid.index(stamp) - number[value] for stamp, value in zip(stamps, values, strict=True)
    ]
    return int(np.median(behind[-100:])) - int(np.median(behind[:100]))


def main() -> None:
    """Measure row by row and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=60.0, help='per row (60)')
    parser.add_argument('--rates', type=float, nargs='+', default=[100, 200, 500, 1000])
    parser.add_argument('--loads', type=int, nargs='+', default=[0, os.cpu_count()])
    parser.add_argument('--holds', nargs='+', default=['zero', 'linear'])
    parser.add_argument('--precision', type=float, default=0.0, help='seconds (0)')
    parser.add_argument('--scenario', default='exact')
    parser.add_argument(
        '--single', action='store_true', help='one block alone at 1 kHz, by precision'
    )
    args = parser.parse_args()
    print(f'{args.scenario}, {args.seconds:g} s per row, load average {os.getloadavg()[0]:.2f}')
    if args.single:
        single(args.seconds)
        return
    print(HEAD)
    print('|' + '---|' * (HEAD.count('|') - 1))
    for load, rate, hold in product(args.loads, args.rates, args.holds):
        row = measure(rate, load, hold, args.precision, args.seconds, args.scenario)
        print(row, flush=True)
    print(f'load average {os.getloadavg()[0]:.2f}')


def single(seconds: float) -> None:
    """Print the lateness and the CPU of one exosystem alone at 1 kHz, by precision."""
    print('| precision, us | late p50, us | p99, us | max, us | CPU, % | load average |')
    print('|---:|---:|---:|---:|---:|---:|')
    for precision in PRECISIONS:
        with own_environment(), loopback_domain(os.environ) as environment:
            values, cpu = alone(precision, seconds, environment)
        late = [f'{1e6 * float(values[f"lateness.{key}"]):.0f}' for key in ('p50', 'p99', 'max')]
        cells = [f'{precision * 1e6:g}', *late, f'{100 * cpu:.1f}', f'{os.getloadavg()[0]:.2f}']
        print('| ' + ' | '.join(cells) + ' |', flush=True)


def alone(
    precision: float, seconds: float, environment: dict[str, str]
) -> tuple[dict[str, str], float]:
    """Return what an exosystem says of itself after ``seconds``, and its CPU in cores."""
    os.environ.update(environment)
    from eventreg_ros.session.client import Client

    arguments = ['-p', 'rate:=1000.0', '-p', f'precision:={precision}', '--log-level', 'WARN']
    processes = Processes()
    try:
        processes.start('exosystem', node_command('exosystem', arguments), environment)
        with Client(lambda: None) as client:
            client.until(lambda: 'step' in client.seen('exosystem'), 20.0, lambda: 'no step')
            begun = time.monotonic()
            used = cpu_seconds(processes.running['exosystem'].pid)
            client.wait(seconds)
            used = cpu_seconds(processes.running['exosystem'].pid) - used
            return client.seen('exosystem'), used / (time.monotonic() - begun)
    finally:
        processes.stop()


if __name__ == '__main__':
    main()
