# SPDX-License-Identifier: Apache-2.0
"""Which of the nodes' warnings are shown after a run: those that can matter to the verdict."""

import pytest

from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.cli import live_timing
from eventreg_ros.cli.live_report import show
from eventreg_ros.cli.report_outputs import ReportOutputs
from eventreg_ros.nodes.lead import Lead
from eventreg_ros.runtime.figures import LATE, Percentiles, TickFigures
from eventreg_ros.session.live import LiveRun

LATE_TICK = f'{LATE} 1.6 steps late'
DELAY = 'the measured delay of w (35.0 ms, 0.350 of model time) comes near the delay margin (0.4)'


def test_late_ticks_alone_do_not_matter_and_everything_else_does():
    warnings = {
        'plant': [LATE_TICK, LATE_TICK],
        'controller': [f'{LATE_TICK}; {DELAY}', LATE_TICK],
        'exosystem': ['12 steps dropped'],
    }
    assert live_timing.matters(warnings) == {
        'controller': [f'{LATE_TICK}; {DELAY}'],
        'exosystem': ['12 steps dropped'],
    }


def test_a_lead_that_is_too_short_is_named_with_the_one_that_is_not(capsys, make_bag):
    leads = [Lead(40, 0.05, 10.0).complaint('u_link', delay, 5) for delay in (0.205, 0.231, 0.21)]
    warnings = {'plant': [f'{LATE_TICK}; {leads[0]}', *leads[1:]], 'exosystem': [LATE_TICK]}
    words = 'plant: in 3 seconds samples came after their time; set -p /**.lead:=2.35'
    assert live_timing.short_leads(warnings) == [words]
    analysis = analyze(make_bag(w=[110, 140, 170, 200], y=[], u=[]))
    show(LiveRun(analysis.scenario, 'bag', analysis, warnings=warnings), ReportOutputs())
    assert f'eventreg: {words}\n' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('warning', 'timing', 'y', 'shown'),
    [
        (LATE_TICK, False, [], False),
        (LATE_TICK, True, [], True),
        (DELAY, False, [], False),
        (LATE_TICK, False, [170], False),
        (DELAY, False, [170], True),
    ],
)
def test_the_tables_come_when_asked_for_or_when_they_may_be_why_nothing_was_rejected(
    capsys, make_bag, warning, timing, y, shown
):
    analysis = analyze(make_bag(w=[110, 140, 170, 200], y=y, u=[]))
    ticks = TickFigures(800, 0, 0, 0, 0, Percentiles(0.0002, 0.0012, 0.008))
    measured = {'plant': {key: str(value) for key, value in ticks.values().items()}}
    found = LiveRun(
        analysis.scenario, 'bag', analysis, measured=measured, warnings={'plant': [warning]}
    )
    show(found, ReportOutputs(), timing)
    out = capsys.readouterr().out
    assert ('late p50' in out) == shown
    assert (warning in out) == shown
    assert out.splitlines()[-1] == f'verdict: {"not " if y else ""}rejected'
