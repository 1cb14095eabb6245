"""The closed loop as one continuous system, integrated as exactly as asked.

scipy's DOP853 (order 8) integrates it, from one jump of the stimulus to the next.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from ..errors import EventregError
from ..models.roles import STIMULUS_OUTPUT
from .block import BlockSpec
from .stimulus import Stimulus
from .system import System
from .trajectory import Array, Trajectory
from .wiring import common_grid, count_steps, model_times

RTOL, ATOL = 1e-10, 1e-12
"""Tolerances of the integrator: with them the trajectories meet the truth well within 1e-6."""

FIRST, EACH = 200_000, 20_000
"""Evaluations after which it is given up: so many, and so many more per unit of model time."""


def simulate(
    blocks: Mapping[str, BlockSpec],
    stimulus: Stimulus | None,
    duration: float,
    h: float | None = None,
    *,
    stimulus_output: str = STIMULUS_OUTPUT,
    rtol: float = RTOL,
    atol: float = ATOL,
) -> Trajectory:
    """Integrate all ``blocks`` together from their x0 over ``duration`` of model time.

    Returns every block's output, and the stimulus' as ``stimulus_output`` if there is one, at n * h
    from 0 to ``duration``; ``h`` is in model time, by default the blocks' time_scale / rate. An
    input that nobody publishes counts as 0. Raises EventregError when the blocks do not agree on
    that step, close an algebraic loop, their state stops being finite, or they are too stiff.
    """
    scale, rate = (h, 1.0) if h is not None else common_grid(blocks)
    t = model_times(count_steps(duration, scale / rate), scale, rate)
    system = System(blocks, stimulus_output if stimulus is not None else None)
    v = np.array([stimulus(time) for time in t.tolist()]) if stimulus is not None else 0.0 * t
    states = _integrate(system, stimulus, t, duration, rtol, atol)
    values = system.signals(v, states)
    return Trajectory(t, {name: np.array(values[i]) for name, i in system.slots.items()})


def _integrate(
    system: System,
    stimulus: Stimulus | None,
    t: Array,
    duration: float,
    rtol: float,
    atol: float,
) -> Array:
    """Return the states at ``t``, shape (states, samples), restarting where the stimulus jumps."""
    x = np.array(system.x0)
    found = np.empty((len(x), len(t)))
    budget = Budget()
    edges = [0.0, *(stimulus.breaks(duration) if stimulus is not None else ()), duration]
    for start, end in pairwise(edges):
        last = len(t) if end == duration else int(np.searchsorted(t, end))
        first = int(np.searchsorted(t, start)) if start else 0
        inside = np.clip(t[first:last], start, end)
        states = _segment(system, stimulus, x, start, end, inside, budget, rtol, atol)
        found[:, first:last], x = states[:, : last - first], states[:, -1]
    return found


def _segment(
    system: System,
    stimulus: Stimulus | None,
    x: Array,
    start: float,
    end: float,
    t: Array,
    budget: Budget,
    rtol: float,
    atol: float,
) -> Array:
    """Integrate from ``x`` over an interval without jumps; return the states at ``t`` and ``end``.

    When ``t`` ends with ``end``, that state is there once.
    """
    from scipy.integrate import solve_ivp

    if start == end:
        return x[:, None]
    at = np.unique(np.append(t, end))
    margin = 1e-12 * end  # v is read strictly inside: at its ends it may have jumped already

    def rhs(time: float, state: Array) -> list[float]:
        budget.spend(time)
        v = 0.0 if stimulus is None else stimulus(min(max(time, start + margin), end - margin))
        return system.derivative(v, state.tolist())

    with np.errstate(all='ignore'):
        if not all(map(math.isfinite, rhs(start, x))):
            raise _not_finite(start)
        result = solve_ivp(rhs, (start, end), x, 'DOP853', at, rtol=rtol, atol=atol)
    if not (result.success and np.isfinite(result.y).all()):
        raise _not_finite(float(result.t[-1]) if len(result.t) else start, result.message)
    return np.asarray(result.y)


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
