"""The closed loop as the nodes run it in lockstep: sample by sample, to the same bits."""

from __future__ import annotations

import numpy as np

from ..errors import EventregError
from .block import Block, BlockSpec
from .impairment import PERFECT, Impairment, received
from .jit import choose
from .kernel import NOBODY, Part, Tables, Tuning, flatten, nest
from .loop import Loop
from .model_time import count_steps, model_times
from .stimulus import Stimulus
from .trajectory import Array, Trajectory


def simulate_sampled(
    loop: Loop,
    duration: float,
    impairment: Impairment = PERFECT,
    *,
    compiled: bool | None = None,
) -> Trajectory:
    """Step all blocks of ``loop`` together over ``duration``; see :meth:`SampledLoop.run`."""
    return SampledLoop(loop).run(duration, impairment, compiled=compiled)


class SampledLoop:
    """A loop, ready to run sample by sample any number of times.

    A link is (receiving block, signal); ``links`` lists them in the order in which they draw their
    random numbers. An input that nobody publishes is no link and counts as 0. Raises EventregError
    when the blocks disagree on time_scale or rate.
    """

    def __init__(self, loop: Loop) -> None:
        self._time_scale, self._rate = loop.grid
        specs = list(loop.blocks.values())
        self._blocks = [Block(spec) for spec in specs]
        self._stimuli = [_Waveform(stimulus) for stimulus in loop.stimuli.values()]
        self.signals, self.links = loop.signals, loop.links
        row = {signal: i for i, signal in enumerate(self.signals)}
        self._parts = tuple(
            Part(
                spec.model,
                row[spec.output],
                tuple(row.get(signal, NOBODY) for signal, _ in spec.inputs),
                tuple((row[signal], i) for signal, i in spec.observed.items()),
            )
            for spec in specs
        )
        self._states = nest([tuple(map(float, spec.x0)) for spec in specs])
        self._tunings = nest([_tuning(spec) for spec in specs])

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return self._time_scale / self._rate

    def run(
        self, duration: float, impairment: Impairment = PERFECT, *, compiled: bool | None = None
    ) -> Trajectory:
        """Return all signals at n * h from 0 to ``duration`` (model time).

        Over step n every block uses the samples up to n that its links have received under
        ``impairment``; before the first, an input is 0. ``compiled`` says whether numba compiles
        the loop (None: where that pays); same bits. Raises EventregError for a bad duration, or
        when a state stops being finite.
        """
        steps = count_steps(duration, self.h)
        have = received([signal for _, signal in self.links], steps, self.h, impairment)
        t = model_times(steps, self._time_scale, self._rate)
        samples = self._samples(t)
        kernel, arrays = choose(self._parts, steps, compiled)
        flat = [table.ravel() for table in (samples, have.newest, have.previous)]
        first, newest, previous = flat if arrays else (table.tolist() for table in flat)
        tables = Tables(first, newest, previous, steps, self.h)
        states = kernel(self._states, self._tunings, tables)
        samples = np.asarray(tables.samples).reshape(samples.shape)
        _check(t, samples, flatten(states))
        return Trajectory(t, dict(zip(self.signals, samples, strict=True)))

    def _samples(self, t: Array) -> Array:
        """Return the table of samples, shape (signals, samples), as far as it is known."""
        samples = np.zeros((len(self.signals), len(t)))
        for i, waveform in enumerate(self._stimuli):
            samples[i] = waveform.at(t)
        for part, block in zip(self._parts, self._blocks, strict=True):
            samples[part.row, 0] = block.y
            for signal, i in part.observed:
                samples[signal, 0] = block.x[i]
        return samples


class _Waveform:
    """A stimulus at the samples of a grid, kept for the next run."""

    def __init__(self, stimulus: Stimulus) -> None:
        self._stimulus = stimulus
        self._known = np.empty(0)

    def at(self, t: Array) -> Array:
        """Return the values at ``t``, model times that always begin alike; shape (n,)."""
        if len(self._known) < len(t):
            self._known = np.array([self._stimulus(time) for time in t.tolist()])
        return self._known[: len(t)]


def _tuning(spec: BlockSpec) -> Tuning:
    sign = tuple(float(sign) for _, sign in spec.inputs) or (1.0,)
    return Tuning(spec.params, sign, spec.horizon)


def _check(t: Array, samples: Array, states: list[float]) -> None:
    """Raise EventregError when something is not finite; a state that once is not, stays so."""
    bad = ~np.isfinite(samples).all(axis=0)
    if not bad.any() and np.isfinite(states).all():
        return
    first = t[int(np.argmax(bad))] if bad.any() else t[-1]
    raise EventregError(
        f'the state stops being finite at t = {first:g} (model time); '
        f'take a shorter step (a higher rate), a shorter duration or gentler parameters'
    )
