# SPDX-License-Identifier: Apache-2.0
"""What delay, loss and jitter do to the links: which samples each has received at each step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from .model_time import MAX_STEPS

SHORT = 1 << 17
"""Steps of a run up to which random numbers are kept, for the next run with the same seed."""

Index = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Impairment:
    """What happens to every sample on every link; ``delay`` and ``jitter`` in model time.

    Each sample is lost with probability ``loss``, else it comes ``delay``, rounded to whole steps,
    and a uniform part of ``jitter`` late. ``seed`` is of loss and jitter. Links of signals that are
    not ``on`` are perfect; None: all links are impaired. Raises EventregError for a bad value.
    """

    delay: float = 0.0
    loss: float = 0.0
    jitter: float = 0.0
    seed: int = 0
    on: frozenset[str] | None = None

    def __post_init__(self) -> None:
        limits = {'delay': math.inf, 'jitter': math.inf, 'loss': 1.0}
        for name, high in limits.items():
            value = getattr(self, name)
            if not 0.0 <= value <= high:
                raise EventregError(f'{name} must be >= 0 and <= {high:g}, got {value!r}')
        if self.seed < 0:
            raise EventregError(f'seed must be >= 0, got {self.seed}')

    @property
    def random(self) -> bool:
        """Whether the seed matters."""
        return self.loss > 0.0 or self.jitter > 0.0

    def law(self, signal: str, steps: int, h: float) -> Law:
        """Return what happens on the links of ``signal`` in a run of steps of length ``h``."""
        if self.on is not None and signal not in self.on:
            return Law(0, 0.0, 0.0)
        delay = round(min(self.delay / h, float(steps)))
        return Law(delay, self.loss, min(self.jitter / h, float(MAX_STEPS)))


class Law(NamedTuple):
    """An impairment of one link; ``delay`` and ``jitter`` in steps."""

    delay: int
    loss: float
    jitter: float

    @property
    def random(self) -> bool:
        """Whether the seed matters."""
        return self.loss > 0.0 or self.jitter > 0.0


PERFECT = Impairment()


class Received(NamedTuple):
    """Sample numbers, all of shape (links, steps), -1 for none.

    At step n, ``newest[l, n]`` is the last sample that link l has received and ``previous[l, n]``
    the last one before it that it has used; ``used[l, s]`` is the last sample up to s that it uses
    at any time.
    """

    newest: Index
    previous: Index
    used: Index


def received(
    signals: Sequence[str],
    steps: int,
    h: float,
    impairment: Impairment = PERFECT,
    leads: Sequence[int] | None = None,
    *,
    with_used: bool = True,
) -> Received:
    """Return what the links of ``signals`` have at each of ``steps`` steps of length ``h``.

    Sample s is sent at step s. Delay and jitter are rounded, the jitter down: a node takes a step
    with all that has come until it is due. A sample that arrives after a newer one is discarded; of
    those that arrive together all are used, in order. Every link has random numbers of its own,
    which depend on its place and the seed only: the same draws, whatever loss, jitter and duration.
    With ``leads`` (steps, one per link) a sample that arrives sooner than so many steps after it
    was sent counts as arriving then. Unless ``with_used``, ``used`` stays empty.
    """
    newest = np.empty((len(signals), steps), dtype=np.int64)
    previous = np.empty_like(newest)
    used = np.full((len(signals), steps if with_used else 0), -1, dtype=np.int64)
    for link, signal in enumerate(signals):
        law, lead = impairment.law(signal, steps, h), leads[link] if leads else 0
        if not law.random:
            newest[link] = np.maximum(np.arange(steps) - max(law.delay, lead), -1)
            previous[link] = np.maximum(newest[link] - 1, -1)
            used[link] = np.arange(used.shape[1])
            continue
        sent, arrival = _arrivals(link, steps, *law, impairment.seed, lead)
        if with_used:
            used[link, sent] = sent
        have = np.cumsum(np.bincount(arrival[arrival < steps], minlength=steps)[:steps])
        sent = np.concatenate(([-1, -1], sent))
        newest[link], previous[link] = sent[have + 1], sent[have]
    return Received(newest, previous, np.maximum.accumulate(used, axis=1))


def _arrivals(
    link: int, steps: int, delay: int, loss: float, jitter: float, seed: int, lead: int
) -> tuple[Index, Index]:
    """Return the numbers of the samples that one link uses and when each arrives, both in order."""
    sent = np.arange(steps, dtype=np.int64)
    arrival = sent + delay
    if jitter > 0.0:
        arrival = arrival + np.floor(jitter * draws(seed, link, 1, steps)).astype(np.int64)
    if loss > 0.0:
        kept = draws(seed, link, 0, steps) >= loss
        sent, arrival = sent[kept], arrival[kept]
    arrival = np.maximum(arrival, sent + lead)
    if jitter > 0.0 and len(sent):
        earliest_after = np.minimum.accumulate(arrival[::-1])[::-1]
        used = arrival <= earliest_after
        sent, arrival = sent[used], arrival[used]
    return sent, arrival


def draws(seed: int, link: int, of: int, steps: int) -> npt.NDArray[np.float64]:
    """Return the random numbers of one link, of its loss (0) or its jitter (1), for all laws."""
    if steps > SHORT:
        return _draws(seed, link, of, steps)
    return (_known_draws if steps > SHORT // 16 else _known_short)(seed, link, of, steps)


def _draws(seed: int, link: int, of: int, steps: int) -> npt.NDArray[np.float64]:
    return np.random.default_rng((seed, link, of)).random(steps)


_known_draws, _known_short = lru_cache(maxsize=32)(_draws), lru_cache(maxsize=512)(_draws)
