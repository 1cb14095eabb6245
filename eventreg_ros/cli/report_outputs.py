# SPDX-License-Identifier: Apache-2.0
"""The files that a report may go to: JSON, JUnit, a page, a picture. For every verb that judges."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..analysis.report_json import as_json
from ..analysis.verdict import Report
from ..files import need_writable, writing
from .arguments import add_json, check_plot, write_json, write_text

if TYPE_CHECKING:
    from ..analysis.recorded import Analysis
    from ..bags.finding import Finding
    from ..plots.report import ReportPage


def add_report_outputs(parser: argparse.ArgumentParser) -> None:
    """Add --json, --junit, --report and --plot."""
    add_json(parser)
    parser.add_argument(
        '--junit', type=Path, metavar='F.xml', help='write the verdict as a JUnit test, for CI'
    )
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page with plots')
    parser.add_argument(
        '--plot', type=Path, metavar='F', help="draw it for a paper's column: .png .svg .pdf"
    )


class ReportOutputs(NamedTuple):
    """Where a report is to be written; None: not asked for."""

    json: Path | None = None
    junit: Path | None = None
    report: Path | None = None
    plot: Path | None = None

    @classmethod
    def of(cls, args: argparse.Namespace) -> ReportOutputs:
        """Return what :func:`add_report_outputs` asked for, checked before any work is done.

        Raises EventregError for what cannot be written.
        """
        found = cls(args.json, args.junit, args.report, args.plot)
        check_plot(found.plot)
        for path in found:
            need_writable(path)
        return found

    def write(self, report: Report, page: Callable[[], ReportPage]) -> None:
        """Write ``report``; ``page`` is called where a page or a picture is made of it."""
        write_json(self.json, as_json(report))
        if self.junit is not None:
            from ..analysis.junit import as_junit

            write_text(self.junit, as_junit(report))
        if self.report is not None:
            from ..plots.report import render

            write_text(self.report, render(page()))
        if self.plot is not None:
            _draw(self.plot, page())


def recorded_page(
    analysis: Analysis, bag: Path, noted: Sequence[Finding] = (), measured: str = ''
) -> ReportPage:
    """Return what the page on a bag is made from; see :func:`.plots.report.report_page`."""
    from ..analysis.delays import delay_findings
    from ..plots.report import report_page

    found = [*delay_findings(bag, analysis), *noted]
    return report_page(analysis, Path(bag).resolve().name, found, measured)


def _draw(path: Path, page: ReportPage) -> None:
    from ..plots.run_plot import COLUMN, draw_report
    from ..plots.style import save

    picture = draw_report(page.signals, page.report, COLUMN)
    with writing(path) as file:
        save(picture, file)
