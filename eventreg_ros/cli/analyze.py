# SPDX-License-Identifier: Apache-2.0
"""``eventreg analyze``: events, rejection, residual and timing of a recorded bag. Needs no ROS."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..analysis.noise import table as noise_table
from ..analysis.recorded import analyze
from ..analysis.report_table import table
from ..analysis.verdict import Report
from ..bags.files import newest
from ..errors import EventregError
from ..scenario.table import TIME_SCALE
from .arguments import add_blind, add_reading, add_span, add_window, warn
from .report_outputs import ReportOutputs, add_report_outputs, recorded_page


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``analyze``."""
    parser.add_argument(
        'bag', metavar='BAG', type=Path, nargs='?', help='a rosbag2 directory, .mcap or .db3'
    )
    parser.add_argument(
        '--last', action='store_true', help='the newest bag that eventreg made in this directory'
    )
    add_reading(parser)
    add_report_outputs(parser)
    add_window(parser)
    add_span(parser)
    add_blind(parser)


def main(args: argparse.Namespace) -> int:
    """Analyse the bag, print the table, and exit by the verdict."""
    outputs = ReportOutputs.of(args)
    bag = _bag(args)
    analysis = analyze(
        bag,
        args.scenario,
        settle=args.settle if args.start is None else args.start,
        window=args.window,
        blind=args.blind,
        until=args.until,
        lenient=args.lenient,
        namespace=args.namespace,
        topics=args.topics,
        time=args.time,
    )
    report = analysis.report  # first: what it refuses is one line
    if analysis.scenario is None:
        print(
            f'eventreg: the bag holds no scenario and --scenario is not given; taking time_scale '
            f'{TIME_SCALE.default:g}, threshold and reset by default',
            file=sys.stderr,
        )
    warn(report.evidence.warnings)
    print(timing_table(report, analysis.recording.time))
    if noise := noise_table(analysis.signals, analysis.criteria):
        print(noise)
    print(table(report), flush=True)
    outputs.write(report, lambda: recorded_page(analysis, bag))
    return report.exit_code


def _bag(args: argparse.Namespace) -> Path:
    """Return the bag that was asked for. Raises EventregError unless it is one."""
    if args.last and args.bag is not None:
        raise EventregError(f'analyze takes a bag or --last, got {args.bag} and --last; drop one')
    if args.last:
        bag = newest(Path())
        print(f'eventreg: analyzing {bag}', file=sys.stderr)
        return bag
    if args.bag is None:
        raise EventregError('analyze needs a bag: give its path, or --last')
    return Path(args.bag)


def timing_table(report: Report, time: str) -> str:
    """Return the timing of each signal as a plain table, in milliseconds; ``time``: by which."""
    lines = [f'{"timing":>8} {"rate Hz":>9} {"p50 ms":>8} {"p99 ms":>8} {"max ms":>8} {"gaps":>5}']
    for name, signal in report.signals.items():
        t = signal.timing
        if t is None or t.rate is None:
            continue
        periods = (t.period_p50, t.period_p99, t.period_max)
        times = ' '.join(f'{period * 1e3:8.3f}' for period in periods if period is not None)
        lines.append(f'{name:>8} {t.rate:9.2f} {times} {t.gaps:5d}')
    lines.append(f'by the {time} times of the messages')
    return '\n'.join(lines)
