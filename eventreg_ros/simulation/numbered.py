# SPDX-License-Identifier: Apache-2.0
"""Blocks that read their inputs by the numbers of the samples, not as lines over the present step.

A block of this kind may use samples of long ago, and those between the last two that it used. What
it is made of is in :mod:`..control`; here is only how loops and nodes run one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from ..models import Model, State
from .step import Compile, plain

if TYPE_CHECKING:
    from .block import BlockSpec


class Reader(NamedTuple):
    """How the samples of a signal are read by number; ``past`` is whatever holds them.

    ``newest(n, past)`` is the number of the last sample that is there at step n, ``last(s, past)``
    that of the last one up to s that ever came, -1 for none; ``value(s, past)`` is sample s.
    """

    newest: Callable[[int, Any], int]
    last: Callable[[int, Any], int]
    value: Callable[[int, Any], float]


Own = Callable[[int, Any], float]
"""``own(s, past)`` is sample s of the block's own output."""

Advance = Callable[[int, State, Any, float, Any], tuple[State, float]]
"""``advance(n, x, tuning, h, past) -> (x, y)``: the step from n, and sample n + 1."""

Make = Callable[[Model, Sequence[Reader], Own, Compile], Advance]


class Numbered(Protocol):
    """What a block of this kind adds to its spec; hashable."""

    @property
    def make(self) -> Make:
        """What makes its step; the same for all settings of one model."""

    def begin(self, spec: BlockSpec, n: int = 0) -> tuple[State, float]:
        """Return its state when it begins at step ``n``, and the sample of that number.

        The states of the model come first, then what it remembers. A step before it begins gives
        that sample too.
        """

    def tuning(self, spec: BlockSpec) -> Any:
        """Return what may change from run to run, as the step takes it."""

    def effort(self, spec: BlockSpec) -> float:
        """Return about how many steps of an ordinary block one of its steps is worth."""

    def without_delay(self, spec: BlockSpec, published: Collection[str]) -> list[BlockSpec]:
        """Return the ordinary blocks that do the same where no link is late.

        The first has the name of ``spec``. Inputs that are not ``published`` count as 0.
        """


def make_resting(
    model: Model, readers: Sequence[Reader], own: Own, compile: Compile = plain
) -> Advance:
    """Return the step of a block that is off: its state stays, its output is 0."""

    def rest(n: int, x: State, tuning: Any, h: float, past: Any) -> tuple[State, float]:
        return x, 0.0

    return compile(rest)  # type: ignore[no-any-return]


def ordinary(spec: BlockSpec, published: Collection[str]) -> list[BlockSpec]:
    """Return the ordinary blocks that a block is in the limit of no delay, itself first."""
    return spec.numbered.without_delay(spec, published) if spec.numbered else [spec]
