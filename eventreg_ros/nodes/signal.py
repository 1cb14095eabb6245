"""A node that publishes one signal, sample by sample."""

from __future__ import annotations

import math
from typing import Any

from ..runtime.cdr import packed
from .lockstep import Lockstep
from .managed import FaultError, ManagedNode
from .realtime import RealTime
from .topics import Topic, signal_topic


class SignalNode(ManagedNode):
    """Publishes sample n of ``output`` when its pace says so: the clock's, or lockstep's.

    A subclass gives ``first() -> value`` and ``following(n) -> value``, the step from sample n to
    sample n + 1.
    """

    pace: RealTime | Lockstep
    published = False
    """Whether a sample has gone out since the publisher was created."""

    def first(self) -> float:
        """Return sample 0."""
        raise NotImplementedError

    def following(self, n: int) -> float:
        """Take the step from sample ``n`` and return sample ``n`` + 1."""
        raise NotImplementedError

    def ready(self, n: int) -> bool:
        """Say whether sample ``n`` of every input has come (lockstep)."""
        return True

    def missing(self, n: int) -> list[str]:
        """Return the inputs whose sample ``n`` has not come yet (lockstep)."""
        return []

    @property
    def n(self) -> int:
        """The number of the newest sample; -1 before the first."""
        return self.pace.n if hasattr(self, 'pace') else -1

    @property
    def signal_topic(self) -> Topic:
        """How signals travel in this node's mode."""
        return signal_topic(self.values['lockstep'])

    def open(self) -> None:
        """Create the publisher of the output."""
        self.published = False
        self.publisher = self.advertise(self.signal_topic, self.values['output'])

    def shut(self) -> None:
        """Destroy the publisher."""
        if hasattr(self, 'publisher'):
            self.destroy_lifecycle_publisher(self.publisher)
            del self.publisher

    def begin(self) -> None:
        """Start at sample 0."""
        self.pace = Lockstep(self) if self.values['lockstep'] else RealTime(self)

    def end(self) -> None:
        """Stop and leave the output at 0; in lockstep a sample more would be taken for the next."""
        self.pace.end()
        if not self.values['lockstep']:
            self.put(0.0)

    def put(self, value: float) -> None:
        """Publish ``value``."""
        self.send(self.publisher, packed(value))

    def sound(self, value: float) -> float:
        """Return ``value``. Raises FaultError when it is not finite."""
        if not math.isfinite(value):
            raise FaultError(
                f'the state of {self.kind} stopped being finite at step {self.n + 1}; '
                'lower time_scale or raise rate, and look at the inputs'
            )
        return value

    def report(self) -> tuple[bytes, str, dict[str, Any]]:
        """Return the figures of the pace."""
        return self.pace.report()

    def matches(self) -> dict[str, int]:
        """Return the number of subscribers of the output and of publishers of each input."""
        if not hasattr(self, 'publisher'):
            return {}
        count = self.publisher.get_subscription_count()
        return {f'{self.values["output"]}.subscribers': count, **super().matches()}
