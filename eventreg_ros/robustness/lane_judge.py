# SPDX-License-Identifier: Apache-2.0
"""Lanes judged as they go: events counted and matched, residuals measured, to a row each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.evidence import lowest_end
from ..analysis.rejection import ENOUGH, NOT_REJECTED, REJECTED, UNDECIDED
from ..analysis.signal import Size, together
from ..analysis.subject import Subject
from ..simulation.jit import compile_entry
from ..simulation.lanes import Lanes, compiled_with
from ..simulation.lanes_source import LANES, Structure
from ..simulation.trajectory import Array
from . import lane_counts
from .lane_counts import Rules, Seen
from .outcome import VERDICTS, Rows, nothing

_COUNTED = ('disturbance_events', 'preserved', 'spurious', 'missed', 'settling', 'delay')
"""What :func:`.lane_counts.tally` finds, in its order."""


ROOM, PER_EVENT = 128, 64
"""Events of one signal in one lane that there is room for: ROOM, and one more per so many steps."""

Flags = npt.NDArray[np.bool_]


@lru_cache(maxsize=8)
def _compiled(name: str) -> Any:
    return compile_entry(getattr(lane_counts, name))


@lru_cache(maxsize=8)
def _leaves(count: int) -> npt.NDArray[np.int64]:
    """Return how numpy adds up so many numbers: starts, sizes and joins, shape (3, leaves)."""
    leaves: npt.NDArray[np.int64] = np.array(lane_counts.halves(0, count)).T.copy()
    return leaves


class Judged(NamedTuple):
    """A row for each set, which of the rows hold, and which sets have to be looked at again.

    No row holds for a set that has more events than there is room for, or where a spike may pass
    between two samples. Looked at again is what did not stay ``finite``, or is ``stuck``: it has
    an output that ends without a reset, and may have been up all the time.
    """

    rows: Rows
    holds: Flags
    finite: Flags
    stuck: Flags


class Judge:
    """Judges lanes of one structure, which hand out the signals ``judged``, over the times ``t``.

    ``subject`` says what of them is judged, and how.
    """

    def __init__(
        self, structure: Structure, judged: Sequence[str], t: Array, subject: Subject
    ) -> None:
        self._take = compiled_with(structure, lane_counts.take)
        self._limits = subject.criteria.settle, subject.criteria.window
        self._lowest = lowest_end(subject)
        pairs = [
            (judged.index(plant.output), judged.index(plant.reference) if plant.reference else -1)
            for plant in subject.plants
        ]
        self._disturbances = [
            np.array([judged.index(w) for w in plant.disturbances], dtype=np.int64)
            for plant in subject.plants
        ]
        self._all = sorted({int(w) for each in self._disturbances for w in each})
        begin = int(np.searchsorted(t, subject.criteria.settle))
        lengths = np.diff(t[begin:])
        self._rules = Rules(
            t, begin, np.array(pairs, dtype=np.int64),
            subject.criteria.threshold, subject.criteria.reset,
            lengths, float(lengths.sum()), _leaves(max(len(lengths), 1)),
        )  # fmt: skip

    def run(self, lanes: Lanes) -> Judged:
        """Take lanes to their end and judge them."""
        seen, rules = self._room(lanes.first), self._rules
        late = len(rules.t) - rules.begin
        self._take(
            seen, rules, lanes.room(), np.empty((len(rules.plants), late, LANES)),
            np.empty((rules.leaves.shape[1] + 9, LANES)), *lanes.parts,
        )  # fmt: skip
        rows = nothing(len(lanes.work) * LANES)
        _put_counts(rows, self._tally(seen))
        if late:
            _put_sizes(rows, seen)
        y, finite = rules.plants[:, 0], lanes.finite
        fallen = (seen.last[:, y] < self._lowest).any(axis=1).ravel()
        rejected = rows['verdict'] == VERDICTS.index(REJECTED)
        rows['verdict'][rejected & fallen] = VERDICTS.index(UNDECIDED)
        stuck = np.isinf(seen.level[:, y]).any(axis=1).ravel() & rejected & ~fallen
        n = len(finite)
        return Judged(rows[:n], self._holds(seen)[:n], finite, stuck[:n])

    def _room(self, first: Array) -> Seen:
        """Return what is seen at the start, where the judged signals are ``first``."""
        threshold, reset = self._rules.threshold, self._rules.reset
        blocks, width, _ = first.shape
        level = np.where(first < threshold, threshold, np.inf)
        level[first <= reset] = threshold
        counts = np.zeros(first.shape, dtype=np.int64)
        largest = np.zeros((blocks, len(self._rules.plants), LANES))
        room = ROOM + len(self._rules.t) // PER_EVENT
        return Seen(
            first,
            level,
            np.empty((blocks, width, room, LANES)),
            counts,
            np.zeros_like(counts),
            np.empty_like(first),
            largest,
            np.full_like(largest, -np.inf),
            np.zeros_like(largest),
        )

    def _holds(self, seen: Seen) -> Flags:
        fits: Flags = (seen.counts <= seen.times.shape[2]).all(axis=1).ravel()
        spiked, wide = (each[:, self._all].any(axis=1).ravel() for each in (seen.counts, seen.wide))
        holds: Flags = fits & (wide | ~spiked)
        return holds

    def _tally(self, seen: Seen) -> Array:
        """Return the counts of all plants, shape (plants, numbers, sets), as in _COUNTED."""
        shape = len(seen.counts), len(_COUNTED), LANES
        found = np.empty((len(self._disturbances), *shape))
        for i, ((y, y_r), w) in enumerate(
            zip(self._rules.plants.tolist(), self._disturbances, strict=True)
        ):
            _compiled('tally')(seen.times, seen.counts, y, y_r, w, *self._limits, found[i])
        by_number: Array = found.swapaxes(1, 2).reshape(len(found), len(_COUNTED), -1)
        return by_number


def _put_counts(rows: Rows, found: Array) -> None:
    """Put what was found of all plants into ``rows``, shape (plants, numbers, sets)."""
    numbers = dict(zip(_COUNTED, found.swapaxes(0, 1), strict=True))
    for name in ('disturbance_events', 'preserved', 'spurious', 'missed'):
        rows[name] = numbers[name].sum(axis=0)
    rows['settling'] = numbers['settling'].max(axis=0)
    total, count = sum(numbers['delay'], np.zeros(len(rows))), rows['preserved']
    rows['latency'] = np.where(count > 0, total / np.maximum(count, 1), 0.0)
    wrong = (numbers['spurious'] > 0) | (numbers['missed'] > 0)
    enough = numbers['disturbance_events'] >= ENOUGH
    undecided, rejected, not_rejected = map(VERDICTS.index, (UNDECIDED, REJECTED, NOT_REJECTED))
    verdict = np.where((~enough).any(axis=0), undecided, rejected)
    rows['verdict'] = np.where((enough & wrong).any(axis=0), not_rejected, verdict)


def _put_sizes(rows: Rows, seen: Seen) -> None:
    """Put the sizes of what is left of all plants into ``rows``."""
    largest, peak, means = (
        each.swapaxes(0, 1).reshape(each.shape[1], -1)
        for each in (seen.largest, seen.peak, seen.means)
    )
    rms = largest * np.sqrt(means)
    rows['peak'] = peak.max(axis=0)
    rows['residual_max_abs'], rows['residual_rms'] = largest[0], rms[0]
    if len(rms) == 1:
        return
    for i, pairs in enumerate(zip(largest.T.tolist(), rms.T.tolist(), strict=True)):
        size = together([Size(*pair) for pair in zip(*pairs, strict=True)])
        rows['residual_max_abs'][i], rows['residual_rms'][i] = size
