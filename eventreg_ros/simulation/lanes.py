# SPDX-License-Identifier: Apache-2.0
"""Many sets of parameters side by side: the sampled loop in lanes, compiled, to the same bits.

A block of :data:`.lanes_source.LANES` sets goes through the loop together; what they have in common
is a :class:`Course`, what differs from lane to lane :class:`Lanes`. Nothing is kept but the samples
of the signals that are asked for, and of those only a chunk at a time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..models import Params, State
from .block import BlockSpec, make_advance
from .code_cache import generated
from .hold import line
from .impairment import Index, Received
from .jit import compile_entry, inliner
from .kernel import NOBODY
from .lanes_source import COMMON, LANES, LaneBlock, Rows, Structure, layout, source_of
from .loop import Loop
from .trajectory import Array

CHUNK = 2048
"""Steps between two looks at the samples: so many that calls cost nothing, and no more."""


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
def _compiled(structure: Structure) -> Any:
    compile = inliner()
    names: dict[str, Any] = {'L': LANES, 'line': compile(line)}
    for b, block in enumerate(structure.blocks):
        names[f'advance_{b}'] = make_advance(block.model, compile)
        names[f'pack_{b}'] = block.pack
    return compile_entry(generated(source_of(structure), 'advance', names))


class Links(NamedTuple):
    """What all links have received at each step, as the kernel reads it.

    Common to all lanes, both have shape (links, steps); scattered, (links, steps, LANES). ``reach``
    is how many steps back the oldest sample lies that is still needed.
    """

    newest: Index | npt.NDArray[np.int32]
    previous: Index | npt.NDArray[np.int32]
    reach: int

    @classmethod
    def perfect(cls) -> Links:
        """Return the links of lanes in which every sample arrives at once."""
        nothing = np.empty(0, dtype=np.int64)
        return cls(nothing, nothing, 0)

    @classmethod
    def common(cls, have: Received) -> Links:
        """Return the links of lanes that have all received the same samples."""
        return cls(have.newest.ravel(), have.previous.ravel(), _reach(have))

    @classmethod
    def scattered(cls, each: Sequence[Received]) -> Links:
        """Return the links of lanes with samples of their own; further lanes do as the last."""
        newest = _by_lane([have.newest.ravel() for have in each])
        previous = _by_lane([have.previous.ravel() for have in each])
        return cls(newest, previous, max(map(_reach, each)))


def _by_lane(tables: Sequence[Index]) -> npt.NDArray[np.int32]:
    """Return flat tables with the lane as their last index; further lanes do as the last."""
    rows = np.empty((LANES, len(tables[0])), dtype=np.int32)
    for lane, table in enumerate(tables):
        rows[lane] = table
    rows[len(tables) :] = tables[-1]
    return np.ascontiguousarray(rows.T).ravel()


def _reach(have: Received) -> int:
    back = 0
    for newest, previous in zip(have.newest, have.previous, strict=True):
        none, one = np.count_nonzero(newest < 0), np.count_nonzero(previous < 0)
        n = np.arange(len(newest))
        for oldest in (n[none:one] - newest[none:one], n[one:] - previous[one:]):
            back = max(back, int(oldest.max(initial=0)))
    return back


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
    noise, one per noisy signal, (n,) each; n is at most LANES.
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


def first_output(spec: BlockSpec, x: State | None = None, params: Params | None = None) -> float:
    """Return the output of a block at the start, before any input has come."""
    return spec.model.output(
        spec.x0 if x is None else x, 0.0, spec.params if params is None else params
    )


class Lanes:
    """A block of lanes on its way."""

    def __init__(self, course: Course, start: Start) -> None:
        self.course = course
        self._layout = layout(course.structure)
        self._work = np.zeros((self._layout.rows, LANES))
        self._size = 1 << (course.links.reach + 1).bit_length()
        self._ring = np.zeros((self._size, course.structure.signals, LANES))
        self._fill(start)
        width = len(course.structure.wanted)
        self._out = np.empty((min(CHUNK, course.steps) + 1, width, LANES))
        self._out[0] = self._ring[0, list(course.structure.wanted)]

    def _fill(self, start: Start) -> None:
        structure = self.course.structure
        for s in range(structure.stimuli):
            self._ring[0, s] = self.course.open_inputs[s, 0]
        blocks = zip(structure.blocks, self._layout.blocks, strict=True)
        for b, (block, rows) in enumerate(blocks):
            self._put(rows, start.x[b], start.params[b])
            self._ring[0, block.row] = _padded(start.outputs[b])
            for signal, i in block.observed:
                self._ring[0, signal] = _padded(start.x[b][:, i])
        for i, signal in enumerate(structure.noisy):
            sd = self._work[self._layout.sds[i]] = _padded(start.sds[i])
            self._ring[0, signal] += sd * self.course.noise[i, 0]
        self._work[self._layout.now] = self._work[self._layout.before] = self._ring[0]

    def _put(self, rows: Rows, x: Array, params: Array) -> None:
        self._work[rows.x] = _padded(x).T
        self._work[rows.params] = _padded(params).T

    def chunks(self) -> Iterator[tuple[int, int, Array]]:
        """Take the lanes through all steps; yield (first, last, samples) after each chunk.

        ``samples`` has shape (chunk + 1, wanted signals, LANES): samples ``first`` to ``last`` in
        its first rows. It is overwritten by the next chunk.
        """
        course, last = self.course, 0
        advance, open_inputs = _compiled(course.structure), course.open_inputs.ravel()
        stride = course.open_inputs.shape[2] if course.structure.stimuli else 1
        noise = course.noise.ravel(), course.noise.shape[2]
        work, ring, out = self._work.ravel(), self._ring.ravel(), self._out.ravel()
        while last < course.steps:
            first, last = last, min(last + CHUNK, course.steps)
            advance(
                first, last, course.h, work, ring, self._size - 1, open_inputs, stride,
                course.links.newest, course.links.previous, course.steps, course.horizons,
                *noise, out,
            )  # fmt: skip
            yield first, last, self._out
            self._out[0] = self._out[last - first]

    @property
    def finite(self) -> npt.NDArray[np.bool_]:
        """Which lanes have had finite samples and states only, shape (LANES,)."""
        states = [row for rows in self._layout.blocks for row in rows.x]
        finite: npt.NDArray[np.bool_] = np.isfinite(self._work[[*states, self._layout.alarm]])
        every: npt.NDArray[np.bool_] = np.logical_and.reduce(finite)
        return every


def _padded(values: Array) -> Array:
    """Return ``values``, shape (n, ...), as LANES lanes: those beyond n do as the last."""
    lanes: Array = values[np.minimum(np.arange(LANES), len(values) - 1)]
    return lanes
