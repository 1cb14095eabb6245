# SPDX-License-Identifier: Apache-2.0
"""The loop on three hosts: its verdict over the delay and the loss of the links between them.

Exosystem, plant and controller run on hosts of their own (network namespaces, see ``netns.py``);
recorder, spike monitor and the analysis run on the controller's. The nodes find each other by
ROS_STATIC_PEERS, without multicast. Links are impaired from the first sample on.

Run ``PYTHONPATH=. python bench/hosts.py`` (about ten minutes; docs/hosts.md explains the table).
With ``--predict ROOM`` the controller predicts; its lead is delay, jitter and ROOM of model time.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from netns import Hosts, enter

from eventreg_ros import scenario as scenarios
from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.analysis.report_json import as_json
from eventreg_ros.errors import EventregError
from eventreg_ros.runtime.relay import Impairment
from eventreg_ros.session.observer import Observer
from eventreg_ros.session.processes import Processes
from eventreg_ros.session.session import Session

BLOCKS = ('exosystem', 'plant', 'controller')
"""The hosts, by the block that runs there; the last one records and analyses."""

QOS: dict[str, tuple[str, ...]] = {
    'reliable': (),
    'depth 10': tuple(
        f'{node}.qos_overrides./{signal}.publisher.depth:=10'
        for node, signal in (('exosystem', 'w'), ('plant', 'y'), ('controller', 'u'))
    ),
    'best effort': tuple(
        f'{node}.qos_overrides./{signal}.subscription.reliability:=best_effort'
        for node, signal in (('plant', 'w'), ('plant', 'u'), ('controller', 'y'))
    ),
}
"""Overrides of the scenario, by name; with best effort the recorder's inputs stay reliable."""

SHORT = {'duration': 17.0, 'settle': 40.0}
"""Seconds, and model time: the shortest run that holds three events of w after settling."""

DELAYS, LOSSES = (0.0, 20.0, 40.0, 50.0), (0.0, 0.05, 0.2)

PATIENT = '/**.input_timeout:=3'
"""With it w, which comes from a host of its own, does not count as silent for being late."""

OPTIONS = ('scenario', 'hold', 'duration', 'settle', 'predict')
"""What the command line says of all runs."""

BEGUN = 'begun'
"""What the process that conducts a run prints once all nodes are matched and begin."""


class HostProcesses(Processes):
    """Starts the node of each block on its own host, and the others on this one."""

    def __init__(self, prefixes: Mapping[str, Sequence[str]]) -> None:
        super().__init__()
        self._prefixes = prefixes

    def start(self, name: str, command: Sequence[str], environment: dict[str, str]) -> None:
        """Start ``command`` on the host of ``name``."""
        super().start(name, [*self._prefixes.get(name, ()), *command], environment)


class Began(Observer):
    """Says when the run has begun: from then on the links are to be impaired."""

    said = False

    def progressed(self, elapsed: float, counts: Mapping[str, int], last: bool = False) -> None:
        """Print a line at the first progress."""
        if not self.said:
            print(BEGUN, flush=True)
        self.said = True


def conduct(order: dict[str, Any]) -> dict[str, Any]:
    """Run one session on the host of the controller and return its report."""
    with tempfile.TemporaryDirectory(prefix='eventreg_hosts_') as scratch:
        bag = Path(scratch) / 'bag'
        scenario = scenarios.load(order['scenario'], order['overrides'])
        session = Session(scenario, bag, order['duration'], observer=Began(), network=True)
        session.processes = HostProcesses(order['prefixes'])
        session.perform()
        if session.troubles:
            raise EventregError('; '.join(session.troubles))
        options = {name: order[name] for name in ('settle', 'window', 'until')}
        report = analyze(bag, **options).report
        return {**as_json(report), 'measured': session.timing}


def run(
    hosts: Hosts,
    impairment: Impairment,
    *,
    scenario: str = 'exact',
    hold: str = 'linear',
    qos: str = 'reliable',
    duration: float = SHORT['duration'],
    settle: float = SHORT['settle'],
    predict: float | None = None,
) -> dict[str, Any]:
    """Run ``scenario`` on ``hosts`` and return the report. Raises EventregError when it cannot.

    ``predict``: how much more model time than delay and jitter the lead of a controller that
    predicts is; None: it does not predict.
    """
    overrides, scale = (
        [f'/**.hold:={hold}', PATIENT, *QOS[qos]],
        scenarios.load(scenario).time_scale,
    )
    if predict is not None:
        lead = scale * (impairment.delay + impairment.jitter) + predict
        overrides += ['controller.predict:=true', f'/**.lead:={lead:g}']
    order = {
        'scenario': scenario, 'overrides': overrides, 'duration': duration,
        'settle': settle, 'window': 5.0,
        # what is on its way at the end is not recorded any more
        'until': scale * (duration - 2.0 * (impairment.delay + impairment.jitter)),
        'prefixes': {name: hosts.within(name) for name in BLOCKS[:-1]},
    }  # fmt: skip
    environment = {
        **os.environ,
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_STATIC_PEERS': ';'.join(hosts.addresses.values()),
        'ROS_DOMAIN_ID': '1',
        'PYTHONUNBUFFERED': '1',
    }
    hosts.impair(Impairment(order='any'))
    with tempfile.TemporaryFile('w+') as errors:
        child = subprocess.Popen(
            [*hosts.within(BLOCKS[-1]), sys.executable, __file__, '--conduct', json.dumps(order)],
            env=environment, stdout=subprocess.PIPE, stderr=errors, text=True,
        )  # fmt: skip
        assert child.stdout is not None
        said = ''
        for line in child.stdout:
            said = line
            if line.strip() == BEGUN:
                hosts.impair(impairment)
        if child.wait():
            errors.seek(0)
            raise EventregError(f'the run on three hosts failed: {errors.read().strip()}')
    return dict(json.loads(said))


def in_words(report: dict[str, Any]) -> str:
    """Return what the table shows of a report."""
    rejection, measured = report['rejection'], report['measured'].get('plant', {})
    age = f'{float(measured["u.age.p50"]) * 1e3:.0f}' if 'u.age.p50' in measured else '?'
    counts = f'{rejection["spurious"]} of {rejection["disturbance_events"]}'
    late = f', {measured["u.late"]} late' if 'u.late' in measured else ''
    return f'{report["verdict"]}, {counts}, {age} ms{late}'


def parse(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument('--scenario', default='exact', help='(exact)')
    parser.add_argument('--hold', default='linear', choices=('linear', 'zero'), help='(linear)')
    parser.add_argument('--qos', nargs='+', default=list(QOS), choices=list(QOS))
    parser.add_argument('--delay', nargs='+', type=float, default=DELAYS, help='one way, ms')
    parser.add_argument('--loss', nargs='+', type=float, default=LOSSES, help='of datagrams')
    parser.add_argument('--jitter', type=float, default=0.0, help='ms (0)')
    parser.add_argument('--predict', type=float, metavar='ROOM', help='model time (no prediction)')
    parser.add_argument('--duration', type=float, default=SHORT['duration'], help='s (17)')
    parser.add_argument('--settle', type=float, default=SHORT['settle'], help='model time (40)')
    parser.add_argument('--json', type=Path, metavar='F', help='write all reports as JSON')
    parser.add_argument('--conduct', type=json.loads, help=argparse.SUPPRESS)
    return parser.parse_args(argv)


def main() -> int:
    """Print the table."""
    args = parse()
    if args.conduct is not None:
        try:
            print(json.dumps(conduct(args.conduct)))
        except EventregError as error:
            print(error, file=sys.stderr)
            return 2
        return 0
    enter()
    with Hosts(BLOCKS) as hosts:
        cells = print_table(hosts, args)
        multicast = hosts.switch.multicast if hosts.switch else None
    if args.json is not None:
        found = {'means': hosts.means, 'multicast': multicast, 'cells': cells}
        args.json.write_text(json.dumps(found, indent=1) + '\n', encoding='utf-8')
    return 0


def print_table(hosts: Hosts, args: argparse.Namespace) -> list[dict[str, Any]]:
    """Run every cell, print it as it comes, and return all reports."""
    # Without loss they are all the same.
    columns = [
        (qos, loss) for qos in args.qos for loss in args.loss if loss > 0.0 or qos == args.qos[0]
    ]
    print(
        f'Scenario {args.scenario}, hold {args.hold}, jitter {args.jitter:g} ms, '
        f'{"no prediction" if args.predict is None else f"lead {args.predict:g} more"}; links by '
        f'{hosts.means}; {os.cpu_count()} cores.\n'
    )
    print(f'| one way ms | {" | ".join(f"{q}, loss {p:.0%}" for q, p in columns)} | load |')
    print('|---:' + '|---' * len(columns) + '|---:|')
    cells = []
    for delay in args.delay:
        print(f'| {delay:g} ', end='', flush=True)
        for qos, loss in columns:
            impairment = Impairment(delay * 1e-3, args.jitter * 1e-3, loss, order='any')
            options = {name: getattr(args, name) for name in OPTIONS}
            report = attempt(hosts, impairment, qos=qos, **options)
            print(f'| {report.get("error") or in_words(report)} ', end='', flush=True)
            cells.append({'delay': delay, 'loss': loss, 'qos': qos, **report})
        print(f'| {os.getloadavg()[0]:.1f} |', flush=True)
    return cells


def attempt(hosts: Hosts, impairment: Impairment, **options: Any) -> dict[str, Any]:
    """Return the report of a run, or the error that it ended with."""
    try:
        return run(hosts, impairment, **options)
    except EventregError as error:
        return {'error': str(error)}


if __name__ == '__main__':
    sys.exit(main())
