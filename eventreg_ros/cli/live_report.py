# SPDX-License-Identifier: Apache-2.0
"""What is printed and written of a run of the nodes."""

from __future__ import annotations

import sys

from ..analysis.rejection import REJECTED
from ..analysis.report_table import table
from ..session.live import LiveRun
from . import live_timing
from .arguments import warn
from .process import fail
from .report_outputs import ReportOutputs, recorded_page

BROKEN = 4
"""Exit code when a node died during the run; the verdict's codes are those of the contract."""


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
    for line in live_timing.short_leads(found.warnings):
        print(f'eventreg: {line}', file=sys.stderr)
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
