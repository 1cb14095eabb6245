# SPDX-License-Identifier: Apache-2.0
"""What all our nodes are: lifecycle nodes that start themselves, check parameters and report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter

from .. import __version__
from ..errors import EventregError, ParameterError, described, one_line, shown
from ..runtime.figures import STATE
from ..scenario.hint import hint
from ..scenario.names import kind_of
from ..scenario.parameter import ACTIVE, INACTIVE, START, UNCONFIGURED, Parameter
from ..scenario.parameters import completed, parameters_of
from ..scenario.qos import check_key, keys_of, misspelt
from .declare import declare, fitted, given_to, widened
from .endpoints import Endpoints
from .given import as_meant
from .requests import check_requests, refusal
from .topics import DIAGNOSTICS

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
SUCCESS, FAILURE, BROKEN = (
    TransitionCallbackReturn.SUCCESS,
    TransitionCallbackReturn.FAILURE,
    TransitionCallbackReturn.ERROR,
)
IDENTITY = f'eventreg_ros {__version__}'
"""What the diagnostics say of who runs a node, so that two versions in one loop are noticed."""

_ORDER = {START: -1, UNCONFIGURED: 0, INACTIVE: 1, ACTIVE: 2}


class FaultError(Exception):
    """The node cannot go on; the message says why. It goes through its error state."""


class Status(NamedTuple):
    """What an active node reports: level, message, and values by key."""

    level: bytes
    message: str
    values: Mapping[str, object]


class ManagedNode(Endpoints):
    """A lifecycle node of the table of parameters, with diagnostics once a second.

    A subclass fills in ``open``, ``begin``, ``changed`` and ``report``. What ``open`` and ``begin``
    create is put on ``stack`` and undone, the last first, when the node leaves that stage, also
    when they fail.
    """

    def __init__(self, kind: str, **kwargs: Any) -> None:
        with as_meant(kwargs.pop('cli_args', None) or ()) as arguments:
            super().__init__(kind, cli_args=arguments or None, **kwargs)
        self.kind = kind
        name = self.get_name()
        self.label = name if kind_of(name) == kind else kind
        """The name whose defaults hold: controller_b publishes u_b."""
        self.stage = UNCONFIGURED
        self.closing = False
        """Whether the process, or the node in it, is about to end."""
        self.fault: str | None = None
        self._reports = True
        """Whether the log says why a transition failed."""
        self._stages = {stage: ExitStack() for stage in (UNCONFIGURED, INACTIVE, ACTIVE)}
        self.stack = self._stages[UNCONFIGURED]
        given = given_to(self)
        self.table = self.rows(given)
        self.values = completed(self.label, self.table, fitted(self, self.table, given))
        declare(self, self.table, self.values)
        self.add_pre_set_parameters_callback(lambda changes: widened(self.table, changes))
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._take_change)
        check_requests(self, self._check_request)
        self._diagnostics = self.publisher_of(DIAGNOSTICS)
        self._heartbeat = self.steady_timer(1.0, self.publish_diagnostics)

    def _LifecycleNodeMixin__on_change_state(self, request: Any, response: Any) -> Any:  # noqa: N802
        """Refuse a transition that the present state does not have; rclpy would end the node.

        That is no fault: a request whose answer was late is sent again.
        """
        wanted = request.transition.label or request.transition.id
        known = self._state_machine.available_transitions
        if any(wanted in (number, label) for number, label, *_ in known):
            # The name is rclpy's private one: it has no other place at which to come between.
            return super()._LifecycleNodeMixin__on_change_state(request, response)  # type: ignore[misc]
        self.get_logger().info(f'no transition {wanted}: the node is {self.stage}')
        response.success = False
        return response

    # What a subclass says

    def rows(self, given: Mapping[str, Any]) -> dict[str, Parameter]:
        """Return the parameters of this node, by name, in the light of what was given."""
        return parameters_of(self.label, given)

    def open(self) -> None:
        """Create publishers and subscriptions (configure)."""

    def begin(self) -> None:
        """Start the work (activate)."""

    def changed(self) -> None:
        """Take over ``self.values`` after parameters were set."""

    def verify(self, values: Mapping[str, Any]) -> None:
        """Check what the table of parameters cannot. Raises ParameterError."""

    def report(self) -> Status:
        """Return what the diagnostics say of an active node."""
        return Status(OK, 'running', {})

    @contextmanager
    def until_cleanup(self) -> Iterator[None]:
        """Put what is created meanwhile on the stack of the configured stage."""
        before, self.stack = self.stack, self._stages[INACTIVE]
        try:
            yield
        finally:
            self.stack = before

    # Life

    def bring_up(self) -> None:
        """Configure and activate, if ``autostart`` says so. Raises EventregError when it fails."""
        if not self.values['autostart']:
            return
        self._reports = False  # whoever starts the node says it, in one line
        try:
            for transition in (self.trigger_configure, self.trigger_activate):
                if transition() != SUCCESS:
                    raise EventregError(f'{self.label}: {self.fault}')
        finally:
            self._reports = True

    def close(self) -> None:
        """Release everything; the context may be shut down already."""
        self.closing = True
        for stage in (ACTIVE, INACTIVE):
            self._stages[stage].close()
        self.stage = UNCONFIGURED
        self.destroy_node()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create publishers and subscriptions."""
        return self._enter(INACTIVE, self._open)

    def _open(self) -> None:
        self.open()
        for key in keys_of(given_to(self)):
            check_key(self.label, key, self.endpoints)
            if topic := misspelt(key, self.endpoints):
                self.get_logger().warning(f'{key} acts on nothing here; did you mean {topic}?')

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start."""
        super().on_activate(state)
        return self._enter(ACTIVE, self.begin)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop; a node at fault goes on into its error state."""
        result = self._leave(ACTIVE, INACTIVE)
        super().on_deactivate(state)
        return result if self.fault is None else BROKEN

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy publishers and subscriptions."""
        return self._leave(INACTIVE, UNCONFIGURED)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop and destroy, from any state."""
        self._leave(ACTIVE, INACTIVE)
        return self._leave(INACTIVE, UNCONFIGURED)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Leave the error state for unconfigured: configure and activate start afresh."""
        self._leave(ACTIVE, INACTIVE)
        self._leave(INACTIVE, UNCONFIGURED)
        return SUCCESS

    def _enter(self, stage: str, work: Callable[[], None]) -> TransitionCallbackReturn:
        """Do ``work`` with a new stack; keep it if it succeeds, else undo what was done."""
        self.fault = None
        try:
            with ExitStack() as self.stack:
                work()
                self._stages[stage] = self.stack.pop_all()
        except Exception as error:  # rclpy would swallow it without a word
            self._note(error)
            return FAILURE
        self.stage = stage
        return SUCCESS

    def _leave(self, stage: str, below: str) -> TransitionCallbackReturn:
        """Undo what was done for ``stage``."""
        try:
            self._stages[stage].close()
        except Exception as error:
            self._note(error)
            return FAILURE
        finally:
            self._stages[stage] = ExitStack()
        self.stage = below
        return SUCCESS

    def _note(self, error: Exception) -> None:
        known = isinstance(error, EventregError | FaultError)
        self.fault = one_line(error if known else described(error))
        if self._reports:
            self.get_logger().error(self.fault)

    def fail(self, reason: str) -> None:
        """Go through the error state because of ``reason``; log and diagnostics say it."""
        self.fault = one_line(reason)
        if not self.context.ok():
            return
        words = (
            f"{self.fault}; now unconfigured: fix it, then 'ros2 lifecycle set "
            f"{self.get_fully_qualified_name()} configure' and 'activate'"
        )
        self.get_logger().error(one_line(words))
        with self.until_the_end():
            if self.stage == ACTIVE:
                self.trigger_deactivate()
            elif self.stage == INACTIVE:
                self.trigger_cleanup()
            self._await_recovery()
        self.publish_diagnostics()

    def _await_recovery(self) -> None:
        """Start again by itself after ``recover`` seconds, where that is wanted."""
        seconds = self.values.get('recover', 0.0)
        if seconds and not self.values['lockstep']:
            self.stack = self._stages[UNCONFIGURED]
            self._recovery = self.steady_timer(seconds, self._recover)

    def _recover(self) -> None:
        self._recovery.cancel()
        if self.stage != UNCONFIGURED or self.fault is None:
            return  # somebody was faster
        self.get_logger().warning(f'{self.label} starts again from its initial state')
        with self.until_the_end():
            if self.trigger_configure() == SUCCESS:
                self.trigger_activate()

    # Parameters

    def _check_request(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        """Check what a service was asked to set, before rclpy does."""
        for name in (change.name for change in changes):
            if name not in self.table and not self.has_parameter(name):
                words = f'{self.label} has no parameter {shown(name)}{hint(name, self.table)}'
                return refusal(words)
        return self._check_change(widened(self.table, changes))

    def _check_change(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        try:
            for change in changes:
                self._need_settable(change.name, change.value)
            self.verify(self._with(changes)[1])
        except EventregError as error:
            return refusal(error)
        return SetParametersResult(successful=True)

    def _need_settable(self, name: str, value: object) -> None:
        row = self.table.get(name)
        if row is not None and row.settable == START:
            if value == self.values[name]:
                return  # what was dumped can be loaded again
            raise ParameterError(
                f'{self.label}.{name} names a file, so it can be given only as the node is '
                f'started; start it anew with -p {name}:=VALUE'
            )
        if row is not None and _ORDER[self.stage] > _ORDER[row.settable]:
            raise ParameterError(
                f'{self.label}.{name} can be set only while {row.settable}, '
                f'the node is {self.stage}'
            )

    def _with(self, changes: Sequence[RosParameter]) -> tuple[dict[str, Parameter], dict[str, Any]]:
        """Return table and values after ``changes``; another model has other parameters."""
        wanted = self.values | {c.name: c.value for c in changes if c.name in self.table}
        table = self.rows(wanted)
        return table, completed(self.label, table, {n: v for n, v in wanted.items() if n in table})

    def _take_change(self, changes: Sequence[RosParameter]) -> None:
        if not any(change.name in self.table for change in changes):
            return
        table, self.values = self._with(changes)
        if table.keys() != self.table.keys():
            self.table = table
            declare(self, table, self.values)
        self.changed()

    # Diagnostics

    def publish_diagnostics(self) -> None:
        """Publish the state of this node on /diagnostics."""
        with self.until_the_end():
            array = DiagnosticArray(status=[self._status()])
            array.header.stamp = self.get_clock().now().to_msg()
            self._diagnostics.publish(array)

    def _status(self) -> DiagnosticStatus:
        status = Status(OK, self.stage, {})
        if self.fault is not None:
            status = Status(ERROR, self.fault, {})
        elif self.stage == ACTIVE:
            status = self.report()
        values = {STATE: self.stage, **self.matches(), **status.values}
        return DiagnosticStatus(
            level=status.level,
            name=f'{self.get_fully_qualified_name()}: {self.kind}',
            message=status.message,
            hardware_id=IDENTITY,
            values=[KeyValue(key=k, value=str(v)) for k, v in values.items()],
        )
