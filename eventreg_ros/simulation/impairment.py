"""What delay, loss and jitter do to the links: which samples each has received at each step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Index = npt.NDArray[np.int64]


class Received(NamedTuple):
    """Sample numbers, both of shape (links, steps), -1 for none.

    At step n, ``newest[l, n]`` is the last sample that link l has received and ``previous[l, n]``
    the last one before it that it has used.
    """

    newest: Index
    previous: Index


def received(
    links: int,
    steps: int,
    *,
    delay: int = 0,
    loss: float = 0.0,
    jitter: float = 0.0,
    seed: int = 0,
) -> Received:
    """Return what ``links`` links have at each of ``steps`` steps; sample s is sent at step s.

    Each sample is lost with probability ``loss``, else it arrives ``delay`` steps later plus a
    uniform part of ``jitter`` (steps), rounded down: a node takes a step with all that has come
    until it is due. One that arrives after a newer one is discarded; of those that arrive together
    all are used, in order. Every link has random numbers of its own, which depend on ``seed`` and
    the link only: the same draws, whatever loss, jitter and duration.
    """
    newest = np.empty((links, steps), dtype=np.int64)
    previous = np.empty_like(newest)
    for link in range(links):
        sent, arrival = _arrivals(link, steps, delay, loss, jitter, seed)
        have = np.cumsum(np.bincount(arrival[arrival < steps], minlength=steps)[:steps])
        sent = np.concatenate(([-1, -1], sent))
        newest[link], previous[link] = sent[have + 1], sent[have]
    return Received(newest, previous)


def _arrivals(
    link: int, steps: int, delay: int, loss: float, jitter: float, seed: int
) -> tuple[Index, Index]:
    """Return the numbers of the samples that one link uses and when each arrives, both in order."""
    sent = np.arange(steps, dtype=np.int64)
    arrival = sent + delay
    lost, late = (np.random.default_rng((seed, link, kind)) for kind in (0, 1))
    if jitter > 0.0:
        arrival = arrival + np.floor(jitter * late.random(steps)).astype(np.int64)
    if loss > 0.0:
        kept = lost.random(steps) >= loss
        sent, arrival = sent[kept], arrival[kept]
    if jitter > 0.0 and len(sent):
        earliest_after = np.minimum.accumulate(arrival[::-1])[::-1]
        used = arrival <= earliest_after
        sent, arrival = sent[used], arrival[used]
    return sent, arrival
