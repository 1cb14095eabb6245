# SPDX-License-Identifier: Apache-2.0
"""``eventreg run``: the scenario's nodes as processes over real topics, recorded and judged."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..files import need_writable
from ..scenario.interventions import read_all
from ..session.live import bag_of, check, run, usual_duration
from .arguments import (
    add_at,
    add_blind,
    add_link,
    add_scenario,
    add_window,
    load_scenario,
    positive,
)
from .live_report import show
from .progress import Terminal
from .report_outputs import ReportOutputs, add_report_outputs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``run``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, metavar='S',
        help='seconds to run (40, or 300 of model time after settling)',
    )  # fmt: skip
    parser.add_argument('--bag', type=Path, metavar='DIR', help='directory of the bag, made new')
    parser.add_argument(
        '--lockstep',
        action='store_true',
        help='run as fast as possible; bit-identical to simulate --sampled; S counts simulated '
        'seconds',
    )
    parser.add_argument(
        '--composed', action='store_true', help='run all nodes in one process and one executor'
    )
    parser.add_argument(
        '--timing', action='store_true', help='print what each node measured of its own time'
    )
    parser.add_argument(
        '--network', action='store_true',
        help='let other hosts see the nodes and set them; else the run keeps to the loopback',
    )  # fmt: skip
    add_link(parser)
    add_at(parser, 'S', 'seconds')
    add_report_outputs(parser)
    add_window(parser)
    add_blind(parser)


def main(args: argparse.Namespace) -> int:
    """Run, record, analyse; see the contract for the exit codes."""
    implicit = ('spike_monitor', 'recorder', *(('clock',) if args.lockstep else ()))
    scenario = load_scenario(args, implicit).with_links(args.links)
    bag = args.bag or bag_of(scenario)
    check(scenario, bag)
    read_all(args.at, scenario)
    home = next(parent for parent in bag.absolute().parents if parent.exists())
    need_writable(home / bag.name)
    outputs = ReportOutputs.of(args)
    duration = args.duration or usual_duration(scenario, args.settle)
    found = run(
        scenario,
        duration,
        bag=bag,
        lockstep=args.lockstep,
        composed=args.composed,
        observer=Terminal(duration),
        at=args.at,
        network=args.network,
        settle=args.settle,
        window=args.window,
        blind=args.blind,
    )
    return show(found, outputs, args.timing)
