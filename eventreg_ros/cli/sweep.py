# SPDX-License-Identifier: Apache-2.0
"""``eventreg sweep``: the sampled loop over many sets of parameters. Needs no ROS.

docs/sweeps.md says what may vary and what the table holds, docs/json.md what ``--json F`` writes.
The exit code is 0 whatever is found, 2 for bad input, 130 when it was stopped.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..files import need_writable
from .arguments import add_json, add_scenario, add_window, check_plot, positive, whole, write_json
from .impairments import signal_names
from .progress import Count, say_if_slow
from .sweep_questions import border, draw, plan_of, table, worst


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg sweep``."""
    add_scenario(parser)
    parser.add_argument('--sets', type=whole(1), metavar='N', help='draw N sets at random')
    parser.add_argument('--seed', type=whole(0), default=0, metavar='S', help='of the draws (0)')
    parser.add_argument(
        '--sobol', action='store_true', help="draw from Sobol's sequence; N must be a power of 2"
    )
    parser.add_argument(
        '--indices', action='store_true',
        help='which parameter matters: N (parameters + 2) sets, variance-based indices by SALib',
    )  # fmt: skip
    parser.add_argument(
        '--border', metavar='X,Y',
        help='only the border between rejected and not over two ranges, X and Y of the -p; '
        'followed as a periodic orbit where it is one',
    )  # fmt: skip
    parser.add_argument(
        '--worst', type=whole(5), metavar='N',
        help='search the ranges with N runs for the set that comes nearest to an event',
    )  # fmt: skip
    parser.add_argument(
        '--on',
        type=signal_names,
        metavar='SIGNAL,...',
        help='signals whose links are impaired (all)',
    )
    parser.add_argument('--duration', type=positive, metavar='T', help='of a run, model time (400)')
    parser.add_argument(
        '--out', type=Path, metavar='DIR',
        help='keep the table (sweep.parquet, or sweep.csv where DIR ends in .csv), and go on there',
    )  # fmt: skip
    parser.add_argument(
        '--engine', choices=('local', 'dask'), default='local', help='where it runs (local)'
    )
    parser.add_argument(
        '--scheduler', metavar='ADDR', help='of a Dask cluster (none: a worker per processor here)'
    )
    parser.add_argument('--plot', type=Path, metavar='F', help='draw it: .png .svg .pdf')
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page')
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Run the sweep, print what came of it, write what was asked for, and return 0."""
    check_plot(args.plot)
    need_writable(args.json)
    need_writable(args.report)
    plan = plan_of(args)
    say_if_slow('sets run one by one in plain Python, about a thousand times slower')
    count = Count(slow=1)
    ask = border if args.border else worst if args.worst is not None else table
    if ask is table and (args.plot is not None or args.report is not None):
        from ..plots.sweep_plot import need_picture

        need_picture(plan)
    try:
        found = ask(args, plan, count.show)
    except KeyboardInterrupt:
        kept = f'; what is done is in {args.out}, the same command goes on' if args.out else ''
        count.clear()
        print(f'eventreg: stopped{kept}', file=sys.stderr)
        raise
    count.clear()
    print(found.text, flush=True)
    write_json(args.json, found.result)
    if args.plot is not None or args.report is not None:
        draw(args, plan, found)
    return 0
