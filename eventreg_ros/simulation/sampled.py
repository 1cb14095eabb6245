# SPDX-License-Identifier: Apache-2.0
"""The closed loop as the nodes run it in lockstep: sample by sample, to the same bits."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import replace
from itertools import count, islice
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import EventregError
from .block import BlockSpec, begin
from .coding import Coder
from .copies import NO_COPIES, Copies, copies_of
from .impairment import PERFECT, Impairment, Received, received
from .jit import choose, give_up
from .kernel import NOBODY, Part, Tables, Tuning, flatten, nest
from .loop import Loop
from .model_errors import in_words
from .model_time import count_steps, model_times
from .noise import SILENCE, Noise
from .stimulus import Stimulus
from .trajectory import Array, Trajectory
from .turns import Condition, Turn, stretches


def simulate_sampled(
    loop: Loop,
    duration: float,
    impairment: Impairment = PERFECT,
    turns: Sequence[Turn] = (),
    *,
    noise: Noise = SILENCE,
    compiled: bool | None = None,
) -> Trajectory:
    """Step all blocks of ``loop`` together over ``duration``; see :meth:`SampledLoop.run`."""
    return SampledLoop(loop).run(duration, impairment, turns, noise=noise, compiled=compiled)


class SampledLoop:
    """A loop, ready to run sample by sample any number of times.

    A link is (receiving block, signal); ``links`` lists them in the order in which they draw their
    random numbers. An input that nobody publishes is no link and counts as 0. Raises EventregError
    when the blocks disagree on time_scale or rate.
    """

    def __init__(self, loop: Loop) -> None:
        self._time_scale, self._rate = loop.grid
        self._models, self._foreign = loop.models, loop.foreign_models
        with in_words(self._foreign):
            self._start = [Condition.of(spec) for spec in loop.blocks.values()]
        self._names = list(loop.blocks)
        self._stimuli = {name: Waveform(each) for name, each in loop.stimuli.items()}
        self.signals, self.links = loop.signals, loop.links
        self._row = {signal: i for i, signal in enumerate(self.signals)}
        linked = [
            (lead, drawn)
            for spec in loop.blocks.values()
            for (signal, _), lead, drawn in zip(spec.inputs, spec.leads, spec.drawn, strict=True)
            if signal in self._row
        ]
        self._leads = [lead for lead, _ in linked]
        self._drawn = [drawn for _, drawn in linked]

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return self._time_scale / self._rate

    @property
    def parts(self) -> tuple[Part, ...]:
        """What the kernel of this loop is built for."""
        return self._parts(self._start)

    def _parts(
        self, blocks: Sequence[Condition], noise: Noise = SILENCE, copies: Copies = NO_COPIES
    ) -> tuple[Part, ...]:
        row, links = self._row, count()
        heard = [
            tuple(
                copies.row_of(next(links), row[signal]) if signal in row else NOBODY
                for signal, _ in each.spec.inputs
            )
            for each in blocks
        ]
        return tuple(
            Part(
                each.model,
                row[each.spec.output],
                sources,
                tuple((row[signal], i) for signal, i in each.spec.observed.items()),
                each.make,
                noise.reaches(each.spec.output),
                each.code and each.code._replace(copies=copies.to(each.spec.output)),
            )
            for each, sources in zip(blocks, heard, strict=True)
        )

    def steps(self, duration: float) -> int:
        """Return the number of steps of a run. Raises EventregError for a bad ``duration``."""
        return count_steps(duration, self.h, len(self.signals) + 2 * len(self.links))

    def run(
        self,
        duration: float,
        impairment: Impairment = PERFECT,
        turns: Sequence[Turn] = (),
        *,
        noise: Noise = SILENCE,
        compiled: bool | None = None,
    ) -> Trajectory:
        """Return all signals at n * h from 0 to ``duration`` (model time).

        Over step n every block uses the samples up to n that its links have received under
        ``impairment``; before the first, an input is 0. A turn at model time T is taken at the
        sample nearest to it and acts from the step that begins there. ``noise`` is added to what
        blocks publish, so that it reaches whoever listens. ``compiled`` says whether
        numba compiles the loop (None: where that pays); same bits. Raises EventregError for a bad
        duration, or when a state stops being finite.
        """
        steps = self.steps(duration)
        signals = [signal for _, signal in self.links]
        specs = [each.spec for each in self._start]
        copies = copies_of(specs, signals, impairment, len(self.signals), steps)
        have = received(signals, steps, self.h, impairment, self._leads)
        have = copies.received(have, signals, steps, self.h, impairment, self._leads)
        t = model_times(steps, self._time_scale, self._rate)
        with in_words(self._foreign):
            table, blocks = self._samples(t), list(self._start)
        for signal, added in noise.draw(steps + 1):
            table[self._row[signal]] += added
        table = self._code_first(blocks, table, copies)
        for first, last, due in stretches(turns, steps, self.h):
            for turn in due:
                self._take(turn, blocks, table, t, first)
            with in_words(self._models):
                stretch = first, last
                table = self._advance(blocks, table, have, stretch, noise, copies, compiled)
        with in_words(self._foreign):
            _check(t, table, [number for each in blocks for number in each.x])
        table = table[: len(self.signals)]
        sent = {e.spec.output: e.messages for e in blocks if e.spec.coding is not None}
        return Trajectory(t, dict(zip(self.signals, table, strict=True)), sent)

    def _advance(
        self,
        blocks: list[Condition],
        table: Array,
        have: Received,
        stretch: tuple[int, int],
        noise: Noise,
        copies: Copies,
        compiled: bool | None,
    ) -> Array:
        """Move ``blocks`` on over a stretch of steps; return the table of samples, filled there."""
        first, last = stretch
        effort = sum(e.spec.numbered.effort(e.spec) if e.spec.numbered else 1.0 for e in blocks)
        parts = self._parts(blocks, noise, copies)
        links = np.array(self._leads, np.int64), np.array(self._drawn, np.float64)
        flat = [each.ravel() for each in (table, *have, *links, copies.lost)]
        states = nest([each.x for each in blocks])
        tuning = nest([_tuning(e.spec) for e in blocks])
        arrays = True
        try:
            kernel, arrays = choose(parts, round((last - first) * effort), compiled)
            samples, newest, previous, used, leads, drawn, lost = (
                flat if arrays else map(_plain, flat)
            )
            tables = Tables(
                samples, newest, previous, used, leads, drawn, lost,
                table.shape[1] - 1, self.h, first, last,
            )  # fmt: skip
            numbers = iter(flatten(kernel(states, tuning, tables)))
        except Exception:  # numba's, about code that is not written for it, or of the code itself
            if compiled or not arrays or not self._foreign:
                raise
            give_up(parts)
            return self._advance(blocks, table, have, stretch, noise, copies, False)
        blocks[:] = [
            replace(each, x=tuple(islice(numbers, len(each.x))), starting=False) for each in blocks
        ]
        return np.asarray(tables.samples).reshape(table.shape)

    def _code_first(self, blocks: list[Condition], table: Array, copies: Copies) -> Array:
        """Code sample 0 of the outputs that are coded; return the table with rows for copies."""
        table = np.vstack((table, np.zeros((copies.rows, table.shape[1])))) if copies.of else table
        for i, each in enumerate(blocks):
            if each.spec.coding is not None:
                row = self._row[each.spec.output]
                coder = Coder(each.spec.coding, each.spec.rate, each.spec.h)
                table[row, 0] = coder(float(table[row, 0]))
                x = each.x[: -len(coder.state)]
                blocks[i] = replace(each, x=x + coder.state)
                for row, lost in copies.to(each.spec.output):
                    known = each.spec.coding.unheard
                    table[row : row + len(known), 0] = known
                    if coder.state[0] and not copies.lost[lost, 0]:
                        table[row, 0] = table[self._row[each.spec.output], 0]
        return table

    def _take(
        self, turn: Turn, blocks: list[Condition], table: Array, t: Array, first: int
    ) -> None:
        """Let a turn act from sample ``first`` on."""
        if turn.stimulus is not None:
            after = t[first + 1 :].tolist()
            table[self._row[turn.name], first + 1 :] = [turn.stimulus(time) for time in after]
        else:
            i = self._names.index(turn.name)
            blocks[i] = blocks[i].after(turn, first)

    def _samples(self, t: Array) -> Array:
        """Return the table of samples, shape (signals, samples), as far as it is known."""
        table = np.zeros((len(self.signals), len(t)))
        for name, waveform in self._stimuli.items():
            table[self._row[name]] = waveform.at(t)
        for part, each in zip(self.parts, self._start, strict=True):
            table[part.row, 0] = begin(each.spec)[1]
            for signal, i in part.observed:
                table[signal, 0] = each.x[i]
        return table


class Waveform:
    """A stimulus at the samples of a grid, kept for the next run."""

    def __init__(self, stimulus: Stimulus) -> None:
        self._stimulus = stimulus
        self._known = np.empty(0)

    def at(self, t: Array) -> Array:
        """Return the values at ``t``, model times that always begin alike; shape (n,)."""
        if len(self._known) < len(t):
            self._known = np.array([self._stimulus(time) for time in t.tolist()])
        return self._known[: len(t)]


def _plain(table: npt.NDArray[Any]) -> array[Any]:
    """Return a table as plain Python reads it best: its numbers are Python's own."""
    return array('d' if table.dtype == np.float64 else 'q', table.tobytes())


def _tuning(spec: BlockSpec) -> Any:
    sign = tuple(float(sign) for _, sign in spec.inputs) or (1.0,)
    tuning = Tuning(spec.params, sign, spec.horizon)
    if spec.numbered is not None:
        tuning = spec.numbered.tuning(spec)
    return (tuning, spec.coding.tuning(spec.rate)) if spec.coding is not None else tuning


def _check(t: Array, samples: Array, states: list[float]) -> None:
    """Raise EventregError when something is not finite; a state that once is not, stays so."""
    bad = ~np.isfinite(samples).all(axis=0)
    if not bad.any() and np.isfinite(states).all():
        return
    first = t[int(np.argmax(bad))] if bad.any() else t[-1]
    raise EventregError(not_finite(float(first)))


def not_finite(t: float) -> str:
    """Return what is said of a run whose samples are not finite from model time ``t`` on."""
    return (
        f'the state stops being finite at t = {t:g} (model time); '
        f'take a shorter step (a higher rate), a shorter duration or gentler parameters'
    )
