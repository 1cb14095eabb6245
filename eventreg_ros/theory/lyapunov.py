# SPDX-License-Identifier: Apache-2.0
"""Does the driven loop forget its initial state? The largest conditional Lyapunov exponent.

The exosystem, the stimulus and the reference are the drive: they run, but only the plant and the
controller are perturbed, together with whatever those two reach. An infinitesimal perturbation dx
obeys the variational equation dx' = J(t) dx along the solution; the exponent is the mean rate at
which the logarithm of its length grows. Negative: the inputs force one response, whatever the
initial state (the paper's input-induced contraction, seen locally along this solution). Without w
the loop is autonomous, and where it oscillates a shift along the orbit neither grows nor fades: the
exponent is then 0 and the loop is not contractive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import mul

import numpy as np

from ..errors import EventregError
from ..simulation.continuous import Budget
from ..simulation.loop import Loop
from ..simulation.trajectory import Array
from .tangent import Tangent

PERTURBED = ('plant', 'controller')
TIME = 600.0
TRANSIENT = 200.0  # like all times here in model time
BLOCKS = 5  # at least; as soon as they would be longer than BLOCK_TIME there are more
BLOCK_TIME = 200.0
SEGMENT = 5.0  # dx is scaled back to length 1 at least so often
SHORTEST = 1e-3
FAINT = 1e-6  # a dx of less length after a segment has it halved, down to SHORTEST
BOUND = 1e9  # a state beyond it counts as unbounded
RTOL, ATOL = 1e-8, 1e-10
LONGEST = 1e5
FIRST, EACH = 50_000, 500
"""Evaluations after which it is given up: so many, and so many more per unit of model time; the
shipped scenarios take 60 per unit."""

Flow = Callable[[float, list[float], list[float]], list[float]]
"""``flow(t, x, dx)`` returns x' followed by dx' = J(t, x) dx, as one list."""


@dataclass(frozen=True)
class Exponent:
    """A Lyapunov exponent per unit of model time, and how well it is known.

    ``half_width`` is that of the 95 % confidence interval from the scatter of ``blocks``, the
    estimates of equal consecutive stretches, but at least 1 / ``time``: a rate below that changes a
    perturbation by less than a factor e over the whole run, and is indistinguishable from 0.
    """

    value: float
    half_width: float
    blocks: tuple[float, ...]
    time: float

    @property
    def sign(self) -> int:
        """-1 or 1 when the interval lies on one side of 0, else 0."""
        return 0 if abs(self.value) <= self.half_width else int(math.copysign(1, self.value))


class UnboundedError(EventregError, ArithmeticError):
    """The solution leaves every bound, so there is no exponent along it."""


class NoJacobianError(EventregError):
    """A model does not say its derivative."""


def need_time(time: float) -> None:
    """Raise EventregError where ``time``, model time, is more than :data:`LONGEST`."""
    if not time <= LONGEST:
        raise EventregError(f'the time must be at most {LONGEST:g} of model time, got {time:g}')


def conditional_exponent(
    loop: Loop, time: float = TIME, *, perturbed: Sequence[str] = PERTURBED
) -> Exponent:
    """Return the largest exponent of the blocks whose role is ``perturbed``, driven by the others.

    ``time`` is the model time averaged over, after a transient of 200. Leave the exosystem out of
    the loop for w = 0. Raises :class:`UnboundedError` when the solution leaves every bound,
    :class:`.StiffError` when it takes too many evaluations, and EventregError when ``time`` is more
    than :data:`LONGEST`, no block is perturbed or a model has no Jacobian.
    """
    if not loop.of_role(*perturbed):
        raise EventregError(f'nothing to perturb: name at least one of {", ".join(perturbed)}')
    need_jacobians(loop)
    need_time(time)
    tangent, stimuli = Tangent(loop), list(loop.stimuli.values())
    budget = Budget(FIRST, EACH)

    def flow(t: float, x: list[float], dx: list[float]) -> list[float]:
        budget.spend(t)
        return tangent.flow([stimulus(t) for stimulus in stimuli], x, dx)

    dx = [float(spec.role in perturbed) for spec in loop.blocks.values() for _ in spec.x0]
    breaks = sorted({t for each in stimuli for t in each.breaks(TRANSIENT + time)})
    return largest_exponent(flow, tangent.x0, dx, time, breaks=breaks)


def need_jacobians(loop: Loop) -> None:
    """Raise NoJacobianError when a model of the loop does not say its derivative."""
    for name, spec in loop.blocks.items():
        if spec.model.jacobian is None:
            raise NoJacobianError(
                f'model {spec.model.name!r} of {name} has no Jacobian, so that no exponent can be '
                'measured; give the model one'
            )


def largest_exponent(
    flow: Flow,
    x0: Sequence[float],
    dx0: Sequence[float],
    time: float,
    *,
    transient: float = TRANSIENT,
    breaks: Sequence[float] = (),
) -> Exponent:
    """Return the largest Lyapunov exponent of a flow seen by perturbations that start as ``dx0``.

    The variational equation is integrated along the solution, and dx scaled back to length 1 at
    least every 5 units of time (Benettin). The rate of growth dx . dx' / dx . dx is integrated
    beside it. The run of length ``time`` is cut into at least 5 blocks, and the mean over a block
    is weighted by a Hann window, so that what merely oscillates within a block averages out; blocks
    shorter than two or three such oscillations are not to be trusted. The flow is never evaluated
    at or beyond a jump (``breaks``) in the segment that ends there.
    """
    count = max(BLOCKS, round(time / BLOCK_TIME))
    block = time / count

    def weight(t: float) -> float:
        return 2.0 * math.sin(math.pi * (t - transient) / block) ** 2

    x, dx = np.array(x0, float), np.array(dx0, float) / np.linalg.norm(dx0)
    x, dx, _ = _advance(flow, lambda t: 0.0, x, dx, 0.0, transient, breaks)
    rates = []
    for i in range(count):
        start, end = transient + i * block, transient + (i + 1) * block
        x, dx, growth = _advance(flow, weight, x, dx, start, end, breaks)
        rates.append(growth / block)
    return _estimate(rates, time)


def _estimate(rates: Sequence[float], time: float) -> Exponent:
    from scipy.special import stdtrit

    n = len(rates)
    scatter = float(np.std(rates, ddof=1)) / math.sqrt(n) * float(stdtrit(n - 1, 0.975))
    return Exponent(float(np.mean(rates)), max(scatter, 1.0 / time), tuple(rates), time)


def _advance(
    flow: Flow,
    weight: Callable[[float], float],
    x: Array,
    dx: Array,
    start: float,
    end: float,
    breaks: Sequence[float],
) -> tuple[Array, Array, float]:
    """Return x, dx (of length 1) at ``end`` and the weighted integral of dx's rate of growth."""
    pieces = math.ceil((end - start) / SEGMENT)
    even = [start + i * (end - start) / pieces for i in range(pieces)]
    edges = sorted({*even, end, *(t for t in breaks if start < t < end)})
    total = 0.0
    for left, right in pairwise(edges):
        x, dx, growth = _segment(flow, weight, x, dx, left, right)
        total += growth
    return x, dx, total


def _segment(
    flow: Flow, weight: Callable[[float], float], x: Array, dx: Array, start: float, end: float
) -> tuple[Array, Array, float]:
    """Do :func:`_advance` over one segment, halved where dx fades into the tolerance."""
    z, n = _integrate(flow, weight, x, dx, start, end), len(x)
    if not (np.isfinite(z).all() and np.abs(z[:n]).max() < BOUND):
        raise UnboundedError(
            f'the solution diverges before t = {end:g} (model time); '
            f'choose parameters that keep it bounded'
        )
    length = float(np.linalg.norm(z[n:-1]))
    if length < FAINT and end - start > SHORTEST:
        middle = (start + end) / 2.0
        x, dx, first = _segment(flow, weight, x, dx, start, middle)
        x, dx, second = _segment(flow, weight, x, dx, middle, end)
        return x, dx, first + second
    return z[:n], z[n:-1] / length, float(z[-1])


def _integrate(
    flow: Flow, weight: Callable[[float], float], x: Array, dx: Array, start: float, end: float
) -> Array:
    """Return x, dx and the weighted growth at ``end`` as one array; NaN where scipy gives up."""
    from scipy.integrate import solve_ivp

    n, margin = len(x), 1e-9 * (end - start)

    def slope(t: float, z: Array) -> list[float]:
        values = z.tolist()
        dx = values[n:-1]
        found = flow(min(max(t, start + margin), end - margin), values[:n], dx)
        found.append(weight(t) * sum(map(mul, dx, found[n:])) / sum(map(mul, dx, dx)))
        return found

    z = np.concatenate([x, dx, [0.0]])
    with np.errstate(all='ignore'):
        result = solve_ivp(slope, (start, end), z, 'LSODA', (end,), rtol=RTOL, atol=ATOL)
    return np.asarray(result.y)[:, -1] if result.success else np.full(2 * n + 1, np.nan)
