# SPDX-License-Identifier: Apache-2.0
"""One run from the first process to the last: everything is started, conducted, and ended."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import EventregError
from ..files import scratch_directory
from ..nodes.environment import domain_of
from ..runtime.figures import WAITING_FOR
from ..scenario import Scenario
from ..scenario.interventions import Intervention
from ..scenario.names import kind_of
from . import shared_memory
from .domain import is_inhabited, own_domain, turn
from .executables import executable_of, package_and_executable
from .interruption import InterruptError, Interruption, handling, uninterrupted
from .loopback import Reach, address, closed, opened
from .noted import Noted
from .observer import Observer
from .processes import Processes, node_command
from .running import announced

if TYPE_CHECKING:
    from .client import Client

LEAD = 1.5
"""Seconds between the activation of the nodes and the first sample."""

SILENCE = 10.0
"""Seconds without diagnostics, which come once a second, after which the clock counts as dead."""

LONG = 0.5
"""Seconds that pass between two looks at most; what is more was a stop of our own."""

FIRST_STEP = 30.0
"""Seconds within which all nodes must have made their first sample in lockstep."""

PATIENCE = 30.0
"""Seconds within which a node must do what is asked of it, if the run lasts as long."""

GRACE = 1.0
"""Seconds that a node is given for it even where the run is about to end."""

FIRST, LAST = ('recorder', 'spike_monitor'), ('clock',)
"""Nodes that are activated before and after the others."""


class Session:
    """Runs a scenario's nodes as processes and records them."""

    def __init__(
        self,
        scenario: Scenario,
        bag: Path,
        duration: float,
        *,
        lockstep: bool = False,
        composed: bool = False,
        observer: Observer | None = None,
        interventions: Sequence[Intervention] = (),
        network: bool = False,
    ) -> None:
        self.scenario = (scenario.with_stated_delays() if lockstep else scenario).with_codings()
        self.bag = bag
        self.duration = duration
        self.lockstep = lockstep
        self.composed = composed
        self.network = network
        self.observer = observer or Observer()
        self.pending = list(interventions)
        """The interventions that are still to come, in order; times in seconds."""
        self.processes = Processes()
        self._interruption = Interruption()
        self.troubles: list[str] = []
        """What went wrong after the start, each in words."""
        self._silent = self._without_step = 0.0
        self._elapsed: Callable[[], float] = lambda: 0.0
        self._gone: set[str] = set()
        """The nodes that died and have not been heard since; one may be started again by hand."""
        self._left: set[str] = set()
        """Those of them whose name is not in the graph any more."""
        self.started = False
        self.over = False
        """Whether what died makes going on pointless."""
        self.timing: dict[str, dict[str, str]] = {}
        """What each node measured of its own time, as its diagnostics say it."""
        self.warnings: dict[str, list[str]] = {}
        self.noted: list[Noted] = []
        """The same with its times."""

    def perform(self) -> None:
        """Start everything, run for the duration, stop everything.

        Raises EventregError when it could not start, KeyboardInterrupt when it was interrupted
        before it did.
        """
        self._refuse_composed_foreign()
        named = bool(os.environ.get('ROS_DOMAIN_ID'))
        shared_memory.sweep()
        try:
            with (
                scratch_directory() as scratch,
                handling(self._interruption),
                own_domain(os.environ) as environment,
            ):
                reach = opened(environment) if self.network else closed(environment, scratch)
                self._within(scratch, reach, named)
        except InterruptError:
            if not self.started:
                self.observer.warned('interrupted before it began; nothing recorded')
                raise KeyboardInterrupt from None
            self.observer.warned('interrupted: judging what was recorded')
            for each in self.pending:
                self.observer.warned(f'at {each.text} was not done')

    def _refuse_composed_foreign(self) -> None:
        foreign = self.scenario.foreign
        if self.composed and foreign:
            raise EventregError(
                f'--composed runs nodes of eventreg_ros only, got {", ".join(foreign)} of another '
                'package; leave out --composed'
            )

    def _within(self, scratch: Path, reach: Reach, named: bool) -> None:
        stored = scratch / 'scenario' / f'{self.scenario.name}.yaml'
        stored.parent.mkdir()
        stored.write_text(self.scenario.to_yaml(), encoding='utf-8')
        whole = self.scenario.with_recorder(str(self.bag.absolute()), str(stored))
        if self.lockstep:  # the clock waits at whole steps only
            rate = whole.rate
            self.pending = [p._replace(at=round(p.at * rate) / rate) for p in self.pending]
            whole = whole.in_lockstep(self.duration, [each.at for each in self.pending])
            self.duration = whole.nodes['clock']['steps'] / whole.rate
        parameters = scratch / 'parameters.yaml'
        parameters.write_text(whole.to_yaml(), encoding='utf-8')
        from .client import Client

        self.observer.began(
            f'{self.scenario.name}: {", ".join(whole.nodes)} on {address(reach.client)}'
        )
        for note in reach.notes:
            self.observer.warned(note)
        nodes = tuple(whole.nodes)
        self._interruption.look()
        domain = domain_of(reach.client)
        self._memory = shared_memory.Notes(scratch, domain)
        try:
            with ExitStack() as beginning:
                beginning.enter_context(turn(domain, self._interruption.look))
                look = named and (self.network or is_inhabited(domain))
                with Client(self._go_on, nodes, reach.client) as client:
                    if look:
                        client.need_room(nodes, list(whole.publishers))
                    self._start(whole, parameters, reach.nodes)
                    with announced(self.scenario.name, nodes, reach.client):
                        elapsed = self._activate(client, whole)
                        beginning.close()
                        self._conduct(client, elapsed)
        finally:
            with uninterrupted():
                self.processes.stop(['recorder'])  # first, so that the bag ends with all signals
                self.processes.stop()
                shared_memory.remove_noted(scratch)

    def _start(self, scenario: Scenario, parameters: Path, environment: dict[str, str]) -> None:
        arguments = ['--params-file', str(parameters), '-p', 'autostart:=false']
        arguments += ['--log-level', 'WARN']
        if self.composed:
            command = node_command('composed', arguments, list(scenario.nodes))
            self.processes.start('the process of all nodes', command, environment)
            return
        for node in scenario.nodes:
            command = [*executable_of(scenario, node), '--ros-args', *arguments, *_named(node)]
            self.processes.start(node, command, environment)

    def _go_on(self) -> None:
        """Raise an error when waiting makes no sense any more."""
        self._interruption.look()
        self._note_memory(every=0.3)
        for node in self.processes.look():
            raise EventregError(f'{node} {self.processes.died[node]} before the run began')

    def _note_memory(self, every: float = 0.0) -> None:
        self._memory.take((each.pid for each in self.processes.running.values()), every)

    def _activate(self, client: Client, whole: Scenario) -> Callable[[], float]:
        """Configure and activate all nodes; return the seconds since the first sample."""
        from .client import ACTIVATE, CONFIGURE, expected_matches

        nodes = list(whole.nodes)
        client.watch(whole.nodes['spike_monitor']['signals'])
        client.transition(nodes, CONFIGURE)
        client.wait_matched(expected_matches(whole), 30.0)
        self._note_memory()
        if self.lockstep:
            elapsed = self._step_clock(client, whole)
        else:
            start = client.now() + LEAD
            ticking = [n for n, values in whole.nodes.items() if 'start_time' in values]
            client.set_start(ticking, start)
            elapsed = lambda: client.now() - start  # noqa: E731
        among = [n for n in nodes if n not in FIRST + LAST]
        for group in (FIRST, among, [n for n in LAST if n in nodes]):
            client.transition(list(group), ACTIVATE)
        if elapsed() > 0.0 and not self.lockstep:
            self.observer.warned('the machine is slow: the nodes did not start at the same instant')
        return elapsed

    def _conduct(self, client: Client, elapsed: Callable[[], float]) -> None:
        self.started, self._elapsed = True, elapsed
        self._watch(client, elapsed)
        for each in self.pending:
            self._not_done(each, 'the run was over')

    def _step_clock(self, client: Client, whole: Scenario) -> Callable[[], float]:
        """Return the simulated seconds that all participants have behind them."""
        participants = whole.nodes['clock']['participants']
        reached = client.follow(participants, whole.rate)
        return lambda: reached() / whole.rate

    def _watch(self, client: Client, elapsed: Callable[[], float]) -> None:
        looked = time.monotonic()
        while (now := elapsed()) < self.duration - 1e-9:
            client.wait(0.1 if self.lockstep else self._pause(now))
            self._interruption.look()
            self._report_deaths(client)
            self._note_returns(client)
            self._intervene(client, elapsed())
            self._note_faults(client)
            if self.lockstep:
                self._note_standstill(client, now, min(time.monotonic() - looked, LONG))
                looked = time.monotonic()
            self.observer.progressed(max(0.0, now), client.counts)
            if self.over or (self.lockstep and self.troubles):
                return
        self.observer.progressed(self.duration, client.counts, last=True)
        if not self.lockstep:
            self.timing = {node: client.seen(node) for node in self.scenario.nodes}
            self.warnings, self.noted = client.warnings, client.noted

    def _pause(self, now: float) -> float:
        """Return the seconds until something is to be done or looked at."""
        ends = [self.duration, *(each.at for each in self.pending[:1])]
        return min(0.1, max(0.001, min(ends) - now))

    def _intervene(self, client: Client, now: float) -> None:
        """Do what is due; in lockstep the clock waits at that very step, for us to go on."""
        due = [each for each in self.pending if each.at <= now + 1e-9]
        if self.lockstep:
            due = [each for each in due if each.at == due[0].at]
        for each in due:
            self.pending.remove(each)
            self._act(client, each)
        if due and self.lockstep and not self.over:
            self._resume(client)

    def _act(self, client: Client, each: Intervention) -> None:
        """Do it while the run lasts; a node that is dead is not waited for."""
        client.alive = lambda: self._need_alive(client, each.node)
        left = PATIENCE if self.lockstep else max(self.duration - self._elapsed(), GRACE)
        try:
            client.alive()
            self.observer.warned(f'at {each.at:g} s: {each.text.partition(":")[2]}')
            client.act(each, min(left, PATIENCE))
        except EventregError as error:
            self._not_done(each, str(error))

    def _resume(self, client: Client) -> None:
        client.alive = lambda: self._need_alive(client, 'clock')
        try:
            client.resume()
        except EventregError as error:
            self.troubles.append(f'clock: {error}')

    def _need_alive(self, client: Client, node: str) -> None:
        """Raise EventregError when ``node`` died and was not started again."""
        self._interruption.look()
        self._report_deaths(client)
        self._note_returns(client)
        if node in self._gone:
            raise EventregError(f'{node} {self.processes.died[node]}')
        if self.over:
            raise EventregError('the run was over')

    def _note_returns(self, client: Client) -> None:
        """Note who was started again: by its diagnostics, or by its name, which it had left.

        DDS keeps the name of a node that was killed for a while; then there are two of it.
        """
        for node in tuple(self._gone):
            names = client.namesakes(node)
            back = names > 1 or (names and node in self._left)
            if client.take_heard(node) or back:
                self._gone.discard(node)
                self._left.discard(node)
            elif not names:
                self._left.add(node)

    def _not_done(self, each: Intervention, why: str) -> None:
        line = f'at {each.text} was not done: {why}'
        self.observer.warned(line)
        self.troubles.append(line)

    def _report_deaths(self, client: Client) -> None:
        for node in self.processes.look():
            now = self._elapsed()
            when = f'after {now:.1f} s' if now > 0.0 else 'before the first sample'
            how = f'{node} {self.processes.died[node]} {when}'
            self.troubles.append(how)
            self._gone.add(node)
            client.take_heard(node)
            if self.composed or self.lockstep or node == 'recorder':
                self.over = True
                continue
            self.observer.warned(
                f'{how}; the others run on, and it may be started again: '
                f'ros2 run {" ".join(package_and_executable(self.scenario, node))}'
            )

    def _note_faults(self, client: Client) -> None:
        """In lockstep a node at fault stops the run; in real time that of the recorder does."""
        for node, message in client.faults.items():
            trouble = f'{node.strip("/")}: {message}'
            if trouble not in self.troubles:
                self.troubles.append(trouble)
            self.over |= kind_of(node.rpartition('/')[2]) == 'recorder'

    def _note_standstill(self, client: Client, elapsed: float, passed: float) -> None:
        """In lockstep all wait for all: note what the nodes themselves cannot say.

        ``passed``: the seconds since the last look, few even if we ourselves were stopped.
        """
        self._silent = 0.0 if client.take_heard('clock') else self._silent + passed
        self._without_step = self._without_step + passed if elapsed < 0.0 else 0.0
        if self._silent > SILENCE:
            self.troubles.append(f'clock has said nothing for {self._silent:.0f} s; it was stopped')
        elif self._without_step > FIRST_STEP:
            missing = client.seen('clock').get(WAITING_FOR) or 'the clock'
            self.troubles.append(f'no step within {FIRST_STEP:g} s: {missing} did not come so far')


def _named(node: str) -> list[str]:
    """Return the arguments that give a node its name, and its namespace's share of the clock."""
    from ..nodes.topics import SHARED

    namespace, _, name = node.rpartition('/')
    rules = [f'__node:={name}']
    if namespace:
        rules += [f'__ns:=/{namespace}', *SHARED]
    return [word for rule in rules for word in ('-r', rule)]
