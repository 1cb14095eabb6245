# SPDX-License-Identifier: Apache-2.0
"""A block: a model, its parameters, its wiring, its state; what nodes run and simulations step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..models import Model, Params, State
from .coding import Coding
from .hold import drives, horizon_in_steps
from .model_time import steps_of
from .numbered import Numbered
from .step import Compile, make_step, plain

Advance = Callable[[State, Any, Any, Any, Params, float], tuple[State, float]]


@dataclass(frozen=True)
class BlockSpec:
    """Everything that decides what a block does; a scenario holds one for each of its blocks.

    ``name`` is its node's, ``role`` one of :data:`..models.ROLES`. ``inputs`` are (signal, sign)
    with sign +1.0 or -1.0, in the order in which they are summed; ``rate`` is in steps per second,
    ``time_scale`` in model time units per second. A plant plays its inhibitory inputs ``lead``
    (model time) after their samples were made. ``numbered`` is there for a block that reads its
    inputs by number, ``coding`` for one whose output is coded. ``held`` are the inputs that stay as
    they are between samples, whatever ``hold`` says.
    """

    name: str
    role: str
    model: Model
    params: Params
    x0: State
    inputs: tuple[tuple[str, float], ...]
    output: str
    rate: float
    time_scale: float
    hold: str
    lead: float = 0.0
    numbered: Numbered | None = None
    coding: Coding | None = None
    held: frozenset[str] = frozenset()

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return self.time_scale / self.rate

    @property
    def observed(self) -> dict[str, int]:
        """The signals that it publishes beside its output, each with its place in the state."""
        return {f'{self.output}/{name}': state for name, state in self.model.observed}

    @property
    def signals(self) -> list[str]:
        """All signals that it publishes, the output first."""
        return [self.output, *self.observed]

    @property
    def horizon(self) -> float:
        """Steps over which an input's line is drawn onwards; 0 for the zero hold."""
        return horizon_in_steps(self.hold, self.h)

    @property
    def drawn(self) -> tuple[float, ...]:
        """For each input 1, or 0 where it is held and so has no horizon."""
        return tuple(0.0 if signal in self.held else 1.0 for signal, _ in self.inputs)

    @property
    def plain(self) -> bool:
        """Whether all samples of inputs and output travel, and are used as they come."""
        return self.numbered is None and self.coding is None and not (self.held or any(self.leads))

    @property
    def lead_steps(self) -> int:
        """The lead in whole steps."""
        return steps_of(self.lead, self.h)

    @property
    def leads(self) -> tuple[int, ...]:
        """How many steps after they were made the samples of each input are played."""
        return leads_of(self.role, self.inputs, self.lead_steps)


def leads_of(role: str, inputs: Sequence[tuple[str, float]], lead: int) -> tuple[int, ...]:
    """Return by how many steps each input's samples are ahead: by ``lead``, what a plant subtracts.

    ``inputs`` are (signal, sign).
    """
    return tuple(lead if role == 'plant' and sign < 0.0 else 0 for _, sign in inputs)


def make_advance(model: Model, compile: Compile = plain) -> Advance:
    """Return ``advance(x, sign, base, slope, p, h) -> (x, y)``, one step of a block.

    The inputs have the signs ``sign`` and lie on the lines (``base``, ``slope``), each with one
    entry per input; see :mod:`.hold`. ``compile`` is applied to every function that it calls.
    """
    step = make_step(model.rhs, model.dimension, compile)
    output, add_up, confine = compile(model.output), compile(drives), compile(model.confine)

    def advance(
        x: State, sign: Any, base: Any, slope: Any, p: Params, h: float
    ) -> tuple[State, float]:
        d0, dm, d1 = add_up(sign, base, slope)
        x = confine(step(x, d0, dm, d1, p, h), p)
        return x, output(x, d1, p)

    return compile(advance)  # type: ignore[no-any-return]


def retuned(x: State, old: BlockSpec, new: BlockSpec) -> State:
    """Return the state with which a block goes on when other parameters are set.

    The model's own states stay, and so does what comes behind them all; what is learned begins anew
    at the value of the new spec's x0.
    """
    own = new.model.own
    return (*x[:own], *new.x0[own:], *x[old.model.dimension :])


def learned(spec: BlockSpec, x: State) -> dict[str, float]:
    """Return the parameters that a block has learned at state ``x``, by name."""
    model = spec.model
    return dict(zip(model.learned, x[model.own : model.dimension], strict=True))


def begin(spec: BlockSpec, n: int = 0) -> tuple[State, float]:
    """Return the state of a block that begins at step ``n``, without its coder's, and sample n."""
    if spec.numbered is not None:
        return spec.numbered.begin(spec, n)
    x = tuple(map(float, spec.x0))
    return x, spec.model.output(x, 0.0, spec.params)


class Block:
    """The state of a block and the one way to move it on, as a node does it."""

    def __init__(self, spec: BlockSpec) -> None:
        self.spec = spec
        self.x: State = spec.x0
        self.reset()
        self.retune(spec)

    def retune(self, spec: BlockSpec) -> None:
        """Take over other parameters and go on from the present state.

        What the model learns begins anew at the value of ``spec.x0``; see :attr:`learned`.
        """
        self.x = retuned(self.x, self.spec, spec)
        self._advance = make_advance(spec.model)
        self.spec, self.params = spec, spec.params
        self._sign = tuple(sign for _, sign in spec.inputs)
        self._h = spec.h

    def reset(self) -> None:
        """Go back to the initial state, before any input has come (all inputs 0)."""
        self.x = self.spec.x0
        self.y = self.spec.model.output(self.x, 0.0, self.spec.params)

    @property
    def learned(self) -> dict[str, float]:
        """The present values of the parameters that the model learns, by name."""
        return learned(self.spec, self.x)

    def advance(self, base: Sequence[float], slope: Sequence[float]) -> float:
        """Take one step with the inputs on the lines (``base``, ``slope``); return the output.

        Both have one entry per input of the spec, in its order; see :mod:`.hold`.
        """
        self.x, self.y = self._advance(self.x, self._sign, base, slope, self.params, self._h)
        return self.y
