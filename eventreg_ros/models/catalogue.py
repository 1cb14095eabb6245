# SPDX-License-Identifier: Apache-2.0
"""The table of models: those of the paper, and those that installed packages add.

A package adds a model by an entry point of the group ``eventreg_ros.models``: its name is the
model's, its object a :class:`.model.Model`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ..errors import ModelError, described, shown
from .hodgkin_huxley import HODGKIN_HUXLEY, HODGKIN_HUXLEY_OSCILLATOR
from .linear import HARMONIC, INTERNAL_MODEL, LAG
from .model import Model, State
from .morris_lecar import MORRIS_LECAR, MORRIS_LECAR_OSCILLATOR
from .neuron import NEURON, OSCILLATOR
from .roles import ROLES

GROUP = 'eventreg_ros.models'

LINEAR = {
    'exosystem': HARMONIC,
    'plant': LAG,
    'controller': INTERNAL_MODEL,
    'reference': LAG,
}
"""What ``model: linear`` means in each role (the paper's linear motif)."""

OTHERS = (
    MORRIS_LECAR,
    MORRIS_LECAR_OSCILLATOR,
    HODGKIN_HUXLEY,
    HODGKIN_HUXLEY_OSCILLATOR,
)
ALIKE = {model.name: model for model in (NEURON, OSCILLATOR, *OTHERS)}
"""Our models that are the same in every role."""

BUILT_IN = ('neuron', 'oscillator', 'linear', *(model.name for model in OTHERS))


def model_names() -> tuple[str, ...]:
    """Return the names of all models, those of installed packages last."""
    return BUILT_IN + tuple(sorted(set(_installed()) - set(BUILT_IN)))


def model_of(role: str, name: str) -> Model:
    """Return the model called ``name`` in ``role``; ``linear`` depends on the role.

    Raises ModelError for a name that nobody offers, or that a package offers though it is ours, or
    when a package's model cannot be loaded.
    """
    if name in BUILT_IN and name in _installed():
        raise ModelError(
            f'model {name!r} ({_source(name)}) has the name of a built-in model; rename it in the '
            'package that offers it, or remove the package'
        )
    if name == 'linear':
        return LINEAR[role]
    return ALIKE[name] if name in ALIKE else _plugged_in(name)


@lru_cache(maxsize=1)
def _installed() -> dict[str, EntryPoint]:
    return {found.name: found for found in entry_points(group=GROUP)}


def _source(name: str) -> str:
    """Return where the model of an installed package comes from, in words."""
    found = _installed()[name]
    return f'{found.value} of package {found.dist.name}' if found.dist else found.value


def try_out(name: str, model: Model, x0: State, values: Mapping[str, Any]) -> None:
    """Evaluate a package's model once, at ``x0`` with the parameters ``values`` and no drive.

    Built-in models pass. Raises ModelError when its code raises, or returns other than ``rhs`` with
    ``dimension`` numbers and ``output`` with one.
    """
    if name in BUILT_IN:
        return
    where, part = f'model {name!r} ({_source(name)})', 'pack'
    try:
        p = model.params(values)
        part = 'rhs'
        slope = [float(each) for each in model.rhs(x0, 0.0, p)]
        part = 'output'
        float(model.output(x0, 0.0, p))
    except (Exception, SystemExit) as error:  # whatever the package's own code raises
        raise ModelError(
            f'{where}: {part} fails at x0 {shown(list(x0))}: {described(error)}; '
            'fix the package that offers it, or its parameters'
        ) from None
    if len(slope) != model.dimension:
        raise ModelError(
            f'{where}: rhs must return {model.dimension} numbers, its dimension, got {len(slope)}; '
            'fix the package that offers it'
        )


@lru_cache(maxsize=64)
def _plugged_in(name: str) -> Model:
    found = _installed().get(name)
    if found is None:
        raise ModelError(f'no model {name!r}; there are {", ".join(model_names())}')
    try:
        model = found.load()
    except (Exception, SystemExit) as error:  # whatever the package's own code raises
        raise ModelError(
            f'model {name!r} ({_source(name)}) cannot be loaded: {described(error)}; '
            'fix or remove the package that offers it'
        ) from None
    if not isinstance(model, Model):
        raise ModelError(
            f'model {name!r} ({_source(name)}) must be an eventreg_ros.models.Model, '
            f'got {type(model).__name__}; fix the package that offers it'
        )
    if model.x0 is not None and len(model.x0) != model.dimension:
        raise ModelError(
            f'model {name!r} ({_source(name)}): x0 must have {model.dimension} numbers, its '
            f'dimension, got {len(model.x0)}; fix the package that offers it'
        )
    return model


def default_x0(role: str, name: str) -> tuple[float, ...]:
    """Return the initial state of ``role`` with the model called ``name``.

    The model's own where it has one. Otherwise a model that is not the role's takes as many of the
    role's values as it has states, and zeros beyond.
    """
    model = model_of(role, name)
    if model.x0 is not None:
        return model.x0
    return (ROLES[role].x0 + (0.0,) * model.dimension)[: model.dimension]
