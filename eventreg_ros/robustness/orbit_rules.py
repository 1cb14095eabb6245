# SPDX-License-Identifier: Apache-2.0
"""Which borders are those of a periodic orbit; and the values between those of a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import EventregError
from ..models.model import free
from ..simulation.jit import compiles
from ..simulation.loop import Loop
from .axes import Array, Axis
from .plan import Plan
from .sets import Sets

EVEN = 1e-9
"""Relative difference between steps that are the same."""


class Line:
    """The values of an axis, also between the points of its grid.

    In equal steps or ratios they go on like that; others lie on a smooth curve through them.
    """

    def __init__(self, values: Sequence[float]) -> None:
        self._values, self.last = np.array(values), len(values) - 1
        steps = np.diff(self._values)
        self.ordered = bool((steps > 0.0).all() or (steps < 0.0).all())
        even = bool(np.ptp(steps) <= EVEN * np.abs(steps).max())
        self._law = self._linear if even else self._in_ratios() or self._through

    def _in_ratios(self) -> Callable[[Array], Array] | None:
        line = self._values
        if not ((line > 0.0).all() or (line < 0.0).all()):
            return None
        ratios = line[1:] / line[:-1]
        return self._geometric if np.ptp(ratios) <= EVEN * ratios.max() else None

    def _linear(self, places: Array) -> Array:
        width = self._values[-1] - self._values[0]
        return np.asarray(self._values[0] + places / self.last * width)

    def _geometric(self, places: Array) -> Array:
        ratio = self._values[-1] / self._values[0]
        return np.asarray(self._values[0] * ratio ** (places / self.last))

    def _through(self, places: Array) -> Array:
        return np.asarray(self._curve(places))

    @cached_property
    def _curve(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(np.arange(self.last + 1), self._values)

    def __call__(self, places: Array) -> Array:
        """Return the values at ``places``, in steps of the grid, shape (n,)."""
        return self._law(places)


class Numbers:
    """The parameters of all blocks of sets, where two axes are nothing but numbers among them.

    Raises EventregError where they are more: where others are computed from them, say.
    """

    def __init__(self, sets: Sets, lines: Sequence[Line]) -> None:
        self._sets, self._lines = sets, lines
        self._fixed = self._at(0.0, 0.0)
        found = [self._changed(1.0, 0.0), self._changed(0.0, 1.0)]
        self._places = found
        for x, y in ((0.5, 1.0), (1.0, 0.3)):
            for given, filled in zip(self._at(x, y), self(self._ends(x, y)), strict=True):
                if not np.array_equal(given, filled[0]):
                    names = ' and '.join(axis.name for axis in sets.axes)
                    raise EventregError(f'others are computed from {names}')

    def _ends(self, x: float, y: float) -> Array:
        return np.array([[x * self._lines[0].last, y * self._lines[1].last]])

    def _at(self, x: float, y: float) -> list[Array]:
        """Return the parameters of each block at parts of the ranges."""
        values = [line(part)[0] for line, part in zip(self._lines, self._ends(x, y).T, strict=True)]
        specs = self._sets.scenario(values).loop.blocks.values()
        return [np.array(tuple(spec.params)) for spec in specs]

    def _changed(self, x: float, y: float) -> list[tuple[int, Array]]:
        """Return for each block which of its parameters change."""
        pairs = zip(self._at(x, y), self._fixed, strict=True)
        return [(b, np.flatnonzero(now != before)) for b, (now, before) in enumerate(pairs)]

    def __call__(self, points: Array) -> list[Array]:
        """Return the parameters at ``points``, shape (n, 2) in steps of the grid."""
        params = [np.tile(fixed, (len(points), 1)) for fixed in self._fixed]
        for i, line in enumerate(self._lines):
            for b, places in self._places[i]:
                params[b][:, places] = line(points[:, i])[:, None]
        return params


def unsound(plan: Plan) -> str:
    """Say why the border of a plan is not that of a periodic orbit; '' where it may be."""
    loop, criteria = plan.scenario.loop, plan.subject.criteria
    if not compiles():
        return 'numba is not installed (pip install numba)'
    if axis := next((axis for axis in plan.axes if axis.of_run), None):
        return f'{axis.name} is not in the equations'
    links = plan.impairment
    if links.delay or links.loss or links.jitter or any(plan.noise.sds):
        return 'links are impaired, or noise is added'
    if len(plan.subject.plants) != 1:
        return f'there are {len(plan.subject.plants)} plants'
    if criteria.min_width > 0.0 or criteria.refractory > 0.0:
        return 'an event is more than a crossing of the threshold (min_width, refractory)'
    return _aperiodic(loop) or next(filter(None, (_off_line(loop, axis) for axis in plan.axes)), '')


def _aperiodic(loop: Loop) -> str:
    """Say why a loop has no orbit that is looked for, '' where it may have one."""
    if loop.stimuli:
        return f'an open input, {next(iter(loop.stimuli))}, drives it'
    generators = loop.of_role('exosystem')
    if len(generators) != 1:
        return f'there are {len(generators)} exosystems, and w repeats itself with one'
    for name, _ in loop.links:
        if name in generators or name in loop.of_role('reference'):
            return f'something drives {name}'
    for name, spec in loop.blocks.items():
        if not spec.plain or spec.model.learned:
            return f'{name} learns, predicts, has a lead or does not send every sample'
        if spec.model.confine is not free:
            return f'the states of {name} have bounds'
    return ''


def _off_line(loop: Loop, axis: Axis) -> str:
    """Say why an orbit does not change smoothly along an axis, '' where it may."""
    blocks = [spec for name, spec in loop.blocks.items() if axis.node in (name, '/**')]
    if not any(p.name == axis.parameter for spec in blocks for p in spec.model.parameters):
        return f'{axis.name} is no parameter of a model'
    return '' if Line(axis.values).ordered else f'the values of {axis.name} are in no order'
