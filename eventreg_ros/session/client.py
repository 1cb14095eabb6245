# SPDX-License-Identifier: Apache-2.0
"""Brings a scenario's nodes up together, starts them at one instant, and watches their spikes."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import nullcontext
from types import TracebackType
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import ReliabilityPolicy
from std_msgs.msg import Header, UInt64
from std_srvs.srv import Trigger

from ..errors import EventregError
from ..nodes import topics
from ..nodes.ros import RCLError, make_executor, with_info
from ..runtime.figures import STEP, publishers_of, subscribers_of
from ..runtime.reached import signed_by
from ..runtime.tick_grid import SECOND, TickGrid
from ..scenario import Scenario
from ..scenario.interventions import Intervention
from .domain import reaching
from .noted import Noted

CONFIGURE, ACTIVATE = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE
DEACTIVATE = Transition.TRANSITION_DEACTIVATE
_REACHED = {
    CONFIGURE: State.PRIMARY_STATE_INACTIVE,
    ACTIVATE: State.PRIMARY_STATE_ACTIVE,
    DEACTIVATE: State.PRIMARY_STATE_INACTIVE,
}
_WORDS = {CONFIGURE: 'be configured', ACTIVATE: 'be activated', DEACTIVATE: 'be deactivated'}

NAME = 'eventreg_run'
"""The name of the client's own node."""

_TAKEN = {
    row.type_name: row
    for row in (topics.SIGNAL, topics.COUNT, topics.EVENT, topics.VERDICT, topics.DIAGNOSTICS)
}

LOOK = 3.0
"""Seconds without a new node after which all nodes of a domain have been discovered."""

_RESEND = 3.0
"""Seconds without an answer after which a request is sent again."""


class Client:
    """A client of the lifecycle, parameter and diagnostics interfaces of the nodes of one run.

    ``alive`` is called while waiting; it raises when waiting makes no sense any more. What other
    nodes than ``nodes`` report is ignored. ``environment`` says whom the client reaches; this
    process keeps its own.
    """

    def __init__(
        self,
        alive: Callable[[], None],
        nodes: Collection[str] = (),
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.alive = alive
        self._nodes = {f'/{node}' for node in nodes}
        self._environment = environment
        self._context = Context()

    def __enter__(self) -> Client:
        try:
            # The command handles its signals itself.
            with nullcontext() if self._environment is None else reaching(self._environment):
                self._context.init(args=['--ros-args', '--log-level', 'WARN'])
                self._node = rclpy.create_node(NAME, context=self._context)
        except RCLError as error:
            self._context.try_shutdown()
            reason = str(error).split(', at ')[0]
            raise EventregError(f'ROS cannot be used here: {reason}; look at ROS_*') from None
        self._executor = make_executor(self._context)
        self._executor.add_node(self._node)
        self._seen: dict[str, dict[str, str]] = {}
        self.counts: dict[str, int] = {}
        self.faults: dict[str, str] = {}
        """Why nodes went through their error state."""
        self.warnings: dict[str, list[str]] = {}
        self.noted: list[Noted] = []
        """What nodes warned of, second by second."""
        self._reached: dict[str, int] = {}
        self._heard: set[str] = set()
        self._subscribe(topics.DIAGNOSTICS, self._on_diagnostics)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._node.destroy_node()
        self._context.try_shutdown()

    def _subscribe(
        self, topic: topics.Topic, callback: Callable[[Any], None], signal: str = ''
    ) -> None:
        self._node.create_subscription(topic.message, topic.of(signal), callback, topic.qos)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            node = status.name.partition(':')[0]
            if node not in self._nodes:
                continue
            self._heard.add(node)
            self._seen[node] = {v.key: v.value for v in status.values}
            if status.level == DiagnosticStatus.ERROR and STEP not in self._seen[node]:
                self.faults[node] = status.message
            elif status.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR):
                self.warnings.setdefault(node, []).append(status.message)
                stamp = message.header.stamp.sec * SECOND + message.header.stamp.nanosec
                self.noted.append(Noted(stamp, node.strip('/'), status.message))

    def need_room(self, nodes: Collection[str], signals: Collection[str]) -> None:
        """Raise EventregError when nodes of these names, or publishers of ``signals``, are here."""
        present: set[str] = set()
        end = time.monotonic() + LOOK
        while time.monotonic() < end:
            self.alive()
            self.wait(0.05)
            now_present = set(self._present())
            if now_present != present:
                present, end = now_present, time.monotonic() + LOOK
        clash = sorted(f'/{node}' for node in nodes if f'/{node}' in present)
        for signal in signals:
            for found in self._node.get_publishers_info_by_topic(f'/{signal}'):
                if (name := _full_name(found)) not in clash:
                    clash.append(f'{name}, which publishes /{signal},')
        if clash:
            domain = self._context.get_domain_id()
            raise EventregError(
                f'on ROS_DOMAIN_ID={domain} there is {", ".join(clash)} already, and two would '
                'disturb each other; stop them, or unset ROS_DOMAIN_ID for a domain of its own'
            )

    def _present(self) -> list[str]:
        found = self._node.get_node_names_and_namespaces()
        return [f'{space.rstrip("/")}/{name}' for name, space in found]

    def namesakes(self, node: str) -> int:
        """Return how many nodes of this name there are."""
        return self._present().count(f'/{node}')

    def seen(self, node: str) -> dict[str, str]:
        """Return what ``node`` said of itself last: keys and values of its diagnostics."""
        return self._seen.get(f'/{node}', {})

    def take_heard(self, node: str) -> bool:
        """Say whether ``node`` has sent diagnostics since this was last asked."""
        heard = f'/{node}' in self._heard
        self._heard.discard(f'/{node}')
        return heard

    def watch(self, signals: Sequence[str]) -> None:
        """Keep ``counts``, the events of each of ``signals`` so far, up to date."""
        for signal in signals:

            def on_count(message: UInt64, signal: str = signal) -> None:
                self.counts[signal] = message.data

            self._subscribe(topics.COUNT, on_count, signal)

    def follow(self, participants: Sequence[str], rate: float) -> Callable[[], int]:
        """Return a function that gives the step which all participants of a lockstep reached."""
        grid = TickGrid(rate)
        self._reached = dict.fromkeys((f'/{name}' for name in participants), -1)

        def on_reached(message: Header) -> None:
            stamp = message.stamp.sec * SECOND + message.stamp.nanosec
            self._reached[signed_by(message.frame_id)[0]] = grid.index(stamp)

        self._subscribe(topics.ALL_REACHED, on_reached)
        return lambda: min(self._reached.values())

    def topics(self) -> dict[str, str]:
        """Return the topics that somebody publishes, and the type of each."""
        found = self._node.get_topic_names_and_types()
        return {topic: kinds[0] for topic, kinds in found if self._node.count_publishers(topic)}

    def knows(self, kind: str) -> bool:
        """Say whether :meth:`take` takes messages of this type."""
        return kind in _TAKEN

    def take(self, topic: str, kind: str, callback: Callable[[Any, dict[str, Any]], None]) -> None:
        """Call ``callback`` with each message of ``topic``, serialised, and what is said of it."""
        row = _TAKEN[kind]
        qos = row.qos
        if not row.latched:
            qos.reliability = ReliabilityPolicy.BEST_EFFORT  # so that nobody waits for us
        self._node.create_subscription(row.message, topic, with_info(callback), qos, raw=True)

    def now(self) -> float:
        """Return ROS time in seconds."""
        return float(self._node.get_clock().now().nanoseconds) * 1e-9

    def wait(self, seconds: float) -> None:
        """Let messages come in for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def until(self, done: Callable[[], bool], seconds: float, what: Callable[[], str]) -> None:
        """Wait until ``done()``. Raises EventregError with ``what()`` after ``seconds``."""
        end = time.monotonic() + seconds
        while not done():
            self.alive()
            if time.monotonic() > end:
                raise EventregError(f'gave up after {seconds:.3g} s: {what()}')
            self.wait(0.02)

    def transition(self, nodes: Sequence[str], transition: int, seconds: float = 30.0) -> None:
        """Take every node through ``transition``. Raises EventregError when one refuses."""
        requests = {
            node: ChangeState.Request(transition=Transition(id=transition)) for node in nodes
        }
        responses = self._call(ChangeState, 'change_state', requests, seconds)
        refused = [node for node, response in responses.items() if not response.success]
        if not refused:
            return
        # A request that was answered late was sent twice, and its second answer is a refusal.
        asked = {node: GetState.Request() for node in refused}
        for node, response in self._call(GetState, 'get_state', asked, seconds).items():
            present = response.current_state
            if present.id != _REACHED[transition]:
                raise EventregError(
                    f'{node} refuses to {_WORDS[transition]} and is {present.label}; its own log '
                    'says why'
                )

    def set_parameter(self, node: str, name: str, value: object, seconds: float = 30.0) -> None:
        """Set one parameter of ``node``. Raises EventregError when it refuses."""
        message = RosParameter(name, value=value).to_parameter_msg()
        request = {node: SetParameters.Request(parameters=[message])}
        result = self._call(SetParameters, 'set_parameters', request, seconds)[node].results[0]
        _need(result, node, name)

    def act(self, intervention: Intervention, seconds: float = 30.0) -> None:
        """Do what an intervention says, now. Raises EventregError when the node refuses."""
        if intervention.action == 'set':
            name, value = intervention.parameter, intervention.value
            self.set_parameter(intervention.node, name, value, seconds)
        else:
            wanted = ACTIVATE if intervention.action == 'activate' else DEACTIVATE
            self.transition([intervention.node], wanted, seconds)

    def resume(self, clock: str = 'clock', seconds: float = 30.0) -> None:
        """Let a clock that waits go on."""
        self._call(Trigger, 'resume', {clock: Trigger.Request()}, seconds)

    def set_start(self, nodes: Sequence[str], start: float, seconds: float = 30.0) -> None:
        """Set ``start_time`` of every node, ROS time in seconds."""
        value = RosParameter('start_time', RosParameter.Type.DOUBLE, start).to_parameter_msg()
        requests = {node: SetParameters.Request(parameters=[value]) for node in nodes}
        responses = self._call(SetParameters, 'set_parameters', requests, seconds)
        for node, response in responses.items():
            _need(response.results[0], node, 'start_time')

    def _call(
        self, service: Any, name: str, requests: Mapping[str, Any], seconds: float
    ) -> dict[str, Any]:
        """Call the service of all nodes at once and return their responses."""
        clients = {n: self._node.create_client(service, f'/{n}/{name}') for n in requests}
        self.until(
            lambda: all(client.service_is_ready() for client in clients.values()),
            seconds,
            lambda: (
                'no answer from '
                + ', '.join(n for n, client in clients.items() if not client.service_is_ready())
            ),
        )
        futures = {n: client.call_async(requests[n]) for n, client in clients.items()}
        sent = time.monotonic()

        def answered() -> bool:
            nonlocal sent
            missing = [n for n, future in futures.items() if not future.done()]
            if missing and time.monotonic() > sent + _RESEND:
                # DDS drops an answer to a client that the server has not discovered yet.
                futures.update({n: clients[n].call_async(requests[n]) for n in missing})
                sent = time.monotonic()
            return not missing

        self.until(
            answered,
            seconds,
            lambda: (
                f'{name} not answered by '
                + ', '.join(n for n, future in futures.items() if not future.done())
            ),
        )
        for client in clients.values():
            self._node.destroy_client(client)
        return {n: future.result() for n, future in futures.items()}

    def wait_matched(self, expected: Mapping[str, Mapping[str, int]], seconds: float) -> None:
        """Wait until each node reports at least the ``expected`` number of peers per endpoint."""

        def missing() -> list[str]:
            return [
                f'{node} {key}'
                for node, keys in expected.items()
                for key, wanted in keys.items()
                if int(self.seen(node).get(key, -1)) < wanted
            ]

        self.until(lambda: not missing(), seconds, lambda: f'not matched: {", ".join(missing())}')


def _need(result: SetParametersResult, node: str, name: str) -> None:
    """Raise EventregError for a parameter that ``node`` refused, with its reason."""
    if not result.successful:
        words = str(result.reason)
        named = words.startswith((f'{node}.{name} ', f'{node} '))
        raise EventregError(words if named else f'{node}.{name}: {words}')


def _full_name(endpoint: Any) -> str:
    """Return the name of the node that an endpoint of the graph belongs to."""
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'


def expected_matches(scenario: Scenario) -> dict[str, dict[str, int]]:
    """Return, per node and endpoint, how many peers the nodes of a scenario will find.

    The keys are those of the nodes' diagnostics.
    """
    published = scenario.publishers
    listened = Counter(signal for node in scenario.nodes for signal in scenario.inputs_of(node))
    monitored = {s for node in scenario.of_kind('spike_monitor') for s in scenario.inputs_of(node)}
    expected: dict[str, dict[str, int]] = {}
    for node, values in scenario.nodes.items():
        full = {name: scenario.signal(node, name) for name in scenario.heard_by(node)}
        found = {publishers_of(name): 1 for name, signal in full.items() if signal in published}
        if node in scenario.of_kind('recorder') and not values['lockstep']:
            counted = [name for name, signal in full.items() if signal in monitored]
            found |= {publishers_of(topics.COUNT.of(name)): 1 for name in counted}
        home = scenario.name_of(node).namespace
        for signal in scenario.published_by(node):
            name = signal.removeprefix(f'{home}/') if home else signal
            found[subscribers_of(name)] = listened[signal]
        expected[node] = found
    return expected
