"""What all our nodes are: lifecycle nodes that start themselves, check parameters and report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..errors import EventregError, ParameterError
from ..scenario.parameter import ACTIVE, INACTIVE, UNCONFIGURED
from ..scenario.parameters import NODES, resolve
from .declare import declare, widen
from .info import received_at
from .ros import RCLError, with_info
from .topics import DIAGNOSTICS, Topic

InfoCallback = Callable[[bytes, dict[str, Any]], None]

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
SUCCESS, FAILURE, BROKEN = (
    TransitionCallbackReturn.SUCCESS,
    TransitionCallbackReturn.FAILURE,
    TransitionCallbackReturn.ERROR,
)
_REACHED = {UNCONFIGURED: 0, INACTIVE: 1, ACTIVE: 2}


class FaultError(Exception):
    """The node cannot go on; the message says why. It goes through its error state."""


class ManagedNode(LifecycleNode):
    """A lifecycle node of the table of parameters, with diagnostics once a second.

    A subclass fills in ``open``, ``begin``, ``end``, ``shut``, ``changed`` and ``report``.
    """

    def __init__(self, kind: str, **kwargs: Any) -> None:
        super().__init__(kind, **kwargs)
        self.kind = kind
        self.stage = UNCONFIGURED
        self.fault: str | None = None
        self.values = declare(self, kind)
        self._settable = {p.name: p.settable for p in NODES[kind]}
        self.add_pre_set_parameters_callback(lambda changes: widen(kind, changes))
        self.add_on_set_parameters_callback(self._check_change)
        self.add_post_set_parameters_callback(self._take_change)
        self.sources: dict[str, Any] = {}
        """The subscriptions by topic, as the parameters name it."""
        self._diagnostics = self.publisher_of(DIAGNOSTICS)
        self._heartbeat = self.steady_timer(1.0, self.publish_diagnostics)

    def _LifecycleNodeMixin__on_change_state(self, request: Any, response: Any) -> Any:  # noqa: N802
        """Refuse a transition that the present state does not have; rclpy would end the node."""
        try:
            # The name is rclpy's private one: it has no other place at which to catch this.
            return super()._LifecycleNodeMixin__on_change_state(request, response)  # type: ignore[misc]
        except RCLError as error:
            self.get_logger().warning(
                f'transition refused, the node is {self.stage}: {str(error).split(",")[0]}'
            )
            response.success = False
            return response

    # What a subclass says

    def open(self) -> None:
        """Create publishers and subscriptions (configure)."""

    def begin(self) -> None:
        """Start the work (activate)."""

    def end(self) -> None:
        """Stop the work (deactivate)."""

    def shut(self) -> None:
        """Destroy what ``open`` created (cleanup); also called when ``open`` broke off."""

    def changed(self) -> None:
        """Take over ``self.values`` after parameters were set."""

    def verify(self, values: dict[str, Any]) -> None:
        """Check what the table of parameters cannot. Raises ParameterError."""

    def report(self) -> tuple[bytes, str, dict[str, object]]:
        """Return level, message and values for the diagnostics of an active node."""
        return OK, 'running', {}

    # Life

    def start(self) -> None:
        """Configure and activate, if ``autostart`` says so. Raises EventregError when it fails."""
        if not self.values['autostart']:
            return
        for transition in (self.trigger_configure, self.trigger_activate):
            if transition() != SUCCESS:
                raise EventregError(f'{self.kind}: {self.fault}')

    def close(self) -> None:
        """Release everything; the context may be shut down already."""
        if self.stage == ACTIVE:
            self.end()
        if self.stage != UNCONFIGURED:
            self.shut()
        self.stage = UNCONFIGURED
        self.destroy_node()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create publishers and subscriptions."""
        self.fault = None
        result = self._attempt(self.open, INACTIVE)
        if result != SUCCESS:
            self.shut()
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start."""
        self.fault = None
        super().on_activate(state)
        return self._attempt(self.begin, ACTIVE)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop; a node at fault goes on into its error state."""
        result = self._attempt(self.end, INACTIVE)
        super().on_deactivate(state)
        return result if self.fault is None else BROKEN

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy publishers and subscriptions."""
        return self._attempt(self.shut, UNCONFIGURED)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop and destroy, from any state."""
        if self.stage == ACTIVE:
            self._attempt(self.end, INACTIVE)
        return self._attempt(self.shut, UNCONFIGURED)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Leave the error state for unconfigured: configure and activate start afresh."""
        self._attempt(self.shut, UNCONFIGURED)
        return SUCCESS

    def _attempt(self, work: Callable[[], None], stage: str) -> TransitionCallbackReturn:
        try:
            work()
        except Exception as error:  # rclpy would swallow it without a word
            known = isinstance(error, EventregError | FaultError)
            self.fault = str(error) if known else f'{type(error).__name__}: {error}'
            self.get_logger().error(self.fault)
            return FAILURE
        self.stage = stage
        return SUCCESS

    def break_off(self, reason: str) -> None:
        """Go through the error state because of ``reason``; log and diagnostics say it."""
        self.fault = reason
        if not self.context.ok():
            return
        self.get_logger().error(
            f"{reason}; now unconfigured: mend it, then 'ros2 lifecycle set "
            f"{self.get_fully_qualified_name()} configure' and 'activate'"
        )
        if self.stage == ACTIVE:
            with self._until_the_end():
                self.trigger_deactivate()
        self.publish_diagnostics()

    # Parameters

    def _check_change(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        values = {c.name: c.value for c in changes if c.name in self._settable}
        try:
            for name in values:
                if _REACHED[self.stage] > _REACHED[self._settable[name]]:
                    raise ParameterError(
                        f'{self.kind}.{name} can be set only while {self._settable[name]}, '
                        f'the node is {self.stage}'
                    )
            self.verify(resolve(self.kind, {**self.values, **values}))
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_change(self, changes: Sequence[RosParameter]) -> None:
        values = {c.name: c.value for c in changes if c.name in self._settable}
        if values:
            self.values = resolve(self.kind, {**self.values, **values})
            self.changed()

    # Communication

    def advertise(self, topic: Topic, signal: str) -> Any:
        """Create the publisher of ``topic`` for ``signal``; parameters can override its QoS."""
        return self.create_lifecycle_publisher(
            topic.message,
            topic.of(signal),
            topic.qos,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def subscribe(self, topic: Topic, signal: str, callback: InfoCallback) -> None:
        """Create a subscription, noted in ``sources``; parameters can override its QoS.

        ``callback`` gets the bytes of the message (CDR) and the info of rclpy.
        """
        self.sources[topic.of(signal)] = self.create_subscription(
            topic.message,
            topic.of(signal),
            with_info(callback),
            topic.qos,
            raw=True,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def publisher_of(self, topic: Topic) -> Any:
        """Create the publisher of a topic that is not a signal's."""
        return self.create_publisher(topic.message, topic.name, topic.qos)

    def subscription_of(self, topic: Topic, callback: Callable[[Any], None]) -> Any:
        """Create a subscription to a topic that is not a signal's."""
        return self.create_subscription(topic.message, topic.name, callback, topic.qos)

    def unsubscribe(self) -> None:
        """Destroy the subscriptions."""
        for subscription in self.sources.values():
            self.destroy_subscription(subscription)
        self.sources.clear()

    def several_writers(self) -> str | None:
        """Say which topics that we listen to have more than one publisher; None if none has."""
        several = [t for t, source in self.sources.items() if source.get_publisher_count() > 1]
        return f'several nodes publish {", ".join(several)}; stop all but one' if several else None

    def steady_timer(self, period: float, work: Callable[[], None]) -> Any:
        """Create a timer of ``period`` seconds that neither /clock nor a clock set anew moves."""
        return self.create_timer(period, work, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @contextmanager
    def _until_the_end(self) -> Iterator[None]:
        """Let pass what fails because a signal shut the context down in the middle."""
        try:
            yield
        except RCLError:
            if self.context.ok():
                raise

    def send(self, publisher: Any, message: Any) -> None:
        """Publish, unless a signal shut the context down in the middle of a callback."""
        try:  # not _until_the_end: this is called for every sample
            publisher.publish(message)
        except RCLError:
            if self.context.ok():
                raise

    @property
    def in_simulation_time(self) -> bool:
        """Whether this node's clock follows /clock."""
        return bool(getattr(self.get_clock(), 'ros_time_is_active', False))

    def stamp_of(self, info: dict[str, Any]) -> int:
        """Return when a message was sent, in nanoseconds of this node's clock.

        Messages from a host whose clock runs ahead, and all of them under simulation time, count
        from their arrival.
        """
        if self.in_simulation_time:
            return int(self.get_clock().now().nanoseconds)
        return int(min(info['source_timestamp'], received_at(info)))

    def publish_diagnostics(self) -> None:
        """Publish the state of this node on /diagnostics."""
        with self._until_the_end():
            array = DiagnosticArray(status=[self._status()])
            array.header.stamp = self.get_clock().now().to_msg()
            self._diagnostics.publish(array)

    def _status(self) -> DiagnosticStatus:
        level, message = OK, self.stage
        values: dict[str, object] = {}
        if self.fault is not None:
            level, message = ERROR, self.fault
        elif self.stage == ACTIVE:
            level, message, values = self.report()
        return DiagnosticStatus(
            level=level,
            name=f'{self.get_fully_qualified_name()}: {self.kind}',
            message=message,
            values=[
                KeyValue(key=k, value=str(v))
                for k, v in {'state': self.stage, **self.matches(), **values}.items()
            ],
        )

    def matches(self) -> dict[str, int]:
        """Return how many peers each publisher and subscription of ours is matched with."""
        return {
            f'{topic}.publishers': source.get_publisher_count()
            for topic, source in self.sources.items()
        }
