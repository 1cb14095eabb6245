# SPDX-License-Identifier: Apache-2.0
"""Publishers, subscriptions and timers of our nodes, each destroyed with the stage that made it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import qos_policy_name_from_kind
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..runtime.figures import publishers_of, subscribers_of
from ..scenario.qos import Endpoint
from .info import received_at
from .ros import RCLError, with_info
from .topics import Topic

InfoCallback = Callable[[bytes, dict[str, Any]], None]


class Endpoints(LifecycleNode):
    """A lifecycle node whose endpoints go on the stack of the stage that creates them.

    ``sources`` are the subscriptions of signals and ``sinks`` their publishers, by topic, as the
    parameters name it.
    """

    stack: ExitStack
    """The endpoints of the stage that is being entered; see :mod:`.managed`."""

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self._polled: dict[Any, tuple[type, InfoCallback]] = {}
        self.incompatible: dict[str, str] = {}
        """What is wrong with the QoS of publishers that we listen to, by topic."""
        self.sources: dict[str, Any] = {}
        self.sinks: dict[str, Any] = {}

    def advertise(self, topic: Topic, signal: str, *, always: bool = False) -> Any:
        """Create the publisher of ``topic`` for ``signal``; parameters can override its QoS.

        It is silent while the node is inactive, unless it publishes ``always``.
        """
        name = topic.of(signal)
        create: Any = self.create_publisher if always else self.create_lifecycle_publisher
        destroy: Any = self.destroy_publisher if always else self.destroy_lifecycle_publisher
        options = QoSOverridingOptions.with_default_policies()
        publisher = create(topic.message, name, topic.qos, qos_overriding_options=options)
        self.sinks[name] = publisher
        self.stack.callback(self.sinks.pop, name)
        self.stack.callback(destroy, publisher)
        return publisher

    def subscribe(
        self, topic: Topic, signal: str, callback: InfoCallback, *, polled: bool = False
    ) -> None:
        """Create a subscription, noted in ``sources``; parameters can override its QoS.

        ``callback`` gets the bytes of the message (CDR) and the info of rclpy: as the message
        comes, or, where the subscription is ``polled``, when :meth:`poll` is called. The process is
        not woken by messages that are polled, which costs a fifth.
        """
        name = topic.of(signal)
        source = self.create_subscription(
            topic.message,
            name,
            with_info(callback),
            topic.qos,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=lambda event: self._note_incompatible(name, event)
            ),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )
        self.sources[name] = source
        self.stack.callback(self.sources.pop, name)
        self.stack.callback(self.incompatible.pop, name, None)
        self.stack.callback(self.destroy_subscription, source)
        if polled:
            self._polled[source] = (topic.message, callback)
            self.stack.callback(self._polled.pop, source)

    @property
    def subscriptions(self) -> Iterator[Any]:
        """The subscriptions that an executor waits for: all but those that are polled."""
        yield from (source for source in super().subscriptions if source not in self._polled)

    def poll(self) -> None:
        """Hand the messages that have come on polled subscriptions to their callbacks."""
        for source, (message, callback) in list(self._polled.items()):
            with source.handle:
                take = source.handle.take_message
                while (taken := take(message, True)) is not None:
                    callback(*taken)

    def _note_incompatible(self, name: str, event: Any) -> None:
        """Report a publisher whose QoS does not fit, and how to make ours fit it."""
        policy = qos_policy_name_from_kind(event.last_policy_kind).lower()
        topic = self.resolve_topic_name(name)
        words = (
            f'a publisher of {topic} offers another {policy} than this node asks for, so nothing '
            f'comes from it'
        )
        if policy == 'reliability':
            words += f'; start with -p qos_overrides.{topic}.subscription.reliability:=best_effort'
        self.incompatible[name] = words
        self.get_logger().warning(words)

    def publisher_of(self, topic: Topic) -> Any:
        """Create the publisher of a topic that is not a signal's."""
        publisher = self.create_publisher(topic.message, topic.name, topic.qos)
        self.stack.callback(self.destroy_publisher, publisher)
        return publisher

    def subscription_of(self, topic: Topic, callback: Callable[[Any], None]) -> Any:
        """Create a subscription to a topic that is not a signal's."""
        subscription = self.create_subscription(topic.message, topic.name, callback, topic.qos)
        self.stack.callback(self.destroy_subscription, subscription)
        return subscription

    def service_of(self, kind: type, name: str, serve: Callable[[Any, Any], Any]) -> None:
        """Create a service."""
        service = self.create_service(kind, name, serve)
        self.stack.callback(self.destroy_service, service)

    def steady_timer(self, period: float, work: Callable[[], None]) -> Any:
        """Create a timer of ``period`` seconds that neither /clock nor a clock set anew moves."""
        return self._timer(period, work, Clock(clock_type=ClockType.STEADY_TIME))

    def ros_timer(self, period: float, work: Callable[[], None]) -> Any:
        """Create a timer of ``period`` seconds of this node's clock."""
        return self._timer(period, work, None)

    def _timer(self, period: float, work: Callable[[], None], clock: Clock | None) -> Any:
        timer = self.create_timer(period, work, clock=clock)
        self.stack.callback(self.destroy_timer, timer)
        self.stack.callback(timer.cancel)
        return timer

    def several_writers(self) -> str | None:
        """Say which topics that we listen to have more than one publisher; None if none has."""
        several = [t for t, source in self.sources.items() if source.get_publisher_count() > 1]
        return f'several nodes publish {", ".join(several)}; stop all but one' if several else None

    def matches(self) -> dict[str, int]:
        """Return how many peers each publisher and subscription of a signal is matched with."""
        heard = {publishers_of(t): s.get_publisher_count() for t, s in self.sources.items()}
        return heard | {
            subscribers_of(topic): sink.get_subscription_count()
            for topic, sink in self.sinks.items()
            if not topic.startswith('spikes/')
        }

    @property
    def endpoints(self) -> list[Endpoint]:
        """The publishers and subscriptions whose QoS parameters can override."""
        found = {'publisher': self.sinks, 'subscription': self.sources}
        return [
            Endpoint(name, self.resolve_topic_name(name), kind)
            for kind, topics in found.items()
            for name in topics
        ]

    def send(self, publisher: Any, message: Any) -> None:
        """Publish, unless a signal shut the context down in the middle of a callback."""
        try:  # not until_the_end: this is called for every sample
            publisher.publish(message)
        except RCLError:
            if self.context.ok():
                raise

    @contextmanager
    def until_the_end(self) -> Iterator[None]:
        """Let pass what fails because a signal shut the context down in the middle."""
        try:
            yield
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
