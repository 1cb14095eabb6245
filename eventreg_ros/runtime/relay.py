# SPDX-License-Identifier: Apache-2.0
"""A link in real time: which samples leave it and when, as tc netem does it with packets."""

from __future__ import annotations

import heapq
import random
from dataclasses import dataclass
from typing import Generic, TypeVar

from ..runtime.tick_grid import SECOND

Item = TypeVar('Item')

ORDERS = ('newest', 'fifo', 'any')
"""What becomes of a sample that a later one would overtake, see :class:`Impairment`."""


@dataclass(frozen=True)
class Impairment:
    """What a link does to samples; ``delay`` and ``jitter`` in seconds, the others probabilities.

    Each sample is lost with probability ``loss``, else it leaves ``delay`` plus a uniform part of
    ``jitter`` after it came. With probability ``duplicate`` a copy goes with it, with a jitter of
    its own. ``order`` is ``newest`` (a sample that would leave after a later one is discarded, as
    in :func:`.links.received`), ``fifo`` (it holds up those behind it) or ``any`` (it leaves late).
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    duplicate: float = 0.0
    order: str = 'newest'


@dataclass(frozen=True)
class Departure(Generic[Item]):
    """What leaves a link; ``entered`` and ``due`` in nanoseconds."""

    entered: int
    due: int
    item: Item


class Relay(Generic[Item]):
    """One link. Times are integer nanoseconds of any clock, never falling from call to call.

    ``impairment`` may be replaced at any time; what is in flight keeps its due time. Every sample
    takes four random numbers whatever the impairment, so that with the same ``seed`` the same
    samples are lost when another delay is set.
    """

    def __init__(self, impairment: Impairment, seed: int | str = 0) -> None:
        self.impairment = impairment
        self.received = self.sent = self.dropped = self.duplicated = self.overtaken = 0
        self._random = random.Random(seed)
        self._flying: list[tuple[int, int, int, int, Item]] = []
        self._entries = 0
        self._latest_due = 0
        self._newest_sent = 0

    @property
    def in_flight(self) -> int:
        """How many samples have come and not left."""
        return len(self._flying)

    @property
    def next_due(self) -> int | None:
        """When the next sample leaves; None when nothing is in flight."""
        return self._flying[0][0] if self._flying else None

    def push(self, now: int, item: Item) -> None:
        """Take the sample that comes at ``now``."""
        self.received += 1
        lost, twice, late, copy_late = (self._random.random() for _ in range(4))
        if lost < self.impairment.loss:
            self.dropped += 1
            return
        self._enter(now, late, item)
        if twice < self.impairment.duplicate:
            self.duplicated += 1
            self._enter(now, copy_late, item)

    def _enter(self, now: int, late: float, item: Item) -> None:
        seconds = self.impairment.delay + late * self.impairment.jitter
        due = now + round(seconds * SECOND)
        if self.impairment.order == 'fifo':
            due = max(due, self._latest_due)
        self._latest_due = max(due, self._latest_due)
        self._entries += 1  # among equals the first to come leaves first
        heapq.heappush(self._flying, (due, self._entries, self.received, now, item))

    def pop(self, now: int) -> list[Departure[Item]]:
        """Return what leaves up to ``now``, in the order in which it leaves."""
        leaving = []
        while self._flying and self._flying[0][0] <= now:
            due, _, number, entered, item = heapq.heappop(self._flying)
            if number < self._newest_sent and self.impairment.order == 'newest':
                self.overtaken += 1
                continue
            self._newest_sent = max(number, self._newest_sent)
            self.sent += 1
            leaving.append(Departure(entered, due, item))
        return leaving
