# SPDX-License-Identifier: Apache-2.0
"""``eventreg simulate``: the scenario offline, as one continuous system or as the nodes do it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import EventregError
from ..files import need_writable
from .arguments import add_at, add_blind, add_scenario, add_window, load_scenario, positive, warn
from .impairments import add_impairments, impairments, warn_of_leads, warn_of_rounding
from .report_outputs import ReportOutputs, add_report_outputs

if TYPE_CHECKING:
    from ..analysis.verdict import Report
    from ..api import Run
    from ..plots.report import ReportPage
    from ..scenario import Scenario


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg simulate``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, metavar='T',
        help='model time (400, or 300 after settling)',
    )  # fmt: skip
    parser.add_argument(
        '--sampled', action='store_true', help='sample by sample, as the nodes do it in lockstep'
    )
    add_impairments(parser)
    add_at(parser, 'T', 'model time')
    parser.add_argument('--out', type=Path, metavar='F', help='write .npz, .csv or .parquet')
    parser.add_argument('--bag', type=Path, metavar='DIR', help='write the signals as a rosbag2')
    add_report_outputs(parser)
    add_window(parser)
    add_blind(parser)


def main(args: argparse.Namespace) -> int:
    """Run ``eventreg simulate`` and return the verdict's exit code."""
    from ..analysis.report_table import table
    from ..api import judge, simulate

    outputs, given = ReportOutputs.of(args), impairments(args)
    _check(args)
    scenario = load_scenario(args)
    _ = scenario.rate, scenario.time_scale  # raises unless all nodes, stimulus too, agree
    duration = _duration(args, scenario)
    run = simulate(scenario, duration, sampled=args.sampled, at=args.at, **given)
    report = judge(run, args.settle, args.window, blind=args.blind)
    print(table(report), flush=True)
    warn(report.evidence.warnings)
    warn_of_rounding(args.delay, scenario)
    warn_of_leads(scenario)
    _write(args, run)
    outputs.write(report, lambda: _page(run, report))
    return report.exit_code


def _duration(args: argparse.Namespace, scenario: Scenario) -> float:
    """Return the duration, in model time. Raises EventregError for what would fail afterwards."""
    from ..analysis.export import check_names
    from ..scenario.criteria import need_span

    if args.out is not None:
        check_names(args.out, scenario.publishers)
    criteria = scenario.criteria.overridden(settle=args.settle, window=args.window)
    duration = criteria.duration(400.0) if args.duration is None else float(args.duration)
    need_span(criteria, duration, settle=args.settle, until=None)
    return duration


def _check(args: argparse.Namespace) -> None:
    """Raise EventregError, before any work is done, for what could not be written."""
    from ..analysis.export import check_path

    if args.out is not None:
        check_path(args.out)
        need_writable(args.out)
    if args.bag is not None and args.bag.exists():
        raise EventregError(f'bag {args.bag} exists already; remove it or name another directory')


def _write(args: argparse.Namespace, run: Run) -> None:
    if args.out is not None:
        from ..analysis.export import write_signals

        write_signals(args.out, run.t, run.signals)
    if args.bag is not None:
        run.to_bag(args.bag, settle=args.settle, window=args.window, blind=args.blind)


def _page(run: Run, report: Report) -> ReportPage:
    from ..plots.report import simulated_page

    return simulated_page(run.over_time(), report, run.scenario)
