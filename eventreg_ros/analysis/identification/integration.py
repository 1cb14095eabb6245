# SPDX-License-Identifier: Apache-2.0
"""A block over the whole recording, step by step: plain Python, or compiled where that pays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...models import Model
from ...simulation.code_cache import generated
from ...simulation.jit import compile_entry, compiles, inliner
from ...simulation.step import make_step, plain
from .layout import Array

PAYS = 150_000
"""Steps in plain Python that take about as long as it takes to load compiled ones (0.3 s)."""


class Course(NamedTuple):
    """A block's first state, its output, at the nodes of the integration, and its derivative."""

    x: Array
    slope: Array


def course(
    model: Model, x0: Array, drives: Array, middles: Array, p: Sequence[Any], h: Array
) -> Course:
    """Integrate a block as :func:`integrate` does, and return its output."""
    x = integrate(model, x0, drives, middles, p, h)
    slope: Any = model.rhs(tuple(x), drives, tuple(p))[0]  # type: ignore[arg-type]
    return Course(x[0], slope)


def integrate(
    model: Model, x0: Array, drives: Array, middles: Array, p: Sequence[Any], h: Array
) -> Array:
    """Return a block's states at the nodes, shape (dimension, n + 1), or (dimension, n + 1, m).

    ``drives``, at the n + 1 nodes, and ``middles``, between them, drive it; ``p`` are its
    parameters, ``h``, of shape (n,), the steps in model time. For m cases at once ``x0`` has the
    shape (dimension, m), and parameters and drives may have one more axis, of m.
    """
    if x0.ndim > 1:
        states = _march(model, False)(tuple(x0), list(drives), list(middles), tuple(p), h.tolist())
        found: Array = np.array(states).swapaxes(0, 1)
        return found
    march, compiled = _chosen(model, len(middles))
    rows = (drives, middles, h) if compiled else (drives.tolist(), middles.tolist(), h.tolist())
    found = np.array(march(tuple(x0.tolist()), *rows[:2], tuple(map(float, p)), rows[2])).T
    return found


_walked: Counter[str] = Counter()


def _chosen(model: Model, steps: int) -> tuple[Any, bool]:
    """Return the loop over the steps, and whether it is compiled: once that has paid."""
    _walked[model.name] += steps
    compiled = _walked[model.name] > PAYS and compiles()
    return _march(model, compiled), compiled


SOURCE = """
def march(x, drives, middles, p, h):
    states = [x] * len(drives)
    for n in range(len(middles)):
        x = step(x, drives[n], middles[n], drives[n + 1], p, h[n])
        states[n + 1] = x
    return states
"""


@lru_cache(maxsize=8)
def _march(model: Model, compiled: bool) -> Any:
    """Return the loop over the steps."""
    step = make_step(model.rhs, model.dimension, inliner() if compiled else plain)
    march = generated(SOURCE, 'march', {'step': step})
    return compile_entry(march) if compiled else march
