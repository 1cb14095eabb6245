# SPDX-License-Identifier: Apache-2.0
"""The forward model: generators, seen directly or through a plant, at the recorded times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...models import NEURON, OSCILLATOR, Model
from .integration import Course, course
from .layout import Array, Layout, Plant

DIFFERENCE = 1e-7
"""Step of the derivatives, which need only be good enough for the search."""

FAST, FAST_STEP = 2.0, 0.05
"""Out of antiphase a generator moves fast at first: the steps of so much model time are fine."""


class Forward:
    """Predicts the samples of a signal from the unknowns.

    ``t``, of shape (n,), are the sample times from 0 on, not decreasing; ``given`` returns what
    else drives the plant (v - u) at any times; ``h`` is the step of the integration, finer at the
    beginning if the generator may be out of antiphase. All times are model time.
    """

    def __init__(
        self, layout: Layout, t: Array, h: float, given: Callable[[Array], Array] | None = None
    ) -> None:
        self.layout = layout
        nodes = h * np.arange(max(int(np.ceil(t[-1] / h - 1e-9)), 1) + 1, dtype=np.float64)
        if not layout.antiphase and h > FAST_STEP:
            later = nodes[nodes > FAST + 0.5 * h]
            nodes = np.append(np.linspace(0.0, FAST, round(FAST / FAST_STEP) + 1), later)
        self._h = np.diff(nodes)
        still = np.zeros(len(nodes))
        self._still = still, still[1:]
        self._given = self._still
        if given is not None:
            self._given = given(nodes), given(nodes[1:] - 0.5 * self._h)
        self._node = np.clip(np.searchsorted(nodes, t + 1e-9) - 1, 0, len(nodes) - 2)
        self._part = (t - nodes[self._node]) / self._h[self._node]

    def predict(self, unknowns: Array) -> Array:
        """Return the samples, shape (n,), of ``unknowns``, shape (size,).

        With ``unknowns`` of shape (size, m), m cases at once, the samples have the shape (n, m).
        """
        return self._seen(self._generators(unknowns), unknowns)

    def jacobian(self, unknowns: Array, of: Sequence[int] | None = None) -> Array:
        """Return the derivative of the samples by each of the unknowns, shape (n, size).

        ``of`` says by which of them only.
        """
        same = self._generators(unknowns)
        here = self._seen(same, unknowns)
        columns = []
        for i in range(self.layout.size) if of is None else of:
            moved = unknowns.copy()
            moved[i] += DIFFERENCE
            w = self._generators(moved) if i < self.layout.plant_state.start else same
            columns.append((self._seen(w, moved) - here) / DIFFERENCE)
        return np.stack(columns, axis=1)

    def _generators(self, unknowns: Array) -> Course:
        """Return the sum of all generators."""
        own = self.layout
        model = NEURON if own.antiphase else OSCILLATOR
        k = 0.0 if own.antiphase else np.exp(unknowns[own.log_k])
        courses = [
            self._course(model, unknowns[own.states(i)], *self._still, k, np.exp(unknowns[i]))
            for i in range(own.generators)
        ]
        return Course(*(np.sum(each, axis=0) for each in zip(*courses, strict=True)))

    def _seen(self, w: Course, unknowns: Array) -> Array:
        """Return the samples of the sum of the generators, through the plant if there is one."""
        own = self.layout
        found = self._at_samples(w if own.plant is None else self._plant(w, own.plant, unknowns))
        if own.affine:
            gain, offset = unknowns[own.sensor]
            found = gain * found + offset
        return found

    def _plant(self, w: Course, known: Plant, unknowns: Array) -> Course:
        own = self.layout
        bend = _rows(self._h, w.x.ndim) / 8.0 * (w.slope[:-1] - w.slope[1:])
        middle = 0.5 * (w.x[:-1] + w.x[1:]) + bend
        drives, middles = (
            each + _rows(given, w.x.ndim)
            for each, given in zip((w.x, middle), self._given, strict=True)
        )
        k, tau = known if own.plant_known else np.exp(unknowns[own.log_plant])
        return self._course(NEURON, unknowns[own.plant_state], drives, middles, k, tau)

    def _course(
        self, model: Model, x0: Array, drives: Array, middles: Array, k: Any, tau: Any
    ) -> Course:
        drives, middles = (_rows(each, x0.ndim) for each in (drives, middles))
        return course(model, x0, drives, middles, (k, tau), self._h)

    def _at_samples(self, course: Course) -> Array:
        """Interpolate by cubics through values and slopes at the nodes."""
        i, ndim = self._node, course.x.ndim
        s, h = _rows(self._part, ndim), _rows(self._h[i], ndim)
        rest = 1.0 - s
        (a, b), (da, db) = ((each[i], each[i + 1]) for each in course)
        ends = rest * rest * (1.0 + 2.0 * s) * a + s * s * (3.0 - 2.0 * s) * b
        return ends + h * s * rest * (rest * da - s * db)


def _rows(a: Array, ndim: int) -> Array:
    """Return ``a`` so that it broadcasts along the first of ``ndim`` axes."""
    return a[:, None] if a.ndim < ndim else a
