# SPDX-License-Identifier: Apache-2.0
"""That lockstep gives the same bits, however the machine and the order of starting are.

Run ``PYTHONPATH=. python bench/determinism.py`` from the top of the repository (ten runs of each
scenario, as processes and composed: about half an hour); needs ROS 2. Both cores are kept busy, the
nodes are started one by one in a random order, and one of them comes 5 s after the others. Prints
the table of docs/time.md.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import tempfile
import time
from pathlib import Path

import numpy as np
from realtime import busy, own_environment

from eventreg_ros import scenario as scenarios
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.errors import EventregError
from eventreg_ros.runtime.tick_grid import TickGrid
from eventreg_ros.session.domain import loopback_domain
from eventreg_ros.session.processes import Processes, node_command
from eventreg_ros.simulation.sampled import simulate_sampled

LATE = 5.0
"""Seconds after the others."""

CORES = os.cpu_count() or 1

LIMIT = 120.0
"""Seconds after which a run counts as stuck."""


def hash_of(signals: dict[str, tuple[bytes, bytes]]) -> str:
    """Return the hash of the stamps and values of all signals."""
    found = hashlib.sha256()
    for name in sorted(signals):
        for part in (name.encode(), *signals[name]):
            found.update(part)
    return found.hexdigest()


def recorded(
    name: str, seconds: float, bag: Path, *, composed: bool, seed: int, late: float = LATE
) -> str:
    """Run a scenario in lockstep for simulated ``seconds`` and return the hash of its bag.

    The order of starting, and who is ``late``, are those of ``seed``; composed, all nodes share a
    process, so that there is an order only.
    """
    os.environ.pop('ROS_DOMAIN_ID', None)
    with loopback_domain(os.environ) as environment:
        os.environ.update(environment)
        from eventreg_ros.session.client import Client

        scenario, stored = scenarios.load(name), bag.with_suffix('.scenario.yaml')
        stored.write_text(scenario.to_yaml())
        whole = scenario.with_recorder(str(bag), str(stored)).in_lockstep(seconds)
        file = bag.with_suffix('.yaml')
        file.write_text(whole.to_yaml())
        arguments = ['--params-file', str(file), '--log-level', 'WARN']
        order = list(whole.nodes)
        random.Random(seed).shuffle(order)
        processes = Processes()

        def alive() -> None:
            for node in processes.look():
                raise EventregError(f'{node} {processes.died[node]}')

        try:
            with Client(alive) as client:
                reached = client.follow(whole.nodes['clock']['participants'], whole.rate)
                if composed:
                    processes.start(
                        'nodes', node_command('composed', arguments, order), environment
                    )
                else:
                    for i, node in enumerate(order):
                        if i == len(order) - 1:
                            client.wait(late)
                        processes.start(node, node_command(node, arguments), environment)
                steps = round(seconds * whole.rate)
                client.until(lambda: reached() >= steps, LIMIT, lambda: f'at {reached()}')
        finally:
            processes.stop()
    return hash_of({n: (t.tobytes(), x.tobytes()) for n, (t, x) in read_bag(bag).signals.items()})


def simulated(name: str, seconds: float) -> str:
    """Return the hash of the sampled simulation, stamped as a bag of lockstep is."""
    scenario = scenarios.load(name)
    run = simulate_sampled(scenario.loop, seconds * scenario.time_scale)
    stamps = np.array(TickGrid(scenario.rate).stamps(len(run.t)), np.int64).tobytes()
    return hash_of({n: (stamps, x.astype(np.float64).tobytes()) for n, x in run.signals.items()})


def main() -> None:
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--runs', type=int, default=10, help='of each (10)')
    parser.add_argument('--seconds', type=float, default=40.0, help='simulated, per run (40)')
    parser.add_argument('--scenarios', nargs='+', default=scenarios.shipped())
    args = parser.parse_args()
    print('| scenario | how | runs | hashes | that of simulate --sampled | seconds per run |')
    print('|---|---|---:|---:|---|---:|')
    for name in args.scenarios:
        wanted = simulated(name, args.seconds)
        for composed in (False, True):
            begun, found = time.monotonic(), set()
            for seed in range(args.runs):
                with tempfile.TemporaryDirectory() as scratch, own_environment(), busy(CORES):
                    bag = Path(scratch) / 'bag'
                    found.add(recorded(name, args.seconds, bag, composed=composed, seed=seed))
            each = (time.monotonic() - begun) / args.runs
            how = 'composed' if composed else 'processes'
            same = 'yes' if found == {wanted} else 'NO'
            cells = [name, how, str(args.runs), str(len(found)), same, f'{each:.1f}']
            print('| ' + ' | '.join(cells) + ' |', flush=True)


if __name__ == '__main__':
    main()
