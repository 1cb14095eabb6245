"""The table of models: those of the paper, and those that installed packages add.

A package adds a model by an entry point of the group ``eventreg_ros.models``: its name is the
model's, its object a :class:`.model.Model`.
"""

from __future__ import annotations

from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points

from ..errors import ModelError
from .hodgkin_huxley import HODGKIN_HUXLEY, HODGKIN_HUXLEY_OSCILLATOR
from .linear import HARMONIC, INTERNAL_MODEL, LAG
from .model import Model
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

    Raises ModelError for a name that nobody offers, or when a package's model cannot be loaded.
    """
    if name == 'linear':
        return LINEAR[role]
    return ALIKE[name] if name in ALIKE else _plugged_in(name)


@lru_cache(maxsize=1)
def _installed() -> dict[str, EntryPoint]:
    return {found.name: found for found in entry_points(group=GROUP)}


@lru_cache(maxsize=64)
def _plugged_in(name: str) -> Model:
    found = _installed().get(name)
    if found is None:
        raise ModelError(f'no model {name!r}; there are {", ".join(model_names())}')
    try:
        model = found.load()
    except Exception as error:  # whatever the package's own code raises
        raise ModelError(
            f'model {name!r} ({found.value}) cannot be loaded: {type(error).__name__}: {error}; '
            'fix or remove the package that offers it'
        ) from None
    if not isinstance(model, Model):
        raise ModelError(
            f'model {name!r} ({found.value}) must be an eventreg_ros.models.Model, '
            f'got {type(model).__name__}; fix the package that offers it'
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
