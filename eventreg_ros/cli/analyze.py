"""``eventreg analyze``: events, rejection, residual and timing of a recorded bag. Needs no ROS."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..analysis.junit import as_junit
from ..analysis.noise import table as noise_table
from ..analysis.recorded import Analysis, analyze
from ..analysis.report_json import as_json
from ..analysis.report_table import table
from ..analysis.verdict import Report
from ..files import need_writable, writing
from ..scenario.table import TIME_SCALE
from .arguments import add_json, add_span, add_window, check_plot, warn, write_json, write_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``analyze``."""
    parser.add_argument('bag', metavar='BAG', type=Path, help='a rosbag2 directory, .mcap or .db3')
    parser.add_argument(
        '--scenario', metavar='S', help='the scenario, where the bag does not hold it'
    )
    parser.add_argument('--namespace', metavar='NS', help='read the topics of this namespace')
    parser.add_argument(
        '--topic', action='append', default=[], dest='topics', metavar='SIGNAL:=TOPIC[:FIELD]',
        help='where a signal is, in messages of any type (y:=/arm/joint_states:velocity[2]); '
        'may be repeated',
    )  # fmt: skip
    parser.add_argument(
        '--time', choices=('log', 'publish', 'header'),
        help='the stamps that count (publish, where they are plausible)',
    )  # fmt: skip
    add_json(parser)
    parser.add_argument('--junit', type=Path, metavar='F.xml', help='write the verdict for CI')
    parser.add_argument(
        '--plot', type=Path, metavar='F', help='draw signals and events: .png .svg .pdf'
    )
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page with plots')
    add_window(parser)
    add_span(parser)


def main(args: argparse.Namespace) -> int:
    """Analyse the bag, print the table, and exit by the verdict."""
    need_writable(args.json)
    need_writable(args.report)
    need_writable(args.junit)
    check_plot(args.plot)
    analysis = analyze(
        args.bag,
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
    if analysis.scenario is None:
        print(
            f'eventreg: the bag holds no scenario and --scenario is not given; taking time_scale '
            f'{TIME_SCALE.default:g}, threshold and reset by default',
            file=sys.stderr,
        )
    report = analysis.report
    warn(report.evidence.warnings)
    print(table(report))
    print(timing_table(report), flush=True)
    if noise := noise_table(analysis.signals, analysis.criteria):
        print(noise, flush=True)
    write_json(args.json, as_json(report))
    if args.report is not None:
        from ..plots.report import render, report_page

        write_text(args.report, render(report_page(analysis, args.bag.resolve().name)))
    if args.junit is not None:
        write_text(args.junit, as_junit(report))
    if args.plot is not None:
        draw(args.plot, analysis)
    return report.exit_code


def draw(path: Path, analysis: Analysis) -> None:
    """Draw the run and write it to ``path``. Raises EventregError when it cannot."""
    from ..plots.style import save
    from ..session.bag import Recorded

    picture = Recorded(analysis).plot()
    with writing(path) as file:
        save(picture, file)


def timing_table(report: Report) -> str:
    """Return the timing of each signal as a plain table, in milliseconds."""
    lines = [f'{"timing":>8} {"rate Hz":>9} {"p50 ms":>8} {"p99 ms":>8} {"max ms":>8} {"gaps":>5}']
    for name, signal in report.signals.items():
        t = signal.timing
        if t is None or t.rate is None:
            continue
        periods = (t.period_p50, t.period_p99, t.period_max)
        times = ' '.join(f'{period * 1e3:8.3f}' for period in periods if period is not None)
        lines.append(f'{name:>8} {t.rate:9.2f} {times} {t.gaps:5d}')
    return '\n'.join(lines)
