# SPDX-License-Identifier: Apache-2.0
"""The closed loop as one system of differential equations: the models' functions, wired."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import EventregError
from ..models import Model, Params
from .block import BlockSpec
from .hold import drive as add_up
from .loop import Loop
from .trajectory import Array


class _Part(NamedTuple):
    """One block within the system: where its states, its inputs and its output are."""

    name: str
    model: Model
    params: Params
    first: int
    last: int
    sign: tuple[float, ...]
    sources: tuple[int, ...]
    still: tuple[float, ...]
    slot: int
    observed: tuple[tuple[int, int], ...]
    """Slot and state of each signal beside the output."""


class System:
    """All blocks as one ODE: x' = f(v, x), x the states of all blocks one after the other.

    ``x0`` is the initial state; ``slots`` says where :meth:`signals` has each signal. Raises
    EventregError when blocks close an algebraic loop.
    """

    def __init__(self, loop: Loop) -> None:
        self.slots = {name: 1 + i for i, name in enumerate(loop.signals)}
        self._unknown = [0.0] * (len(loop.signals) - len(loop.stimuli))
        self.x0 = [x for spec in loop.blocks.values() for x in spec.x0]
        self._parts, first = [], 0
        for name, spec in loop.blocks.items():
            last = first + spec.model.dimension
            self._parts.append(self._part(name, spec, first, last))
            first = last
        self._direct = [part for part in self._parts if not part.model.feedthrough]
        self._through = _in_order([part for part in self._parts if part.model.feedthrough])

    def _part(self, name: str, spec: BlockSpec, first: int, last: int) -> _Part:
        return _Part(
            name,
            spec.model,
            spec.params,
            first,
            last,
            tuple(sign for _, sign in spec.inputs),
            tuple(self.slots.get(signal, 0) for signal, _ in spec.inputs),
            (0.0,) * len(spec.inputs),
            self.slots[spec.output],
            tuple((self.slots[name], first + i) for name, i in spec.observed.items()),
        )

    def signals(self, v: Sequence[Any], x: Any) -> list[Any]:
        """Return all signals, by slot; slot 0 is 0, the input that nobody publishes.

        ``v`` are the open inputs, in the order of the loop's stimuli. They and the entries of ``x``
        are floats, or arrays of one shape (then so are the signals).
        """
        values = [0.0, *v, *self._unknown]
        for part in self._parts:
            for slot, i in part.observed:
                values[slot] = x[i]
        for part in self._direct:
            values[part.slot] = part.model.output(x[part.first : part.last], 0.0, part.params)
        for part in self._through:
            state, drive = x[part.first : part.last], self._drive(part, values)
            values[part.slot] = part.model.output(state, drive, part.params)
        return values

    def signals_over(self, v: Sequence[Array], x: Array) -> list[Array]:
        """Return all signals, by slot, for ``x`` of shape (states, n) and each of ``v`` of (n,)."""
        if not any(part.model.pointwise for part in self._parts):
            return self.signals(v, x)
        rows = [self.signals([each[i] for each in v], x[:, i].tolist()) for i in range(x.shape[1])]
        return list(np.array(rows).reshape(len(rows), 1 + len(self.slots)).T)

    def derivative(self, v: Sequence[float], x: Any) -> list[float]:
        """Return x' by model time."""
        values = self.signals(v, x)
        slope: list[float] = []
        for part in self._parts:
            state, drive = x[part.first : part.last], self._drive(part, values)
            slope += part.model.rhs(state, drive, part.params)
        return slope

    @staticmethod
    def _drive(part: _Part, values: Sequence[Any]) -> Any:
        return add_up(part.sign, [values[i] for i in part.sources], part.still, 0.0)


def _in_order(parts: list[_Part]) -> list[_Part]:
    """Sort blocks with feedthrough so that each comes after those that it reads.

    Raises EventregError when they go round in a circle.
    """
    done: list[_Part] = []
    while parts:
        waiting = {part.slot for part in parts}
        ready = [part for part in parts if not waiting.intersection(part.sources)]
        if not ready:
            names = ', '.join(part.name for part in parts)
            raise EventregError(
                f'algebraic loop: the outputs of {names} depend on each other at the '
                f'same instant; rewire one, or simulate with --sampled'
            )
        done += ready
        parts = [part for part in parts if part not in ready]
    return done
