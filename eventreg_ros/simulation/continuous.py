"""The closed loop as one continuous system, integrated as exactly as asked.

scipy's DOP853 (order 8) integrates it, from one jump of the stimulus to the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from ..errors import EventregError
from .loop import Loop
from .model_time import count_steps, model_times
from .stimulus import Stimulus
from .system import System
from .trajectory import Array, Trajectory

RTOL, ATOL = 1e-10, 1e-12
"""Tolerances of the integrator: with them the trajectories meet the truth well within 1e-6."""

FIRST, EACH = 200_000, 20_000
"""Evaluations after which it is given up: so many, and so many more per unit of model time."""


def simulate(
    loop: Loop, duration: float, h: float | None = None, *, rtol: float = RTOL, atol: float = ATOL
) -> Trajectory:
    """Integrate all blocks of ``loop`` together from their x0 over ``duration`` of model time.

    Returns every signal of the loop at n * h from 0 to ``duration``; ``h`` is in model time, by
    default the blocks' time_scale / rate. An input that nobody publishes counts as 0. Raises
    EventregError when the blocks do not agree on that step, close an algebraic loop, their state
    stops being finite, or they are too stiff.
    """
    scale, rate = (h, 1.0) if h is not None else loop.grid
    t = model_times(count_steps(duration, scale / rate), scale, rate)
    integration = _Integration(System(loop), tuple(loop.stimuli.values()), rtol, atol)
    states = integration.run(t, duration)
    v = [np.array([stimulus(time) for time in t.tolist()]) for stimulus in integration.stimuli]
    values = integration.system.signals(v, states)
    slots = integration.system.slots
    return Trajectory(t, {name: values[i] + np.zeros(len(t)) for name, i in slots.items()})


class _Integration:
    """One integration of a system, restarted wherever a stimulus jumps."""

    def __init__(
        self, system: System, stimuli: tuple[Stimulus, ...], rtol: float, atol: float
    ) -> None:
        self.system, self.stimuli = system, stimuli
        self._rtol, self._atol = rtol, atol
        self._budget = Budget()

    def run(self, t: Array, duration: float) -> Array:
        """Return the states at ``t``, shape (states, samples)."""
        x = np.array(self.system.x0)
        found = np.empty((len(x), len(t)))
        jumps = {time for stimulus in self.stimuli for time in stimulus.breaks(duration)}
        for start, end in pairwise([0.0, *sorted(jumps), duration]):
            last = len(t) if end == duration else int(np.searchsorted(t, end))
            first = int(np.searchsorted(t, start)) if start else 0
            inside = np.clip(t[first:last], start, end)
            states = self._segment(x, start, end, inside)
            found[:, first:last], x = states[:, : last - first], states[:, -1]
        return found

    def _segment(self, x: Array, start: float, end: float, t: Array) -> Array:
        """Integrate from ``x`` over an interval without jumps; the states at ``t`` and ``end``.

        When ``t`` ends with ``end``, that state is there once.
        """
        from scipy.integrate import solve_ivp

        if start == end:
            return x[:, None]
        at = np.unique(np.append(t, end))
        rhs = self._rhs(start, end)
        with np.errstate(all='ignore'):
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
            v = [stimulus(inside) for stimulus in self.stimuli]
            return self.system.derivative(v, state.tolist())

        return rhs


class Budget:
    """Counts evaluations; an integration that gets nowhere is given up after seconds, not years.

    An explicit method takes steps of a few times the fastest time constant, whatever the accuracy.
    """

    def __init__(self) -> None:
        self._spent = 0

    def spend(self, t: float) -> None:
        """Count one evaluation, at model time ``t``. Raises EventregError if it is one too many."""
        self._spent += 1
        if self._spent > FIRST + EACH * t:
            raise EventregError(
                f'the equations are too stiff: {self._spent} evaluations reached t = {t:.3g} '
                f'(model time); take gentler parameters (a smaller k, say)'
            )


def _not_finite(t: float, reason: str = '') -> EventregError:
    return EventregError(
        f'the state stops being finite soon after t = {t:g} (model time)'
        + (f' ({reason.rstrip(".")})' if reason else '')
        + '; take a shorter duration or gentler parameters'
    )
