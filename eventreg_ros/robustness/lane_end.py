# SPDX-License-Identifier: Apache-2.0
"""Lanes that diverge: when each stops being finite, or since when its outputs have been up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.subject import Subject
from ..simulation.lanes import Lanes, compiled_with
from ..simulation.lanes_source import LANES
from ..simulation.trajectory import Array

Steps = npt.NDArray[np.int64]


class Ends(NamedTuple):
    """How sets end, shape (n,) each.

    ``times`` (model time) is the first sample of a set that is not finite, the last one where all
    are. ``held_up`` says whether an output was up all the time, as the evidence has it.
    """

    times: Array
    held_up: npt.NDArray[np.bool_]


def ends_of(lanes: Lanes, count: int, signals: Sequence[str], subject: Subject, t: Array) -> Ends:
    """Take ``count`` sets to their end, over the times ``t``; the lanes hand out ``signals``."""
    steps, limits = lanes.course.steps, subject.criteria
    broken = np.full((len(lanes.work), LANES), steps, dtype=np.int64)
    broken[~np.isfinite(lanes.first).all(axis=1)] = 0
    below = np.where(lanes.first < limits.threshold, 0, -1)
    take = compiled_with(lanes.course.structure, look)
    take(lanes.room(), broken, below, steps, limits.threshold, *lanes.parts)
    since = np.append(t, np.inf)[below.swapaxes(0, 1).reshape(len(signals), -1)[:, :count] + 1]
    up = dict(zip(signals, (since <= limits.settle) & (t[-1] > limits.settle), strict=True))
    held = np.zeros(count, dtype=bool)
    for plant in subject.plants:
        asked = np.zeros_like(held) if plant.reference is None else up[plant.reference]
        held = held | (up[plant.output] & ~asked)
    return Ends(t[broken.ravel()[:count]], held)


def look(
    out: Array, broken: Steps, below: Steps, steps: int, threshold: float,
    work: Array, ring: Array, tables: Any, lags: Any, motion: Any,
) -> None:  # fmt: skip
    """Find the first sample that is not finite, and the last one of each signal below threshold.

    ``broken``, shape (blocks, LANES), is lowered to the one, and ``below``, (blocks, signals,
    LANES), raised to the other. ``out`` is room for a chunk of samples; the rest is as ``advance``
    takes it.
    """
    for b in range(len(work)):
        last = gone = 0
        while last < steps and gone < LANES:
            first, last = last, min(last + len(out) - 1, steps)
            advance(  # type: ignore[name-defined] # noqa: F821
                first, last, out, work[b], ring[b], tables[b], lags[b], *motion
            )
            gone = 0
            for a in range(LANES):
                for r in range(1, last - first + 1):
                    total = 0.0
                    for j in range(below.shape[1]):
                        x = out[r, j, a]
                        total += x * 0.0
                        below[b, j, a] = first + r if x < threshold else below[b, j, a]
                    if total != 0.0:
                        broken[b, a] = min(broken[b, a], first + r)
                gone += 1 if broken[b, a] < last else 0
