# SPDX-License-Identifier: Apache-2.0
"""``eventreg simulate``: the scenario offline, as one continuous system or as the nodes do it."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import EventregError
from ..files import need_writable
from .arguments import (
    add_at,
    add_blind,
    add_scenario,
    add_window,
    load_scenario,
    nonnegative,
    positive,
    warn,
    whole,
)
from .report_outputs import ReportOutputs, add_report_outputs

if TYPE_CHECKING:
    from ..analysis.verdict import Report
    from ..api import Run
    from ..plots.report import ReportPage
    from ..scenario import Scenario

IMPAIRMENTS = ('delay', 'loss', 'jitter', 'noise', 'seed', 'on')


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
    parser.add_argument(
        '--delay', type=nonnegative, metavar='D', help='of every link, model time (0); --sampled'
    )
    parser.add_argument(
        '--loss', type=_probability, metavar='P', help='probability per sample (0); --sampled'
    )
    parser.add_argument(
        '--jitter', type=nonnegative, metavar='J',
        help='extra delay of each sample, uniform from 0 to J, model time (0); --sampled',
    )  # fmt: skip
    parser.add_argument(
        '--noise', type=nonnegative, metavar='SD',
        help="white noise on every sample of a plant's output: its standard deviation (0)",
    )  # fmt: skip
    parser.add_argument('--seed', type=whole(0), metavar='N', help='of loss, jitter and noise (0)')
    parser.add_argument(
        '--on', type=_names, metavar='SIGNAL,...',
        help='the signals whose links are impaired (all); --sampled',
    )  # fmt: skip
    add_at(parser, 'T', 'model time')
    parser.add_argument(
        '--out', type=Path, metavar='F', help='write the signals: .npz, .csv, .parquet'
    )
    parser.add_argument('--bag', type=Path, metavar='DIR', help='write the signals as a rosbag2')
    add_report_outputs(parser)
    add_window(parser)
    add_blind(parser)


def main(args: argparse.Namespace) -> int:
    """Run ``eventreg simulate`` and return the verdict's exit code."""
    from ..analysis.report_table import table
    from ..api import judge, simulate

    outputs, impairments = ReportOutputs.of(args), _check(args)
    scenario = load_scenario(args)
    _ = scenario.rate, scenario.time_scale  # raises unless all nodes, stimulus too, agree
    duration = _duration(args, scenario)
    run = simulate(scenario, duration, sampled=args.sampled, at=args.at, **impairments)
    report = judge(run, args.settle, args.window, blind=args.blind)
    print(table(report), flush=True)
    warn(report.evidence.warnings)
    _warn_of_rounding(args.delay, scenario)
    _write(args, run)
    outputs.write(report, lambda: _page(run, report))
    return report.exit_code


def _duration(args: argparse.Namespace, scenario: Scenario) -> float:
    """Return the duration, in model time. Raises EventregError for what would fail afterwards."""
    from ..analysis.export import check_names
    from ..analysis.recorded import need_span

    if args.out is not None:
        check_names(args.out, scenario.publishers)
    criteria = scenario.criteria.overridden(settle=args.settle, window=args.window)
    duration = criteria.duration(400.0) if args.duration is None else float(args.duration)
    need_span(criteria, duration, settle=args.settle, until=None)
    return duration


def _warn_of_rounding(delay: float | None, scenario: Scenario) -> None:
    h = scenario.time_scale / scenario.rate
    if not math.isfinite((delay or 0.0) / h):
        return
    used = round((delay or 0.0) / h) * h
    if abs(used - (delay or 0.0)) > 1e-9 * h:
        print(
            f'eventreg: --delay {delay:g} was rounded to {used:g}, whole steps of {h:g}; '
            f'a higher rate has finer ones',
            file=sys.stderr,
        )


def _check(args: argparse.Namespace) -> dict[str, Any]:
    """Return the impairments that were given. Raises EventregError before any work is done."""
    from ..analysis.export import check_path

    given = {name: getattr(args, name) for name in IMPAIRMENTS}
    given = {name: value for name, value in given.items() if value is not None}
    free = {'noise', 'seed'} if 'noise' in given else set()
    bound = [name for name in given if name not in free]
    if bound and not args.sampled:
        raise EventregError(
            f'--{bound[0]} needs --sampled: without it the loop is one continuous system '
            f'that has no links; add --sampled'
        )
    if args.out is not None:
        check_path(args.out)
        need_writable(args.out)
    if args.bag is not None and args.bag.exists():
        raise EventregError(f'bag {args.bag} exists already; remove it or name another directory')
    return given


def _write(args: argparse.Namespace, run: Run) -> None:
    if args.out is not None:
        from ..analysis.export import write_signals

        write_signals(args.out, run.t, run.signals)
    if args.bag is not None:
        run.to_bag(args.bag, settle=args.settle, window=args.window, blind=args.blind)


def _page(run: Run, report: Report) -> ReportPage:
    from ..plots.report import simulated_page

    return simulated_page(run.over_time(), report, run.scenario)


def _names(text: str) -> list[str]:
    names = [name for name in text.split(',') if name]
    if not names:
        raise argparse.ArgumentTypeError(f'must name signals (y,u), got {text!r}')
    return names


def _probability(text: str) -> float:
    value = nonnegative(text)
    if value > 1.0:
        raise argparse.ArgumentTypeError(f'must be a probability from 0 to 1, got {text!r}')
    return value
