# SPDX-License-Identifier: Apache-2.0
"""Lanes judged as they go: events counted and matched, residuals measured, to a row each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.rejection import ENOUGH, NOT_REJECTED, REJECTED, UNDECIDED
from ..analysis.signal import Size, together
from ..analysis.subject import Subject
from ..scenario import Criteria
from ..simulation.jit import compile_entry
from ..simulation.lanes import Lanes
from ..simulation.lanes_source import LANES
from ..simulation.trajectory import Array
from . import lane_counts
from .outcome import VERDICTS, Rows, nothing

_COUNTED = ('disturbance_events', 'preserved', 'spurious', 'missed', 'settling', 'delay')
"""What :func:`.lane_counts.tally` finds, in its order."""


ROOM = 128
"""Events of one signal in one lane that there is room for."""


@lru_cache(maxsize=8)
def _compiled(name: str) -> Any:
    return compile_entry(getattr(lane_counts, name))


@lru_cache(maxsize=8)
def _leaves(count: int) -> npt.NDArray[np.int64]:
    """Return how numpy adds up so many numbers: starts, sizes and joins, shape (3, leaves)."""
    leaves: npt.NDArray[np.int64] = np.array(lane_counts.halves(0, count)).T.copy()
    return leaves


class _Plant(NamedTuple):
    """A plant, by the places of its signals among the judged ones; ``y_r`` -1 without one."""

    y: int
    y_r: int
    disturbances: npt.NDArray[np.int64]


def judge_lanes(
    lanes: Lanes, judged: Sequence[str], t: Array, subject: Subject
) -> tuple[Rows, npt.NDArray[np.bool_]]:
    """Take lanes to their end; return a row for each, and which of the rows hold.

    A lane that does not stay finite, or has more events than there is room for, has no row.
    ``judged`` are the signals that the lanes hand out, ``t`` the times of all samples.
    """
    plants = [
        _Plant(
            judged.index(plant.output),
            -1 if plant.reference is None else judged.index(plant.reference),
            np.array([judged.index(w) for w in plant.disturbances], dtype=np.int64),
        )
        for plant in subject.plants
    ]
    events = _Events(len(judged), subject.criteria)
    left = [_Residual(plant, len(judged), t, subject.criteria.settle) for plant in plants]
    for first, last, samples in lanes.chunks():
        events.watch(first, last, samples, t)
        for each in left:
            each.gather(first, last, samples)
    rows = nothing(LANES)
    _put_counts(rows, np.array([events.tally(plant) for plant in plants]))
    _put_sizes(rows, left)
    return rows, lanes.finite & events.complete


def _put_counts(rows: Rows, found: Array) -> None:
    """Put what was found of all plants into ``rows``, shape (plants, numbers, LANES)."""
    numbers = dict(zip(_COUNTED, found.swapaxes(0, 1), strict=True))
    for name in ('disturbance_events', 'preserved', 'spurious', 'missed'):
        rows[name] = numbers[name].sum(axis=0)
    rows['settling'] = numbers['settling'].max(axis=0)
    total, count = sum(numbers['delay'], np.zeros(LANES)), rows['preserved']
    rows['latency'] = np.where(count > 0, total / np.maximum(count, 1), 0.0)
    wrong = (numbers['spurious'] > 0) | (numbers['missed'] > 0)
    enough = numbers['disturbance_events'] >= ENOUGH
    undecided, rejected, not_rejected = map(VERDICTS.index, (UNDECIDED, REJECTED, NOT_REJECTED))
    verdict = np.where((~enough).any(axis=0), undecided, rejected)
    rows['verdict'] = np.where((enough & wrong).any(axis=0), not_rejected, verdict)


def _put_sizes(rows: Rows, left: Sequence[_Residual]) -> None:
    """Put the sizes of what is left of all plants into ``rows``."""
    sizes = [each.measure() for each in left]
    if sizes[0] is None:
        return
    known = [size for size in sizes if size is not None]
    rows['peak'] = np.max([each.peak for each in left], axis=0)
    if len(known) == 1:
        rows['residual_max_abs'], rows['residual_rms'] = known[0]
        return
    for lane in range(LANES):
        pairs = [Size(float(most[lane]), float(rms[lane])) for most, rms in known]
        row = rows[lane]
        row['residual_max_abs'], row['residual_rms'] = together(pairs)


class _Events:
    """The events of all judged signals in all lanes."""

    def __init__(self, width: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._level = np.empty((width, LANES))
        self._counts = np.zeros((width, LANES), dtype=np.int64)
        self._times = np.empty((width, ROOM, LANES))

    def watch(self, first: int, last: int, samples: Array, t: Array) -> None:
        """Take the samples of a chunk."""
        limits = self._criteria.threshold, self._criteria.reset
        if first == 0:
            self._level[:] = np.where(samples[0] < limits[0], limits[0], np.inf)
            self._level[samples[0] <= limits[1]] = limits[0]
        flat, t = samples.ravel(), t[first : last + 1]
        for j in range(len(self._level)):
            _compiled('watch')(
                flat, last - first, len(self._level), j, t, *limits,
                self._level[j], self._times[j].ravel(), self._counts[j],
            )  # fmt: skip

    def tally(self, plant: _Plant) -> Array:
        """Return the counts of one plant, shape (numbers, LANES), as :data:`_COUNTED` has them."""
        found = np.empty((len(_COUNTED), LANES))
        limits = self._criteria.settle, self._criteria.window
        _compiled('tally')(self._times, self._counts, *plant, *limits, found)
        return found

    @property
    def complete(self) -> npt.NDArray[np.bool_]:
        """Which lanes had room for all their events."""
        fits: npt.NDArray[np.bool_] = np.logical_and.reduce(self._counts <= ROOM)
        return fits


class _Residual:
    """What is left of the disturbance after ``settle``: y - y_r in all lanes."""

    def __init__(self, plant: _Plant, width: int, t: Array, settle: float) -> None:
        self._plant, self._width = plant, width
        self._begin = int(np.searchsorted(t, settle))
        self._t = t[self._begin :]
        self._table = np.empty((len(self._t), LANES))
        self._largest, self.peak = np.zeros(LANES), np.full(LANES, -np.inf)

    def gather(self, first: int, last: int, samples: Array) -> None:
        """Take the samples of a chunk."""
        start = max(first + 1 if first else 0, self._begin)
        if start <= last:
            _compiled('gather')(
                samples.ravel(), last - first, self._width, self._plant.y, self._plant.y_r,
                self._table[start - self._begin :].ravel(), start - first,
                self._largest, self.peak,
            )  # fmt: skip

    def measure(self) -> tuple[Array, Array] | None:
        """Return the largest magnitudes and the rms, shape (LANES,) each; None without samples."""
        if not len(self._t):
            return None
        means = self._table[0] / np.where(self._largest == 0.0, 1.0, self._largest)
        means *= means
        if len(self._t) > 1:
            lengths = np.diff(self._t)
            leaves = _leaves(len(lengths))
            stack = np.empty((leaves.shape[1] + 9) * LANES)
            _compiled('mean_squares')(
                self._table.ravel(), len(self._t), lengths, lengths.sum(), *leaves,
                self._largest, stack, means,
            )  # fmt: skip
        return self._largest, self._largest * np.sqrt(means)
