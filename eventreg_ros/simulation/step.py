# SPDX-License-Identifier: Apache-2.0
"""One step of the classical Runge-Kutta method, the one that everybody takes.

Nodes, sampled simulations and sweeps call the same :func:`make_step`, so they agree to the last
bit. The algebra on states is written out for each dimension when it is first asked for: in plain
Python that is twice as fast as lists and ten times as fast as small numpy arrays, and numba
compiles it unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from ..models.model import Params, Rhs, State

Compile = Callable[[Any], Any]
Step = Callable[[State, float, float, float, Params, float], State]


@lru_cache
def _algebra(dimension: int) -> tuple[Callable[..., State], Callable[..., State]]:
    """Return ``add(x, a, k)``, which is x + a k, and ``mean(a, b, c, d)``, unrolled."""
    each = range(dimension)
    add = ', '.join(f'x[{i}] + a * k[{i}]' for i in each)
    mean = ', '.join(f'(a[{i}] + 2.0 * b[{i}] + 2.0 * c[{i}] + d[{i}]) / 6.0' for i in each)
    source = (
        f'def add(x, a, k):\n    return ({add},)\ndef mean(a, b, c, d):\n    return ({mean},)\n'
    )
    names: dict[str, Callable[..., State]] = {}
    exec(compile(source, f'<step of dimension {dimension}>', 'exec'), names)
    return names['add'], names['mean']


def plain(function: Any) -> Any:
    """Return ``function`` as it is, where others compile it."""
    return function


def make_step(rhs: Rhs, dimension: int, compile: Compile = plain) -> Step:
    """Return ``step(x, d0, dm, d1, p, h) -> x``, one classical RK4 step of length ``h``.

    ``d0``, ``dm`` and ``d1`` are the drive at the start, the middle and the end of the step; ``h``
    is in model time. ``compile`` is applied to every function that it calls (numba's njit, say).
    """
    add, mean = (compile(function) for function in _algebra(dimension))
    f = compile(rhs)

    def step(x: State, d0: float, dm: float, d1: float, p: Params, h: float) -> State:
        half = 0.5 * h
        k1 = f(x, d0, p)
        k2 = f(add(x, half, k1), dm, p)
        k3 = f(add(x, half, k2), dm, p)
        k4 = f(add(x, h, k3), d1, p)
        return add(x, h, mean(k1, k2, k3, k4))  # type: ignore[no-any-return]

    return compile(step)  # type: ignore[no-any-return]
