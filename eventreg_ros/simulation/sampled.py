"""The closed loop as the nodes run it in lockstep: sample by sample, to the same bits."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from ..errors import EventregError
from ..models.roles import STIMULUS_OUTPUT
from .block import Block, BlockSpec
from .impairment import Received, received
from .jit import choose
from .kernel import NOBODY, Part, Tables, Tuning, flatten, nest
from .stimulus import Stimulus
from .trajectory import Array, Trajectory
from .wiring import MAX_STEPS, common_grid, count_steps, model_times, published


def simulate_sampled(
    blocks: Mapping[str, BlockSpec],
    stimulus: Stimulus | None,
    duration: float,
    *,
    stimulus_output: str = STIMULUS_OUTPUT,
    delay: float = 0.0,
    loss: float = 0.0,
    jitter: float = 0.0,
    seed: int = 0,
    compiled: bool | None = None,
) -> Trajectory:
    """Step all ``blocks`` together over ``duration``; see :meth:`Network.run` for the rest."""
    network = Network(blocks, stimulus, stimulus_output=stimulus_output)
    return network.run(
        duration, delay=delay, loss=loss, jitter=jitter, seed=seed, compiled=compiled
    )


class Network:
    """Blocks and their links, ready to run any number of times.

    A link is (receiving block, signal); ``links`` lists them in the order in which they draw their
    random numbers. An input that nobody publishes is no link and counts as 0. Raises EventregError
    when the blocks disagree on time_scale or rate, or two publish the same signal.
    """

    def __init__(
        self,
        blocks: Mapping[str, BlockSpec],
        stimulus: Stimulus | None = None,
        *,
        stimulus_output: str = STIMULUS_OUTPUT,
    ) -> None:
        self._time_scale, self._rate = common_grid(blocks)
        self._blocks = [Block(spec) for spec in blocks.values()]
        self._stimulus = stimulus
        self._v = np.empty(0)
        self.signals = published(blocks, None if stimulus is None else stimulus_output)
        row = {signal: i for i, signal in enumerate(self.signals)}
        self._parts = tuple(
            Part(
                spec.model,
                row[spec.output],
                tuple(row.get(signal, NOBODY) for signal, _ in spec.inputs),
            )
            for spec in blocks.values()
        )
        self._states = nest([tuple(map(float, spec.x0)) for spec in blocks.values()])
        self._tunings = nest([_tuning(spec) for spec in blocks.values()])
        self.links = [
            (name, signal)
            for name, spec in blocks.items()
            for signal, _ in spec.inputs
            if signal in row
        ]

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return self._time_scale / self._rate

    def run(
        self,
        duration: float,
        *,
        delay: float = 0.0,
        loss: float = 0.0,
        jitter: float = 0.0,
        seed: int = 0,
        on: Collection[str] | None = None,
        compiled: bool | None = None,
    ) -> Trajectory:
        """Return all signals at n * h from 0 to ``duration`` (model time).

        Over step n every block uses the samples up to n that its links have received: each is lost
        with probability ``loss`` and comes ``delay`` (model time, rounded to steps) and a uniform
        part of ``jitter`` (model time) late; see :func:`.links.received`. Before the first, an
        input is 0. Links of signals that are not ``on`` (None: all are) are perfect.
        ``compiled`` says whether numba compiles the loop (None: where that pays); same bits.
        Raises EventregError for a bad value, or when a state stops being finite.
        """
        steps = count_steps(duration, self.h)
        have = self._received(steps, delay, loss, jitter, seed, on)
        samples = self._samples(steps)
        kernel, arrays = choose(self._parts, steps, compiled)
        flat = [table.ravel() for table in (samples, have.newest, have.previous)]
        first, newest, previous = flat if arrays else (table.tolist() for table in flat)
        tables = Tables(first, newest, previous, steps, self.h)
        states = kernel(self._states, self._tunings, tables)
        samples = np.asarray(tables.samples).reshape(samples.shape)
        t = model_times(steps, self._time_scale, self._rate)
        _check(t, samples, flatten(states))
        return Trajectory(t, dict(zip(self.signals, samples, strict=True)))

    def _received(
        self,
        steps: int,
        delay: float,
        loss: float,
        jitter: float,
        seed: int,
        on: Collection[str] | None,
    ) -> Received:
        limits = {'delay': (delay, np.inf), 'jitter': (jitter, np.inf), 'loss': (loss, 1.0)}
        for name, (value, high) in limits.items():
            if not 0.0 <= value <= high:
                raise EventregError(f'{name} must be >= 0 and <= {high:g}, got {value!r}')
        if seed < 0:
            raise EventregError(f'seed must be >= 0, got {seed}')
        late = min(delay / self.h, float(steps))
        spread = min(jitter / self.h, float(MAX_STEPS))
        have = received(
            len(self.links), steps, delay=round(late), loss=loss, jitter=spread, seed=seed
        )
        if on is not None:
            sound = [signal not in on for _, signal in self.links]
            for table, perfect in zip(have, received(len(self.links), steps), strict=True):
                table[sound] = perfect[sound]
        return have

    def _samples(self, steps: int) -> Array:
        """Return the table of samples, shape (signals, steps + 1), as far as it is known."""
        samples = np.zeros((len(self.signals), steps + 1))
        if self._stimulus is not None:
            samples[0] = self._sample(self._stimulus, steps)
        for part, block in zip(self._parts, self._blocks, strict=True):
            samples[part.row, 0] = block.y
        return samples

    def _sample(self, stimulus: Stimulus, steps: int) -> Array:
        """Return v at samples 0 to ``steps``, kept for the next run."""
        if len(self._v) <= steps:
            t = model_times(steps, self._time_scale, self._rate)
            self._v = np.array([stimulus(time) for time in t.tolist()])
        return self._v[: steps + 1]


def _tuning(spec: BlockSpec) -> Tuning:
    params = tuple(map(float, spec.params))
    sign = tuple(float(sign) for _, sign in spec.inputs) or (1.0,)
    return Tuning(params, sign, spec.horizon)  # type: ignore[arg-type]


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
