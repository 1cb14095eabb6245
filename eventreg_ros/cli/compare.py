# SPDX-License-Identifier: Apache-2.0
"""``eventreg compare``: several runs side by side, bags or scenarios. Needs no ROS.

``--json F`` writes what :func:`.analysis.comparison_words.as_json` returns. The exit code is 0
whatever differs, and 2 for bad input.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import EventregError
from ..files import need_writable, writing
from .arguments import add_json, add_window, check_plot, warn, write_json, write_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..plots.comparison_plot import Shown
    from ..session.judged import Judged


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg compare``."""
    parser.add_argument(
        'runs', nargs='+', metavar='RUN',
        help='a bag, or a scenario, which is simulated; a bag called like a scenario is ./NAME',
    )  # fmt: skip
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page with plots')
    parser.add_argument(
        '--plot', type=Path, metavar='F', help='draw the signals over each other: .png .svg .pdf'
    )
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Compare the runs, print the tables, write what was asked for, and return 0."""
    from ..analysis.comparison import distinct
    from ..analysis.comparison_words import as_json, table
    from ..api import compare, open_run

    if len(args.runs) < 2:
        raise EventregError(f'compare takes two runs or more, got {args.runs[0]}; name another')
    check_plot(args.plot)
    need_writable(args.json)
    need_writable(args.report)
    opened = [open_run(run, args.settle, args.window) for run in args.runs]
    names = distinct([Path(run).resolve().name for run in args.runs])
    found = compare(*opened, names=names, settle=args.settle, window=args.window)
    for name, run in zip(names, opened, strict=True):
        warn(run.report.evidence.warnings, name)
    print(table(found), flush=True)
    write_json(args.json, as_json(found))
    if args.report is not None:
        from ..plots.comparison_page import render_comparison

        write_text(args.report, render_comparison(found, _shown(names, opened)))
    if args.plot is not None:
        _draw(args.plot, _shown(names, opened))
    return 0


def _shown(names: Sequence[str], runs: Sequence[Judged]) -> list[Shown]:
    """Return the runs as they are drawn."""
    from ..plots.comparison_plot import Shown

    return [
        Shown(
            name,
            run.over_time(),
            {s: entry.events for s, entry in run.report.signals.items()},
        )
        for name, run in zip(names, runs, strict=True)
    ]


def _draw(path: Path, runs: Sequence[Shown]) -> None:
    from ..plots.comparison_plot import draw_comparison
    from ..plots.style import save

    picture = draw_comparison(runs)
    with writing(path) as file:
        save(picture, file)
