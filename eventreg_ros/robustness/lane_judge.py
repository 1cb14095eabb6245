"""Lanes judged as they go: events counted and matched, residuals measured, to a row each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..analysis.rejection import ENOUGH
from ..scenario import Criteria
from ..simulation.jit import compile_entry
from ..simulation.lanes import Lanes
from ..simulation.lanes_source import LANES
from ..simulation.trajectory import Array
from . import lane_counts
from .outcome import VERDICTS, Rows, nothing

_COUNTED = ('disturbance_events', 'preserved', 'spurious', 'missed', 'settling', 'latency')
"""What :func:`.lane_counts.tally` finds, in its order."""


ROOM = 128
"""Events of one signal in one lane that there is room for."""


@lru_cache(maxsize=8)
def _compiled(name: str) -> Any:
    return compile_entry(getattr(lane_counts, name))


def judge_lanes(
    lanes: Lanes, judged: Sequence[str], t: Array, criteria: Criteria
) -> tuple[Rows, npt.NDArray[np.bool_]]:
    """Take lanes to their end; return a row for each, and which of the rows hold.

    A lane that does not stay finite, or has more events than there is room for, has no row.
    ``judged`` are the signals that the lanes hand out, ``t`` the times of all samples.
    """
    events = _Events(len(judged), criteria)
    left = _Residual(judged, t, criteria.settle)
    for first, last, samples in lanes.chunks():
        events.watch(first, last, samples, t)
        left.gather(first, last, samples)
    rows = nothing(LANES)
    places = [judged.index(s) if s in judged else -1 for s in ('y', 'y_r', 'w')]
    events.tally(rows, *places)
    left.measure(rows)
    return rows, lanes.finite & events.complete


class _Events:
    """The events of all judged signals in all lanes."""

    def __init__(self, width: int, criteria: Criteria) -> None:
        self._criteria = criteria
        self._armed, self._hits, self._counts = (
            np.zeros((width, LANES), dtype=np.int64) for _ in range(3)
        )
        self._times = np.empty((width, ROOM, LANES))

    def watch(self, first: int, last: int, samples: Array, t: Array) -> None:
        """Take the samples of a chunk."""
        limits = self._criteria.threshold, self._criteria.reset
        if first == 0:
            self._armed[:] = samples[0] < limits[0]
        flat, t = samples.ravel(), t[first : last + 1]
        for j in range(len(self._armed)):
            _compiled('watch')(
                flat, last - first, len(self._armed), j, t, *limits,
                self._armed[j], self._hits[j], self._times[j].ravel(), self._counts[j],
            )  # fmt: skip

    def tally(self, rows: Rows, y: int, y_r: int, w: int) -> None:
        """Count and match them into ``rows``; the signals are numbers of judged ones."""
        found = np.empty((len(_COUNTED), LANES))
        limits = self._criteria.settle, self._criteria.window
        _compiled('tally')(self._times, self._counts, y, y_r, w, *limits, found)
        for name, values in zip(_COUNTED, found, strict=True):
            rows[name] = values
        bad = (rows['spurious'] > 0) | (rows['missed'] > 0)
        decided = rows['disturbance_events'] >= ENOUGH
        words = [VERDICTS.index(word) for word in ('undecided', 'rejected', 'not rejected')]
        rows['verdict'] = np.choose(decided * (1 + bad), words)

    @property
    def complete(self) -> npt.NDArray[np.bool_]:
        """Which lanes had room for all their events."""
        fits: npt.NDArray[np.bool_] = np.logical_and.reduce(self._counts <= ROOM)
        return fits


class _Residual:
    """What is left of the disturbance after ``settle``: y - y_r in all lanes."""

    def __init__(self, judged: Sequence[str], t: Array, settle: float) -> None:
        self._width = len(judged)
        self._y, self._y_r = judged.index('y'), judged.index('y_r') if 'y_r' in judged else -1
        self._begin = int(np.searchsorted(t, settle))
        self._t = t[self._begin :]
        self._table = np.empty((len(self._t), LANES))
        self._largest, self._peak = np.zeros(LANES), np.full(LANES, -np.inf)

    def gather(self, first: int, last: int, samples: Array) -> None:
        """Take the samples of a chunk."""
        start = max(first + 1 if first else 0, self._begin)
        if start <= last:
            _compiled('gather')(
                samples.ravel(), last - first, self._width, self._y, self._y_r,
                self._table[start - self._begin :].ravel(), start - first,
                self._largest, self._peak,
            )  # fmt: skip

    def measure(self, rows: Rows) -> None:
        """Put the sizes into ``rows``."""
        if not len(self._t):
            return
        rows['residual_max_abs'], rows['peak'] = self._largest, self._peak
        means = self._table[0] / np.where(self._largest == 0.0, 1.0, self._largest)
        means *= means
        if len(self._t) > 1:
            lengths = np.diff(self._t)
            leaves = np.array(lane_counts.halves(0, len(lengths)))
            stack = np.empty((len(leaves) + 9) * LANES)
            _compiled('mean_squares')(
                self._table.ravel(), len(self._t), lengths, lengths.sum(), *leaves.T.copy(),
                self._largest, stack, means,
            )  # fmt: skip
        rows['residual_rms'] = self._largest * np.sqrt(means)
