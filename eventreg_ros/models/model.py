# SPDX-License-Identifier: Apache-2.0
"""What a model is: a right-hand side, an output, a dimension and parameters, all pure.

One order of arguments everywhere: ``rhs(x, drive, p)`` and ``output(x, drive, p)``.

``x``
    state, a tuple of ``dimension`` floats in the paper's order.
``drive``
    the sum of the signed inputs, sigma_1 z_1 + sigma_2 z_2 + ..., one float.
``p``
    the parameters, a tuple of floats in the order of :attr:`Model.parameters`.

Everything is scalars and tuples, in and out, so that the same functions run as plain Python in the
nodes and compiled by numba in the sweeps.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

State = tuple[float, ...]
Params = tuple[float, ...]
Rhs = Callable[[State, float, Params], State]
Output = Callable[[State, float, Params], float]
Split = Callable[[State, Params], tuple[State, Params]]
Jacobian = Callable[[State, float, Params], tuple[State, ...]]


@dataclass(frozen=True)
class ModelParameter:
    """One parameter of a model; it becomes a ROS parameter of the block and a scenario key.

    ``low`` is the least value allowed, or the bound that it must exceed when ``open_low``;
    ``length`` makes it a list of so many numbers; ``live`` says whether it may be set while the
    node runs. ``unit`` is for readers: values are never converted. k, tau, gain and k_y exist in
    every block; a model that names one of them reads that one, with the default of the role unless
    ``default`` says otherwise.
    """

    name: str
    doc: str
    default: float | tuple[float, ...] | None = None
    unit: str = ''
    low: float | None = None
    open_low: bool = False
    high: float | None = None
    length: int | None = None
    live: bool = True


def free(x: State, p: Params) -> State:
    """Return ``x`` as it is: no bounds."""
    return x


class Observed(NamedTuple):
    """A state that is published beside the output, as the signal ``<output>/<name>``."""

    name: str
    state: int


def output_beside(signal: str, signals: Collection[str]) -> str | None:
    """Return the output beside which ``signal`` is published: u for u/tau; None for an output.

    ``signals`` are all there are.
    """
    output = signal.rpartition('/')[0]
    return output if output in signals else None


@dataclass(frozen=True)
class Learner:
    """How a model learns one of its parameters while it runs; see :mod:`..control.adaptive`.

    ``rate(x, drive, p)`` is the parameter's derivative by model time per unit of gain, kept within
    ``low`` and ``high`` (defaults, the user may set others). For the variational equation,
    ``sensitivity(x, drive, p)`` is the derivative of the model's ``rhs`` by the parameter, and
    ``gradient(x, drive, p)`` that of ``rate``: by each state, by the parameter, by the drive.
    """

    parameter: str
    rate: Output
    low: float
    high: float
    sensitivity: Rhs
    gradient: Callable[[State, float, Params], State]


@dataclass(frozen=True)
class Model:
    """A dynamical system with one scalar input and one scalar output.

    ``parameters`` are packed into ``p`` in their order, lists element by element, by ``pack``, a
    NamedTuple's class say. ``feedthrough`` says that the output depends on the drive of the same
    instant. ``jacobian(x, drive, p)`` is the derivative of ``rhs``, one row per state: by each
    state, and in the last column by the drive; without it ``eventreg certify`` cannot measure
    exponents. ``output`` must be linear in (x, drive): it is its own derivative. ``x0`` is the
    initial state where none is given; None takes the role's. ``confine(x, p)`` brings a state back
    within its bounds after each step. ``observed`` are
    the states that are published beside the output. ``learns`` says how a controller may learn a
    parameter; ``learned`` names the parameters that are the last states instead, in a model made of
    ``base``, whose state and parameters ``split(x, p)`` returns.
    """

    name: str
    dimension: int
    rhs: Rhs
    output: Output
    parameters: tuple[ModelParameter, ...] = ()
    pack: Callable[..., Params] | None = None
    feedthrough: bool = False
    jacobian: Jacobian | None = None
    x0: State | None = None
    pointwise: bool = False
    """Whether ``output`` takes single numbers only, no arrays."""
    confine: Callable[[State, Params], State] = free
    observed: tuple[Observed, ...] = ()
    learns: Learner | None = None
    learned: tuple[str, ...] = ()
    base: Model | None = None
    split: Split | None = None

    @property
    def own(self) -> int:
        """How many of the states are the model's own, not parameters that it learns."""
        return self.dimension - len(self.learned)

    @property
    def is_ours(self) -> bool:
        """Whether all of its code belongs to this package."""
        code = (self.rhs, self.output, self.confine, self.jacobian, self.pack)
        modules = {getattr(each, '__module__', '') for each in code if each is not None}
        home = __name__.partition('.')[0]
        ours = all(module.partition('.')[0] == home for module in modules)
        return ours and (self.base is None or self.base.is_ours)

    def params(self, values: Mapping[str, Any]) -> Params:
        """Return ``p`` from values by parameter name. Raises KeyError when one is missing."""
        numbers: list[float] = []
        for parameter in self.parameters:
            value = values[parameter.name]
            numbers += map(float, value if parameter.length is not None else [value])
        return self.pack(*numbers) if self.pack is not None else tuple(numbers)


def first_state(x: State, drive: float, p: Params) -> float:
    """Return the first state, the output of every model but the linear controller."""
    return x[0]
