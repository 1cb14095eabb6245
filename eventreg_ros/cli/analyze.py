"""``eventreg analyze``: events, rejection, residual and timing of a recorded bag. Needs no ROS."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..analysis.criteria import Criteria
from ..analysis.noise import table as noise_table
from ..analysis.recorded import analyze
from ..analysis.verdict import EXIT_CODES, Report, table
from ..files import need_writable
from ..scenario.table import TIME_SCALE
from .arguments import add_json, add_window, write_json, write_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``analyze``."""
    parser.add_argument('bag', metavar='BAG', type=Path, help='a rosbag2 directory, .mcap or .db3')
    parser.add_argument(
        '--scenario', metavar='S', help='the scenario, where the bag does not hold it'
    )
    parser.add_argument('--namespace', metavar='NS', help='read the topics of this namespace')
    add_json(parser)
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page with plots')
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Analyse the bag, print the table, and exit by the verdict."""
    need_writable(args.json)
    need_writable(args.report)
    analysis = analyze(
        args.bag,
        args.scenario,
        settle=args.settle,
        window=args.window,
        namespace=args.namespace,
    )
    if analysis.scenario is None:
        print(
            f'eventreg: the bag holds no scenario and --scenario is not given; taking time_scale '
            f'{TIME_SCALE.default:g}, threshold and reset by default',
            file=sys.stderr,
        )
    report = analysis.report
    print(table(report))
    print(timing_table(report), flush=True)
    if noise := noise_table(analysis.signals, Criteria(*analysis.monitor)):
        print(noise, flush=True)
    write_json(args.json, report)
    if args.report is not None:
        from ..plots.report import render, report_page

        write_text(args.report, render(report_page(analysis, args.bag.resolve().name)))
    return EXIT_CODES[report['verdict']]


def timing_table(report: Report) -> str:
    """Return the timing of each signal as a plain table, in milliseconds."""
    lines = [f'{"timing":>8} {"rate Hz":>9} {"p50 ms":>8} {"p99 ms":>8} {"max ms":>8} {"gaps":>5}']
    for name, entry in report['signals'].items():
        t = entry['timing']
        if t['rate'] is not None:
            lines.append(
                f'{name:>8} {t["rate"]:9.2f} {t["period_p50"] * 1e3:8.3f} '
                f'{t["period_p99"] * 1e3:8.3f} {t["period_max"] * 1e3:8.3f} {t["gaps"]:5d}'
            )
    return '\n'.join(lines)
