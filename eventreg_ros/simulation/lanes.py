# SPDX-License-Identifier: Apache-2.0
"""Many sets of parameters side by side: the sampled loop in lanes, compiled, to the same bits.

A block of :data:`.lanes_source.LANES` sets goes through the loop together; what they have in common
is a :class:`Course`, what differs from lane to lane :class:`Lanes`. Nothing is kept but the samples
of the signals that are asked for, and of those only a chunk at a time: whoever watches them is
compiled together with the loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..models import Params, State
from .block import BlockSpec, make_advance
from .code_cache import generated
from .hold import line
from .jit import compile_callee, compile_entry, inliner
from .kernel import NOBODY
from .lane_links import Links
from .lanes_source import COMMON, LANES, LaneBlock, Structure, layout, source_of
from .loop import Loop
from .trajectory import Array

CHUNK = 256
"""Steps between two looks at the samples: few enough that these stay in a cache."""


def structure_of(
    loop: Loop, wanted: Sequence[str], links: str = COMMON, noisy: Sequence[str] = ()
) -> Structure:
    """Return the structure of a loop; the samples of the signals ``wanted`` are handed out.

    ``noisy`` are the signals that blocks publish with noise.
    """
    row = {signal: i for i, signal in enumerate(loop.signals)}
    blocks = tuple(
        LaneBlock(
            spec.model,
            type(spec.params),
            len(spec.params),
            tuple(float(sign) for _, sign in spec.inputs),
            row[spec.output],
            tuple(row.get(signal, NOBODY) for signal, _ in spec.inputs),
            tuple((row[signal], i) for signal, i in spec.observed.items()),
        )
        for spec in loop.blocks.values()
    )
    signals = tuple(row[signal] for signal in wanted)
    with_noise = tuple(row[signal] for signal in noisy)
    return Structure(blocks, len(loop.stimuli), len(row), signals, links, with_noise)


@lru_cache(maxsize=64)
def compiled_with(structure: Structure, watcher: FunctionType) -> Any:
    """Return ``watcher`` compiled, with the ``advance`` of a structure as the global of that name.

    See :func:`.lanes_source.source_of` for how it is called.
    """
    compile = inliner()
    names: dict[str, Any] = {'L': LANES, 'line': compile(line)}
    for b, block in enumerate(structure.blocks):
        names[f'advance_{b}'] = make_advance(block.model, compile)
        names[f'pack_{b}'] = block.pack
    advance = generated(source_of(structure), 'advance', names)
    called = {
        name: compile_callee(function)
        for name in watcher.__code__.co_names
        if isinstance(function := watcher.__globals__.get(name), FunctionType)
    }
    home = {**watcher.__globals__, **called, 'advance': advance}
    return compile_entry(FunctionType(watcher.__code__, home, watcher.__name__))


@dataclass(frozen=True)
class Course:
    """What a block of lanes has in common.

    ``h`` is in model time, ``horizons`` are in steps, one per block. ``open_inputs`` has shape
    (stimuli, steps + 1, 1), or LANES in place of 1 where they differ; so has ``noise`` for the
    noisy signals, normal numbers of standard deviation 1.
    """

    structure: Structure
    steps: int
    h: float
    horizons: Array
    open_inputs: Array
    links: Links
    noise: Array


@dataclass(frozen=True)
class Start:
    """Where lanes begin, one array per block: states (n, dimension), parameters (n, count).

    ``outputs`` are those at the start, without noise, and ``sds`` the standard deviations of the
    noise, one per noisy signal, (n,) each.
    """

    x: Sequence[Array]
    params: Sequence[Array]
    outputs: Sequence[Array]
    sds: Sequence[Array] = ()

    @classmethod
    def of(cls, sets: Sequence[Sequence[BlockSpec]]) -> Start:
        """Return the start of sets of blocks."""
        blocks = list(zip(*sets, strict=True))
        return cls(
            [np.array([spec.x0 for spec in specs], dtype=np.float64) for specs in blocks],
            [
                np.array([tuple(spec.params) for spec in specs], dtype=np.float64)
                for specs in blocks
            ],
            [np.array([first_output(spec) for spec in specs]) for specs in blocks],
        )

    def times(self, count: int) -> Start:
        """Return the start of so many times the same sets."""
        x, params, outputs, sds = (
            [np.repeat(array, count, axis=0) for array in part]
            for part in (self.x, self.params, self.outputs, self.sds)
        )
        return Start(x, params, outputs, sds)


def first_output(spec: BlockSpec, x: State | None = None, params: Params | None = None) -> float:
    """Return the output of a block at the start, before any input has come."""
    return spec.model.output(
        spec.x0 if x is None else x, 0.0, spec.params if params is None else params
    )


class Lanes:
    """Blocks of lanes at their start; :func:`compiled_with` takes them on.

    ``work`` (blocks, numbers) and ``ring`` (blocks, numbers) are what ``advance`` reads and writes
    of each block, flat; ``tables`` and ``lags`` are those of :class:`.lane_links.Links`; ``first``
    are the wanted samples at the start, (blocks, wanted, LANES).
    """

    def __init__(self, course: Course, start: Start) -> None:
        self.course = course
        self._layout, self._count = layout(course.structure), len(start.outputs[0])
        blocks = -(-self._count // LANES)
        self._pad = np.minimum(np.arange(blocks * LANES), self._count - 1)
        self._work = np.zeros((blocks, self._layout.rows, LANES))
        self._size = 1 << (course.links.reach + 1).bit_length()
        self._ring = np.zeros((blocks, self._size, course.structure.signals, LANES))
        nothing = np.empty((blocks, 0), dtype=np.int64)
        self.tables, self.lags = (
            nothing if each is None else each for each in (course.links.tables, course.links.lags)
        )
        self._fill(start)
        self.work, self.ring = (each.reshape(blocks, -1) for each in (self._work, self._ring))
        self.first = np.ascontiguousarray(self._ring[:, 0, list(course.structure.wanted)])

    def _fill(self, start: Start) -> None:
        structure, lay, first = self.course.structure, self._layout, self._ring[:, 0]
        for s in range(structure.stimuli):
            first[:, s] = self.course.open_inputs[s, 0]
        for b, (block, rows) in enumerate(zip(structure.blocks, lay.blocks, strict=True)):
            self._work[:, rows.x] = x = self.by_lane(start.x[b])
            self._work[:, rows.params] = self.by_lane(start.params[b])
            first[:, block.row] = self.by_lane(start.outputs[b])
            for signal, i in block.observed:
                first[:, signal] = x[:, i]
        for i, signal in enumerate(structure.noisy):
            sd = self._work[:, lay.sds[i]] = self.by_lane(start.sds[i])
            first[:, signal] += sd * self.course.noise[i, 0]
        self._work[:, lay.now] = self._work[:, lay.before] = first

    def by_lane(self, values: Array) -> Array:
        """Return ``values`` by lanes, (blocks, ..., LANES): lanes beyond them do as the last."""
        padded = values[self._pad].reshape(len(self._work), LANES, *values.shape[1:])
        return np.moveaxis(padded, 1, -1)

    def room(self) -> Array:
        """Return room for the samples of a chunk, shape (chunk + 1, wanted, LANES)."""
        chunk = min(CHUNK, self.course.steps)
        return np.empty((chunk + 1, len(self.course.structure.wanted), LANES))

    @property
    def parts(self) -> tuple[Any, ...]:
        """What a watcher takes last: ``work``, ``ring``, ``tables``, ``lags``, then ``motion``."""
        course = self.course
        motion = (
            course.h,
            self._size - 1,
            course.open_inputs.ravel(),
            course.open_inputs.shape[2],
            course.links.newest,
            course.links.previous,
            course.links.span,
            course.steps,
            course.horizons,
            course.noise.ravel(),
            course.noise.shape[2],
        )
        return self.work, self.ring, self.tables, self.lags, motion

    @property
    def finite(self) -> npt.NDArray[np.bool_]:
        """Which sets have had finite samples and states only, shape (n,)."""
        states = [row for rows in self._layout.blocks for row in rows.x]
        finite: npt.NDArray[np.bool_] = np.isfinite(self._work[:, [*states, self._layout.alarm]])
        every: npt.NDArray[np.bool_] = np.logical_and.reduce(finite, axis=1)
        return every.ravel()[: self._count]
