"""``eventreg run``: the scenario's nodes as processes over real topics, recorded and judged."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..analysis.verdict import EXIT_CODES, table
from ..errors import EventregError
from ..parameters import resolve
from ..scenario import Scenario
from .analyze import report_on
from .arguments import add_json, add_scenario, add_window, load_scenario, positive, write_json
from .domain import loopback_domain
from .main import fail
from .processes import Processes, node_command

if TYPE_CHECKING:
    from ..nodes.conductor import Conductor

BROKEN = 4
"""Exit code when a node died on the way; the verdict's codes are those of the contract."""

LEAD = 1.0
"""Seconds between the activation of the nodes and the first sample."""


class InterruptError(Exception):
    """SIGINT or SIGTERM: stop early, and judge what was recorded."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``run``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, default=40.0, metavar='S', help='seconds to run (40)'
    )
    parser.add_argument('--bag', type=Path, metavar='DIR', help='directory of the bag, made new')
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Run, record, analyse; see the contract for the exit codes."""
    scenario = load_scenario(args)
    bag = args.bag or Path(time.strftime(f'eventreg_{scenario.name}_%Y_%m_%d-%H_%M_%S'))
    if bag.exists():
        raise EventregError(f'bag {bag} exists already; remove it or give another --bag')
    need_rclpy()
    run = Run(scenario, bag, args.duration)
    run.perform()
    died = [f'{node} {how}' for node, how in run.processes.died.items()]
    try:
        report = report_on(bag, None, args.settle, args.window)
    except EventregError as error:
        if not died:
            raise
        fail(f'{"; ".join(died)} during the run; {error}')
        return BROKEN
    write_json(args.json, report)
    print(f'bag: {bag}')
    print(table(report))
    if died:
        fail(f'{"; ".join(died)} during the run')
        return BROKEN
    return EXIT_CODES[report['verdict']]


def need_rclpy() -> None:
    """Raise EventregError when there is no ROS."""
    try:
        import rclpy  # noqa: F401
    except ImportError as error:
        raise EventregError(
            f"run needs ROS 2 ({error}): source your ROS setup, or pip install 'eventreg_ros[ros]'"
        ) from None


def complete(scenario: Scenario, bag: Path, file: Path) -> Scenario:
    """Return the scenario with its spike monitor and a recorder of every signal."""
    nodes = {name: dict(values) for name, values in scenario.nodes.items()}
    given = {name: dict(values) for name, values in scenario.given.items()}
    signals = list(scenario.publishers)
    own: dict[str, dict[str, Any]] = {
        'spike_monitor': {} if 'spike_monitor' in given else {'signals': signals},
        'recorder': {
            'signals': signals,
            'path': str(bag.absolute()),
            'scenario': str(file),
            'scenario_name': scenario.name,
        },
    }
    for node, values in own.items():
        given[node] = {**given.get(node, {}), **values}
        nodes[node] = resolve(node, given[node])
    return Scenario(scenario.name, nodes, given)


class Run:
    """One run from the first process to the last."""

    def __init__(self, scenario: Scenario, bag: Path, duration: float) -> None:
        self.scenario = scenario
        self.bag = bag
        self.duration = duration
        self.processes = Processes()
        self.started = False

    def perform(self) -> None:
        """Start everything, run for the duration, stop everything.

        Raises EventregError when it could not start or the recorder died.
        """
        scratch = Path(tempfile.mkdtemp(prefix='eventreg_'))
        try:
            with interruptible(), loopback_domain(os.environ) as environment:
                self._within(scratch, environment)
        except InterruptError:
            if not self.started:
                raise EventregError(
                    'interrupted before the first sample; nothing recorded'
                ) from None
            print('interrupted: judging what was recorded', file=sys.stderr)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)

    def _within(self, scratch: Path, environment: dict[str, str]) -> None:
        stored = scratch / f'{self.scenario.name}.yaml'
        stored.write_text(self.scenario.to_yaml(), encoding='utf-8')
        whole = complete(self.scenario, self.bag, stored)
        parameters = scratch / 'parameters.yaml'
        parameters.write_text(whole.to_yaml(), encoding='utf-8')
        os.environ.update(environment)
        from ..nodes.conductor import Conductor

        print(
            f'{self.scenario.name}: {", ".join(whole.nodes)} on ROS_DOMAIN_ID='
            f'{environment["ROS_DOMAIN_ID"]} ROS_AUTOMATIC_DISCOVERY_RANGE='
            f'{environment["ROS_AUTOMATIC_DISCOVERY_RANGE"]}',
            flush=True,
        )
        arguments = ['--params-file', str(parameters), '-p', 'autostart:=false']
        try:
            for node in whole.nodes:
                command = node_command(node, [*arguments, '--log-level', 'WARN'])
                self.processes.start(node, command, environment)
            with Conductor(self._refuse_death) as conductor:
                self._conduct(conductor, whole.nodes)
        finally:
            with uninterrupted():
                self.processes.stop(['recorder'])  # first, so that the bag ends with all signals
                self.processes.stop()

    def _refuse_death(self) -> None:
        for node in self.processes.look():
            raise EventregError(f'{node} {self.processes.died[node]} before the run began')

    def _conduct(self, conductor: Conductor, nodes: Mapping[str, Mapping[str, Any]]) -> None:
        from ..nodes.conductor import ACTIVATE, CONFIGURE, expected_matches

        conductor.watch(nodes['spike_monitor']['signals'])
        conductor.transition(list(nodes), CONFIGURE)
        conductor.wait_matched(expected_matches(nodes), 30.0)
        start = conductor.now() + LEAD
        conductor.set_start([n for n, values in nodes.items() if 'start_time' in values], start)
        conductor.transition(['recorder', 'spike_monitor'], ACTIVATE)
        conductor.transition([n for n in nodes if n not in ('recorder', 'spike_monitor')], ACTIVATE)
        if conductor.now() > start:
            raise EventregError('the nodes took too long to start; is the machine busy?')
        self.started = True
        progress = Progress(self.duration)
        while (elapsed := conductor.now() - start) < self.duration:
            conductor.wait(min(0.1, max(0.001, self.duration - elapsed)))
            self._tell_deaths(elapsed)
            progress.show(max(0.0, elapsed), conductor.counts)
        progress.show(self.duration, conductor.counts, last=True)

    def _tell_deaths(self, elapsed: float) -> None:
        for node in self.processes.look():
            how = self.processes.died[node]
            if node == 'recorder':
                raise EventregError(f'the recorder {how} after {elapsed:.1f} s; see {self.bag}')
            print(
                f'\neventreg: {node} {how} after {elapsed:.1f} s; the others run on, and it may be '
                f'started again: ros2 run eventreg_ros {node}',
                file=sys.stderr,
                flush=True,
            )


class Progress:
    """Time and event counts: one line that is written over, or, in a file, one every 5 s."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._terminal = sys.stdout.isatty()
        self._next = 0.0

    def show(self, elapsed: float, counts: Mapping[str, int], last: bool = False) -> None:
        """Show the counts at ``elapsed`` seconds, if it is time to."""
        if elapsed < self._next and not last:
            return
        self._next = elapsed + (0.2 if self._terminal else 5.0)
        events = '  '.join(f'{signal} {count}' for signal, count in counts.items())
        line = f'{elapsed:6.1f} of {self._duration:g} s   events: {events}'
        end = '\n' if last or not self._terminal else ''
        print(f'\r{line}' if self._terminal else line, end=end, flush=True)


@contextmanager
def interruptible() -> Iterator[None]:
    """Turn SIGINT and SIGTERM into InterruptError, once; a second one is ignored while we stop."""

    def interrupt(number: int, frame: object) -> None:
        for each in (signal.SIGINT, signal.SIGTERM):
            signal.signal(each, signal.SIG_IGN)
        raise InterruptError

    before = {each: signal.signal(each, interrupt) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let nothing stop the stopping."""
    before = {each: signal.signal(each, signal.SIG_IGN) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
