"""What a model is: a right-hand side, an output and a dimension, all pure.

One order of arguments everywhere: ``rhs(x, drive, p)`` and ``output(x, drive, p)``.

``x``
    state, a tuple of ``dimension`` floats in the paper's order.
``drive``
    the sum of the signed inputs, sigma_1 z_1 + sigma_2 z_2 + ..., one float.
``p``
    the parameters, always the five floats of :data:`PARAMETERS`; a model reads those it has.

Everything is scalars and tuples, in and out, so that the same functions run as plain Python in the
nodes and compiled by numba in the sweeps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

State = tuple[float, ...]
Params = tuple[float, float, float, float, float]
Rhs = Callable[[State, float, Params], State]
Output = Callable[[State, float, Params], float]
Jacobian = Callable[[State, float, Params], tuple[State, ...]]

PARAMETERS = ('k', 'tau', 'k_y', 'gain_1', 'gain_2')
"""The five floats of ``p``: conductance, time constant, and the linear controller's gains."""


@dataclass(frozen=True)
class Model:
    """A dynamical system with one scalar input and one scalar output.

    ``feedthrough`` says that the output depends on the drive of the same instant.
    ``jacobian(x, drive, p)`` is the derivative of ``rhs``, one row per state: by each state, and in
    the last column by the drive. ``output`` is linear in (x, drive): it is its own derivative.
    """

    name: str
    dimension: int
    rhs: Rhs
    output: Output
    feedthrough: bool = False
    jacobian: Jacobian | None = None


def first_state(x: State, drive: float, p: Params) -> float:
    """Return the first state, the output of every model but the linear controller."""
    return x[0]
