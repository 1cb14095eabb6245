"""``eventreg analyze``: events, rejection, residual and timing of a recorded bag. Needs no ROS."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from .. import scenario as scenarios
from ..analysis.bags import Recording, read_bag
from ..analysis.timing import timing
from ..analysis.verdict import EXIT_CODES, Report, Signals, judge, table
from ..errors import BagError
from ..parameters import TIME_SCALE
from ..scenario import Scenario
from .arguments import add_json, add_window, need_writable, write_json, write_text

if TYPE_CHECKING:
    from ..analysis.report import Run


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
    analysis = analyse(args.bag, args.scenario, args.settle, args.window, args.namespace)
    report = analysis.report
    print(table(report))
    print(timing_table(report), flush=True)
    write_json(args.json, report)
    if args.report is not None:
        from ..analysis.report import render

        write_text(args.report, render(analysis.run(args.bag.resolve().name)))
    return EXIT_CODES[report['verdict']]


@dataclass(frozen=True)
class Analysis:
    """A bag, what it was read with, and what came out."""

    recording: Recording
    scenario: Scenario | None
    settle: float
    window: float

    @property
    def monitor(self) -> tuple[float, float]:
        """Threshold and reset of the events."""
        return self.scenario.monitor if self.scenario else scenarios.monitor_defaults()

    @property
    def time_scale(self) -> float:
        """Model time units per second."""
        return self.scenario.time_scale if self.scenario else float(TIME_SCALE.default)

    @cached_property
    def signals(self) -> Signals:
        """The signals over model time."""
        return self.recording.in_model_time(self.time_scale)

    @cached_property
    def report(self) -> Report:
        """The contract's report."""
        threshold, reset = self.monitor
        report = judge(
            self.signals,
            scenario=self.scenario.name if self.scenario else 'unknown',
            time_scale=self.time_scale,
            threshold=threshold,
            reset=reset,
            settle=self.settle,
            window=self.window,
        )
        for name, entry in report['signals'].items():
            entry['timing'] = timing(self.recording.signals[name][0])
        return report

    def run(self, source: str) -> Run:
        """Return what the page with plots is made from."""
        from ..analysis.report import Run

        threshold, reset = self.monitor
        return Run(
            source=source,
            signals=self.signals,
            report=self.report,
            threshold=threshold,
            reset=reset,
            window=self.window,
            parameters=self.scenario.given if self.scenario else {},
            text=self.scenario.to_yaml() if self.scenario else None,
            start=self.recording.start,
        )


def analyse(
    bag: Path, given: str | None, settle: float, window: float, namespace: str | None = None
) -> Analysis:
    """Read a bag and its scenario. Raises BagError or ScenarioError."""
    recording = read_bag(bag, namespace)
    scenario = scenario_of(recording, given)
    if scenario is None:
        print(
            f'eventreg: the bag holds no scenario and --scenario is not given; taking time_scale '
            f'{TIME_SCALE.default:g}, threshold and reset by default',
            file=sys.stderr,
        )
    else:
        need_signals(bag, recording, scenario)
    return Analysis(recording, scenario, settle, window)


def report_on(bag: Path, given: str | None, settle: float, window: float) -> Report:
    """Return the contract's report on a bag. Raises BagError or ScenarioError."""
    return analyse(bag, given, settle, window).report


def scenario_of(recording: Recording, given: str | None) -> Scenario | None:
    """Return the scenario: the one given, else the bag's own, else None."""
    if given is not None:
        return scenarios.load(given)
    if recording.scenario is not None:
        return scenarios.parse(recording.scenario, recording.name or 'of the bag')
    return None


def need_signals(bag: Path, recording: Recording, scenario: Scenario) -> None:
    """Raise BagError when the bag lacks a signal that the scenario's nodes publish."""
    missing = [
        f'{signal} (of {node})'
        for signal, node in scenario.publishers.items()
        if not len(recording.signals.get(signal, ((),))[0])
    ]
    if missing:
        raise BagError(
            f'bag {bag} holds no sample of {", ".join(missing)}, which scenario {scenario.name} '
            'publishes; record it, or give the --scenario that the bag was made with'
        )


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
