# SPDX-License-Identifier: Apache-2.0
"""What is done to a running loop: parameters set, blocks switched off and on again.

A block that is off keeps its state and publishes 0. Switched on again it starts from x0: the next
sample is the output there. What it has learned outlasts both. The nodes do the same.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple

from ..models import Model, Params, State
from .block import BlockSpec, begin, learned, retuned
from .coding import make_deaf, make_mute
from .kernel import CodedOutput
from .model_time import steps_of
from .numbered import Make, make_resting, ordinary
from .stimulus import Stimulus

Action = Literal['set', 'activate', 'deactivate']


class Turn(NamedTuple):
    """One thing done at model time ``at``, to the block of that name or to a stimulus.

    ``spec`` gives the block as it is from then on, from what it has learned so far (by parameter);
    ``stimulus`` the open input, by the signal ``name``.
    """

    at: float
    name: str
    action: Action
    spec: Callable[[Mapping[str, float]], BlockSpec] | None = None
    stimulus: Stimulus | None = None

    def without_delay(self, published: Collection[str]) -> Turn:
        """Return the turn for the loop in the limit of no delay; see :class:`.loop.Loop`."""
        make = self.spec
        if make is None:
            return self
        return self._replace(spec=lambda learned: ordinary(make(learned), published)[0])


@dataclass(frozen=True)
class Condition:
    """A block in the course of a run: what it is, its state, and whether it runs."""

    spec: BlockSpec
    x: State
    running: bool = True
    starting: bool = False
    """Whether it was switched on just now: its next sample is the output at x0."""

    @property
    def learned(self) -> dict[str, float]:
        """What it has learned, by parameter."""
        return learned(self.spec, self.x)

    def after(self, turn: Turn, n: int = 0) -> Condition:
        """Return the condition after a turn at step ``n``."""
        assert turn.spec is not None
        # listeners know how the output was coded at the start
        spec = replace(turn.spec(self.learned), coding=self.spec.coding)
        if turn.action == 'deactivate':
            return self.off()
        if turn.action == 'activate':
            if self.running:
                return self
            begun = Condition.of(spec, n + 1, starting=True)
            own = len(begun.x) - self._coder
            return replace(begun, x=begun.x[:own] + self.x[len(self.x) - self._coder :])
        return replace(self, spec=spec, x=retuned(self.x, self.spec, spec))

    def off(self) -> Condition:
        """Return the condition of the block switched off.

        Its coder forgets all but how many messages there were; that it is off is one more.
        """
        coding, x = self.spec.coding, self.x
        if coding is not None and self.running:
            sent = self.messages + 1
            x = (*x[: -self._coder], *coding.start[:2], float(sent), *coding.start[3:])
        return replace(self, x=x, running=False, starting=False)

    @property
    def _coder(self) -> int:
        """How many of the states are the coder's; they come last."""
        return len(self.spec.coding.start) if self.spec.coding is not None else 0

    @property
    def messages(self) -> int:
        """In how many messages the output was sent, where it is coded."""
        return int(self.x[len(self.x) - self._coder + 2])

    @classmethod
    def of(cls, spec: BlockSpec, n: int = 0, *, starting: bool = False) -> Condition:
        """Return the condition of a block that begins at step ``n``."""
        x, _ = begin(spec, n)
        return cls(spec, x + (spec.coding.start if spec.coding else ()), True, starting)

    @property
    def code(self) -> CodedOutput | None:
        """What codes the output."""
        coding, size = self.spec.coding, len(self.x) - self._coder
        if coding is None:
            return None
        if self.running:
            return CodedOutput(coding.make, size, coding.make_copy)
        return CodedOutput(make_mute, size, make_deaf(coding.unheard))

    @property
    def make(self) -> Make | None:
        """What makes the coming step, for a block that reads its inputs by number."""
        numbered = self.spec.numbered
        if numbered is None:
            return None
        return numbered.make if self.running else make_resting

    @property
    def model(self) -> Model:
        """The model that moves it over the coming step."""
        if self.spec.numbered is not None:
            return self.spec.model
        if not self.running:
            return at_rest(self.spec.model)
        return at_start(self.spec.model) if self.starting else self.spec.model


def stretches(turns: Sequence[Turn], steps: int, h: float) -> Iterator[tuple[int, int, list[Turn]]]:
    """Yield (first, last, turns at first): the stretches of steps between turns, in order.

    A block that was switched on has a step of its own.
    """
    at: dict[int, list[Turn]] = {0: []}
    for turn in turns:
        step = steps_of(turn.at, h)
        if step < steps:
            at.setdefault(step, []).append(turn)
            if turn.action == 'activate' and step + 1 < steps:
                at.setdefault(step + 1, [])
    for first, last in pairwise([*sorted(at), steps]):
        yield first, last, at[first]


@lru_cache(maxsize=64)
def at_rest(model: Model) -> Model:
    """Return the model of a block that is off: its state stays, its output is 0."""

    def nothing(x: State, drive: float, p: Params) -> float:
        return 0.0

    return replace(model, rhs=_zeros(model.dimension), output=nothing, feedthrough=False)


@lru_cache(maxsize=64)
def at_start(model: Model) -> Model:
    """Return the model of a block that was just switched on: it stays at x0 for a step."""
    output = model.output

    def first(x: State, drive: float, p: Params) -> float:
        return output(x, 0.0, p)

    return replace(model, rhs=_zeros(model.dimension), output=first, feedthrough=False)


@lru_cache
def _zeros(dimension: int) -> Callable[[State, float, Params], State]:
    still = (0.0,) * dimension

    def rhs(x: State, drive: float, p: Params) -> State:
        return still

    return rhs
