"""``eventreg run``: the scenario's nodes as processes over real topics, recorded and judged."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from ..analysis.recorded import analyze
from ..analysis.verdict import EXIT_CODES, table
from ..errors import EventregError, ros_is_missing
from ..scenario import Scenario
from ..session.session import Session
from . import live_timing
from .arguments import (
    add_json,
    add_link,
    add_scenario,
    add_window,
    load_scenario,
    need_writable,
    positive,
    write_json,
)
from .main import fail
from .progress import Terminal

BROKEN = 4
"""Exit code when a node died on the way; the verdict's codes are those of the contract."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``run``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, default=40.0, metavar='S', help='seconds to run (40)'
    )
    parser.add_argument('--bag', type=Path, metavar='DIR', help='directory of the bag, made new')
    parser.add_argument(
        '--lockstep',
        action='store_true',
        help='as fast as the nodes go, to the same bits as simulate --sampled; S is simulated',
    )
    parser.add_argument(
        '--composed', action='store_true', help='all nodes in one process and one executor'
    )
    add_link(parser)
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Run, record, analyse; see the contract for the exit codes."""
    scenario = scenario_of(args)
    bag = args.bag or chosen_path(scenario)
    check(scenario, bag, args.json)
    session = Session(
        scenario,
        bag,
        args.duration,
        lockstep=args.lockstep,
        composed=args.composed,
        observer=Terminal(args.duration),
    )
    session.perform()
    broken = '; '.join(session.troubles)
    try:
        report = analyze(bag, settle=args.settle, window=args.window).report
    except EventregError as error:
        if not broken:
            raise
        fail(f'{broken}; {error}')
        return BROKEN
    print(f'bag: {bag}')
    print(table(report))
    if session.timing:
        print(live_timing.tables(session.timing, session.warnings))
    write_json(args.json, report)
    if broken:
        fail(broken)
        return BROKEN
    return EXIT_CODES[report['verdict']]


def scenario_of(args: argparse.Namespace) -> Scenario:
    """Return the scenario, with its links; -p may name the nodes that ``run`` adds to it."""
    implicit = ('spike_monitor', 'recorder', *(('clock',) if args.lockstep else ()))
    return load_scenario(args, implicit).with_links(args.links)


def chosen_path(scenario: Scenario) -> Path:
    """Return the bag's path: the recorder's, where the scenario says one, else a dated name."""
    given = scenario.nodes.get('recorder', {}).get('path')
    return Path(given or time.strftime(f'eventreg_{scenario.name}_%Y_%m_%d-%H_%M_%S'))


def check(scenario: Scenario, bag: Path, json: Path | None) -> None:
    """Raise EventregError for what would fail only after the run."""
    if 'y' not in scenario.publishers:
        raise EventregError(f'scenario {scenario.name} has no plant to judge; name one')
    _ = scenario.time_scale
    if bag.exists():
        raise EventregError(f'bag {bag} exists already; remove it or give another --bag')
    home = next(parent for parent in bag.absolute().parents if parent.exists())
    need_writable(home / bag.name)
    need_writable(json)
    need_rclpy()


def need_rclpy() -> None:
    """Raise EventregError when there is no ROS."""
    try:
        from ..session import client  # noqa: F401
    except ImportError as error:
        raise EventregError(ros_is_missing('run', error)) from None
