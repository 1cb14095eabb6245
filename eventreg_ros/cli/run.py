# SPDX-License-Identifier: Apache-2.0
"""``eventreg run``: the scenario's nodes as processes over real topics, recorded and judged."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..analysis.rejection import REJECTED
from ..analysis.report_table import table
from ..files import need_writable
from ..scenario.interventions import read_all
from ..session.live import LiveRun, bag_of, check, run, usual_duration
from . import live_timing
from .arguments import (
    add_at,
    add_blind,
    add_link,
    add_scenario,
    add_window,
    load_scenario,
    positive,
    warn,
)
from .process import fail
from .progress import Terminal
from .report_outputs import ReportOutputs, add_report_outputs, recorded_page

BROKEN = 4
"""Exit code when a node died during the run; the verdict's codes are those of the contract."""


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


def show(found: LiveRun, outputs: ReportOutputs, timing: bool = False) -> int:
    """Print and write what came of the run, the verdict last; return the exit code.

    The tables of ``timing`` come unasked where events were not rejected and a node warned of what
    can be the reason.
    """
    broken = '; '.join(found.troubles)
    analysis = found.analysis
    if analysis is None:
        fail(f'{broken}; {found.unjudged}')
        return BROKEN
    report = analysis.report
    warn(report.evidence.warnings)
    warnings = found.warnings if timing else live_timing.matters(found.warnings)
    if found.measured and (timing or (warnings and report.verdict != REJECTED)):
        print(live_timing.tables(found.measured, warnings))
    print(f'bag: {found.bag}')
    print(table(report))
    measured = live_timing.tables(found.measured, found.warnings) if found.measured else ''
    outputs.write(report, lambda: recorded_page(analysis, found.bag, found.noted, measured))
    if broken:
        fail(broken)
        return BROKEN
    return report.exit_code
