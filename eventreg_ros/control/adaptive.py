# SPDX-License-Identifier: Apache-2.0
"""The adaptive internal model: a controller that learns a parameter of its generator as it runs.

Any model that says how it learns (:class:`..models.Learner`) becomes one with a further, last
state: the parameter. With the oscillator and gain gamma, and e its drive (y, or y - y_r), that is
eq. s.I unchanged and

    tau' = -gamma k e x2 tau,    0 where it points out of the bounds.

Where e = 0 nothing moves: at synchrony there is no drift, and a silent loop teaches nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

from ..errors import ModelError
from ..models.model import (
    Jacobian,
    Learner,
    Model,
    ModelParameter,
    Observed,
    Output,
    Params,
    Rhs,
    State,
    first_state,
)
from ..simulation.block import BlockSpec

GAIN = 'adapt'
"""The parameter that holds the gain; 0 is the fixed controller."""

LARGEST = 0.08
"""The gain up to which every oscillator with tau in 1/25..1/6 has been seen to learn its own.

Twice as much fails for slow ones: the averaged rate is then no longer slow against a period.
"""


def learning_parameters(learner: Learner) -> tuple[ModelParameter, ...]:
    """Return the parameters that a controller has for learning: the gain, and the bounds."""
    name = learner.parameter
    return (
        ModelParameter(
            GAIN, f'gain with which the controller learns {name}; 0: fixed', 0.0, low=0.0
        ),
        ModelParameter(
            f'{name}_min', f'least {name} that it learns', learner.low, low=0.0, open_low=True
        ),
        ModelParameter(
            f'{name}_max', f'largest {name} that it learns', learner.high, low=0.0, open_low=True
        ),
    )


@lru_cache(maxsize=64)
def adaptive(model: Model) -> Model:
    """Return ``model`` with the parameter that it learns as a further, last state.

    Its parameters are those of ``model``, then gain and bounds; the learned one's own value has no
    effect, since the state takes its place. Raises ModelError for a model that does not say how it
    learns, or that has lists among its parameters.
    """
    learner = model.learns
    if learner is None or any(parameter.length is not None for parameter in model.parameters):
        raise ModelError(f'model {model.name!r} does not say how it learns; set {GAIN} to 0')
    split, join = _algebra(model, learner)
    return replace(
        model,
        name=f'adaptive {model.name}',
        dimension=model.dimension + 1,
        rhs=_rhs(model, learner, split, join),
        output=model.output if model.output is first_state else _output(model, split),
        parameters=model.parameters + learning_parameters(learner),
        pack=None,
        jacobian=_jacobian(model, learner, split),
        x0=None,
        confine=_confine(model, split, join),
        observed=(*model.observed, Observed(learner.parameter, model.dimension)),
        learns=None,
        learned=(learner.parameter,),
        base=model,
        split=split,
    )


def fixed(spec: BlockSpec) -> BlockSpec:
    """Return a block that learns nothing, at the values from which ``spec`` starts."""
    base = spec.model.base
    if base is None:
        return spec
    values = dict(zip([p.name for p in base.parameters], spec.params, strict=False))
    return replace(spec, model=base, params=base.params(values), x0=spec.x0[: base.dimension])


def paused(model: Model, p: Params) -> Params:
    """Return the parameters ``p`` of ``model`` with which it learns nothing."""
    if not model.learned:
        return p
    gain = [parameter.name for parameter in model.parameters].index(GAIN)
    return (*p[:gain], 0.0, *p[gain + 1 :])


def _algebra(model: Model, learner: Learner) -> tuple[Callable[..., Any], Callable[..., State]]:
    """Return ``split(x, p)``, the model's own state and parameters, and ``join(x, value)``.

    Written out for the dimension, as :func:`..simulation.step.make_step` does it.
    """
    names = [parameter.name for parameter in model.parameters]
    n, at = model.dimension, names.index(learner.parameter)
    state = ', '.join(f'x[{i}]' for i in range(n))
    params = ', '.join(f'x[{n}]' if i == at else f'p[{i}]' for i in range(len(names)))
    source = (
        f'def split(x, p):\n    return ({state},), ({params},)\n'
        f'def join(x, value):\n    return ({state}, value)\n'
    )
    found: dict[str, Callable[..., Any]] = {}
    exec(compile(source, f'<adaptive {model.name}>', 'exec'), found)
    return found['split'], found['join']


def _rhs(
    model: Model, learner: Learner, split: Callable[..., Any], join: Callable[..., State]
) -> Rhs:
    n, gain = model.dimension, len(model.parameters)
    own, learning = model.rhs, learner.rate

    def rhs(x: State, drive: float, p: Params) -> State:
        state, q = split(x, p)
        rate = p[gain] * learning(state, drive, q)
        if (x[n] <= p[gain + 1] and rate < 0.0) or (x[n] >= p[gain + 2] and rate > 0.0):
            rate = 0.0
        return join(own(state, drive, q), rate)

    return rhs


def _output(model: Model, split: Callable[..., Any]) -> Output:
    own = model.output

    def output(x: State, drive: float, p: Params) -> float:
        state, q = split(x, p)
        return own(state, drive, q)

    return output


def _confine(
    model: Model, split: Callable[..., Any], join: Callable[..., State]
) -> Callable[[State, Params], State]:
    n, gain = model.dimension, len(model.parameters)
    own = model.confine

    def confine(x: State, p: Params) -> State:
        state, q = split(x, p)
        value, low, high = x[n], p[gain + 1], p[gain + 2]
        if value < low:
            value = low
        elif value > high:
            value = high
        return join(own(state, q), value)

    return confine


def _jacobian(model: Model, learner: Learner, split: Callable[..., Any]) -> Jacobian | None:
    n, gain, own = model.dimension, len(model.parameters), model.jacobian
    if own is None:
        return None

    def jacobian(x: State, drive: float, p: Params) -> tuple[State, ...]:
        state, q = split(x, p)
        rows, column = own(state, drive, q), learner.sensitivity(state, drive, q)
        still = p[gain] * learner.rate(state, drive, q)
        bound = (x[n] <= p[gain + 1] and still < 0.0) or (x[n] >= p[gain + 2] and still > 0.0)
        last = (0.0 if bound else p[gain] * each for each in learner.gradient(state, drive, q))
        return (
            *((*row[:-1], d, row[-1]) for row, d in zip(rows, column, strict=True)),
            tuple(last),
        )

    return jacobian
