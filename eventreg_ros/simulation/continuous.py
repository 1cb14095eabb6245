# SPDX-License-Identifier: Apache-2.0
"""The closed loop as one continuous system, integrated as exactly as asked.

scipy's DOP853 (order 8) integrates it, from one jump of the stimulus to the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np

from ..errors import EventregError
from .loop import Loop
from .model_errors import in_words
from .model_time import count_steps, model_times
from .system import System
from .trajectory import Array, Trajectory
from .turns import Condition, Turn

RTOL, ATOL = 1e-10, 1e-12
"""Tolerances of the integrator: with them the trajectories meet the truth well within 1e-6."""

FIRST, EACH = 200_000, 20_000
"""Evaluations after which it is given up: so many, and so many more per unit of model time."""


def simulate(
    loop: Loop,
    duration: float,
    h: float | None = None,
    turns: Sequence[Turn] = (),
    *,
    rtol: float = RTOL,
    atol: float = ATOL,
) -> Trajectory:
    """Integrate all blocks of ``loop`` together from their x0 over ``duration`` of model time.

    Returns every signal of the loop at n * h from 0 to ``duration``; ``h`` is in model time, by
    default the blocks' time_scale / rate. An input that nobody publishes counts as 0. No link is
    late, so that a controller that predicts has nothing to predict, and leads do not count. At the
    time of a turn the signals are those after it. Raises EventregError when the blocks do not agree
    on that step, close an algebraic loop, their state stops being finite, or they are too stiff.
    """
    with in_words(loop.foreign_models):
        return _simulate(loop, duration, h, turns, rtol, atol)


def _simulate(
    loop: Loop, duration: float, h: float | None, turns: Sequence[Turn], rtol: float, atol: float
) -> Trajectory:
    wanted, loop = loop.signals, loop.without_delay()
    turns = [turn.without_delay(wanted) for turn in turns]
    scale, rate = (h, 1.0) if h is not None else loop.grid
    states = sum(len(spec.x0) for spec in loop.blocks.values())
    kept = 2 * states + 2 * len(loop.signals)
    t = model_times(count_steps(duration, scale / rate, kept), scale, rate)
    found = {signal: np.zeros(len(t)) for signal in loop.signals}
    blocks = {name: Condition(spec, spec.x0) for name, spec in loop.blocks.items()}
    stimuli, budget = dict(loop.stimuli), Budget(FIRST, EACH)
    times = sorted({0.0, *(turn.at for turn in turns if turn.at < duration)})
    for start, end in pairwise([*times, duration]):
        for turn in (turn for turn in turns if turn.at == start):
            if turn.stimulus is not None:
                stimuli[turn.name] = turn.stimulus
            else:
                blocks[turn.name] = blocks[turn.name].after(turn)
        running = {n: replace(b.spec, x0=b.x) for n, b in blocks.items() if b.running}
        integration = _Integration(Loop(running, stimuli), budget, rtol, atol)
        last = len(t) if end == duration else int(np.searchsorted(t, end))
        part = slice(int(np.searchsorted(t, start)), last)
        signals, x = integration.run(t[part], start, end)
        for name, values in signals.items():
            found[name][part] = values
        for each in (b for b in blocks.values() if not b.running):
            for name, i in each.spec.observed.items():
                found[name][part] = each.x[i]
        numbers = iter(x)
        for name in running:
            state = tuple(islice(numbers, len(blocks[name].x)))
            blocks[name] = replace(blocks[name], x=state, starting=False)
    return Trajectory(t, {name: found[name] for name in wanted})


class _Integration:
    """One integration of a loop, restarted wherever a stimulus jumps."""

    def __init__(self, loop: Loop, budget: Budget, rtol: float, atol: float) -> None:
        self._models = loop.models
        self._system, self._stimuli = System(loop), tuple(loop.stimuli.values())
        self._rtol, self._atol = rtol, atol
        self._budget = budget

    def run(self, t: Array, start: float, end: float) -> tuple[dict[str, Array], list[float]]:
        """Return the signals at ``t``, from ``start`` to ``end``, and the state at the end."""
        x = np.array(self._system.x0)
        found = np.empty((len(x), len(t)))
        jumps = {s for each in self._stimuli for s in each.breaks(end) if s > start}
        for a, b in pairwise([start, *sorted(jumps), end]):
            last = len(t) if b == end else int(np.searchsorted(t, b))
            first = int(np.searchsorted(t, a)) if a > start else 0
            states = self._segment(x, a, b, np.clip(t[first:last], a, b))
            found[:, first:last], x = states[:, : last - first], states[:, -1]
        v = [np.array([each(time) for time in t.tolist()]) for each in self._stimuli]
        values = self._system.signals_over(v, found)
        signals = {n: values[i] + np.zeros(len(t)) for n, i in self._system.slots.items()}
        return signals, x.tolist()

    def _segment(self, x: Array, start: float, end: float, t: Array) -> Array:
        """Integrate from ``x`` over an interval without jumps; the states at ``t`` and ``end``.

        When ``t`` ends with ``end``, that state is there once.
        """
        from scipy.integrate import solve_ivp

        if start == end:
            return x[:, None]
        at = np.unique(np.append(t, end))
        rhs = self._rhs(start, end)
        with np.errstate(all='ignore'), in_words(self._models):
            if not all(map(math.isfinite, rhs(start, x))):
                raise _not_finite(start)
            result = solve_ivp(rhs, (start, end), x, 'DOP853', at, rtol=self._rtol, atol=self._atol)
        if not (result.success and np.isfinite(result.y).all()):
            raise _not_finite(float(result.t[-1]) if len(result.t) else start, result.message)
        return np.asarray(result.y)

    def _rhs(self, start: float, end: float) -> Callable[[float, Array], list[float]]:
        """Return x' as a function of (t, x) between two jumps.

        The stimuli are read strictly inside: at the ends they may have jumped already.
        """
        margin = 1e-12 * end

        def rhs(time: float, state: Array) -> list[float]:
            self._budget.spend(time)
            inside = min(max(time, start + margin), end - margin)
            v = [stimulus(inside) for stimulus in self._stimuli]
            return self._system.derivative(v, state.tolist())

        return rhs


class StiffError(EventregError, ArithmeticError):
    """An integration takes more evaluations than it may."""


class Budget:
    """Counts evaluations; an integration that gets nowhere is given up after seconds, not years.

    An explicit method takes steps of a few times the fastest time constant, whatever the accuracy.
    It may take ``first`` evaluations, and ``each`` more per unit of model time.
    """

    def __init__(self, first: int, each: int) -> None:
        self._first, self._each, self._spent = first, each, 0

    def spend(self, t: float) -> None:
        """Count one evaluation, at model time ``t``. Raises StiffError if it is one too many."""
        self._spent += 1
        if self._spent > self._first + self._each * t:
            raise StiffError(
                f'the equations are too stiff: {self._spent} evaluations reached t = {t:.3g} '
                f'(model time); take gentler parameters (a smaller k, say)'
            )


def _not_finite(t: float, reason: str = '') -> EventregError:
    return EventregError(
        f'the state stops being finite soon after t = {t:g} (model time)'
        + (f' ({reason.rstrip(".")})' if reason else '')
        + '; take a shorter duration or gentler parameters'
    )
