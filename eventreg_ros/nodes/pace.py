# SPDX-License-Identifier: Apache-2.0
"""When a step is due and which samples it uses: two protocols, each with two implementations.

In real time (:mod:`.realtime`, :mod:`.stamped`) steps are due by the clock and use the samples that
have come by then; in lockstep (:mod:`.lockstep`, :mod:`.sequenced`) step n waits for sample n of
every input. Neither pace nor inputs know the node: they are given what they need.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from .endpoints import InfoCallback
from .managed import Status


class Tick(NamedTuple):
    """One step: from sample ``n`` to the next.

    ``start`` is the instant of sample n, ``now`` the time at which the step is taken, both in
    nanoseconds of the node's clock; ``period`` is the length of the step in nanoseconds.
    """

    n: int
    start: int
    now: int
    period: float


class Lines(NamedTuple):
    """The inputs over one step, each a straight line; see :mod:`...simulation.hold`."""

    base: Sequence[float]
    slope: Sequence[float]


class Work(Protocol):
    """What a pace asks of the node that it paces. Each may raise FaultError."""

    def poll(self) -> None:
        """Take in the samples that have come and nobody was woken for."""

    def first(self) -> float:
        """Return sample 0."""

    def following(self, tick: Tick) -> float:
        """Take the step ``tick`` and return the sample at its end."""

    def put(self, value: float) -> object:
        """Publish a sample, as it is or as it is coded."""

    def fail(self, reason: str) -> None:
        """Stop because of ``reason``."""


class Pace(Protocol):
    """Decides when the steps are taken."""

    n: int
    """The number of the newest sample; -1 before the first."""

    def begin(self) -> None:
        """Make sample 0, at once or when it is due, and go on."""

    def go(self) -> None:
        """Take the steps that are possible now; called when samples have come."""

    def report(self) -> Status:
        """Return level, message and figures for the diagnostics."""


class Inputs(Protocol):
    """The samples of all inputs of a node, in order."""

    signals: tuple[str, ...]
    """Their names."""

    horizons: Sequence[float]
    """Steps over which the line of each is drawn onwards."""

    quiet: list[str]
    """The inputs that have been heard and have fallen silent."""

    def receiver(self, i: int, go: Callable[[], None]) -> InfoCallback:
        """Return the callback of input ``i``; it calls ``go`` where a step may wait for it."""

    def ready(self, n: int) -> bool:
        """Say whether all is there for the step from sample ``n`` on."""

    def missing(self, n: int) -> list[str]:
        """Return the samples that are not there for that step, in words."""

    def over(self, tick: Tick) -> Lines:
        """Return the lines of all inputs over a step."""

    def report(self) -> list[Status]:
        """Return what the diagnostics say of the inputs: findings, and figures."""
