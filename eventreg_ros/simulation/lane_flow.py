# SPDX-License-Identifier: Apache-2.0
"""The sampled loop as a map: from any state over a number of steps, many states side by side.

The steps are those of every simulation (:mod:`.lanes`), so what is found of this map is true of the
simulated loop. Links are perfect: each block uses the sample made when its step begins and the one
before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .impairment import Index
from .lane_links import Links
from .lanes import Course, Lanes, Start, compiled_with, first_output, structure_of
from .lanes_source import LANES, PERFECT, layout
from .loop import Loop
from .trajectory import Array

_NOTHING = np.empty((0, 0, 1))


class Passage(NamedTuple):
    """Where states went: their ends, shape (n, size), and samples, (n, wanted, steps + 1)."""

    ends: Array
    samples: Array


class LaneFlow:
    """A loop of ordinary blocks without open inputs, taken on from given states.

    A state holds the states of all blocks, then the samples of all signals when the next step
    begins, then those of a step earlier; so its ``size`` is that of all these. ``wanted`` are the
    signals whose samples are handed out. Raises EventregError where there is no numba.
    """

    def __init__(self, loop: Loop, wanted: Sequence[str]) -> None:
        self._loop, self._specs = loop, list(loop.blocks.values())
        self._structure = structure_of(loop, wanted, PERFECT)
        self._take = compiled_with(self._structure, take)
        self._horizons = np.array([spec.horizon for spec in self._specs])
        lay = layout(self._structure)
        self._of_blocks = [row for rows in lay.blocks for row in rows.x]
        self._rows = [*self._of_blocks, *lay.now, *lay.before]
        self.size = len(self._rows)

    @property
    def start(self) -> Array:
        """The state in which the loop begins, shape (size,)."""
        x = [number for spec in self._specs for number in spec.x0]
        samples = dict[str, float]()
        for spec in self._specs:
            samples[spec.output] = first_output(spec)
            samples |= {signal: spec.x0[i] for signal, i in spec.observed.items()}
        now = [samples[signal] for signal in self._loop.signals]
        return np.array([*x, *now, *now])

    def sample_of(self, signal: str) -> int:
        """Return the place in a state of the newest sample of ``signal``."""
        return len(self._of_blocks) + self._loop.signals.index(signal)

    def places_of(self, name: str) -> list[int]:
        """Return the places in a state of all that belongs to the block ``name``."""
        spec, first = self._loop.blocks[name], 0
        for other in self._specs:
            if other is spec:
                break
            first += len(other.x0)
        own = list(range(first, first + len(spec.x0)))
        now = [self.sample_of(signal) for signal in spec.signals]
        return [*own, *now, *(place + len(self._loop.signals) for place in now)]

    def take(self, z: Array, params: Sequence[Array], h: float, steps: int) -> Passage:
        """Take states ``z``, shape (n, size), over ``steps`` steps of ``h`` (model time).

        ``params`` are those of each block, shape (n, count).
        """
        z = np.asarray(z, dtype=np.float64)
        nothing = [np.zeros((len(z), len(spec.x0))) for spec in self._specs]
        start = Start(nothing, params, [np.zeros(len(z))] * len(self._specs))
        course = Course(
            self._structure, steps, h, self._horizons, _NOTHING, Links.perfect(), _NOTHING
        )
        lanes = Lanes(course, start)
        blocks = len(lanes.work)
        table = lanes.work.reshape(blocks, -1, LANES)
        table[:, self._rows] = lanes.by_lane(z)
        wanted = self._structure.wanted
        out = np.empty((blocks, steps + 1, len(wanted), LANES))
        out[:, 0] = table[:, [self._rows[len(self._of_blocks) + s] for s in wanted]]
        self._take(out, steps, *lanes.parts)
        ends = table[:, self._rows].swapaxes(1, 2).reshape(blocks * LANES, -1)
        samples = out.transpose(0, 3, 2, 1).reshape(blocks * LANES, len(wanted), -1)
        return Passage(ends[: len(z)], samples[: len(z)])


def take(
    out: Array, steps: int, work: Array, ring: Array, tables: Index, lags: Index,
    motion: tuple[object, ...],
) -> None:  # fmt: skip
    """Take blocks of lanes through all steps and keep all samples; compiled with ``advance``."""
    for b in range(len(work)):
        advance(  # type: ignore[name-defined] # noqa: F821
            0, steps, out[b], work[b], ring[b], tables[b], lags[b], *motion
        )
