"""The table of roles: who has which model, which signed inputs, which output, which defaults."""

from __future__ import annotations

from dataclasses import dataclass

from .linear import HARMONIC, INTERNAL_MODEL, LAG
from .model import Model
from .neuron import NEURON, OSCILLATOR


@dataclass(frozen=True)
class Role:
    """One of the four blocks of the paper's loop and what it is unless told otherwise.

    ``excitatory`` and ``inhibitory`` are the signals with sigma = +1 and -1; ``x0`` is the initial
    state of the default model, in the paper's order; ``linear`` is what ``model: linear`` means
    here, and ``x0_linear`` where that starts.
    """

    name: str
    model: str
    k: float
    tau: float
    x0: tuple[float, ...]
    excitatory: tuple[str, ...]
    inhibitory: tuple[str, ...]
    output: str
    linear: Model
    x0_linear: tuple[float, ...]


ROLES = {
    role.name: role
    for role in (
        Role('exosystem', 'oscillator', 2.0, 1 / 12, (1.0, 0.0, -1.0, 0.0),
             (), (), 'w', HARMONIC, (1.0, 0.0)),
        Role('plant', 'neuron', 1.0, 1 / 11, (0.0, 0.0),
             ('w', 'v'), ('u',), 'y', LAG, (0.0,)),
        Role('controller', 'oscillator', 2.0, 1 / 12, (0.5, 0.0, -0.5, 0.0),
             ('y',), ('y_r',), 'u', INTERNAL_MODEL, (0.0, 0.0)),
        Role('reference', 'neuron', 1.0, 1 / 11, (0.0, 0.0),
             ('v',), (), 'y_r', LAG, (0.0,)),
    )
}  # fmt: skip

STIMULUS_OUTPUT = 'v'
SIGNALS = ('w', 'v', 'y', 'y_r', 'u')
"""The signals of the paper's loop, in the order in which tables and plots show them."""

MODEL_NAMES = ('neuron', 'oscillator', 'linear')


def model_of(role: str, name: str) -> Model:
    """Return the model called ``name`` in ``role``; ``linear`` depends on the role.

    Raises KeyError for a name that is not in :data:`MODEL_NAMES`.
    """
    return {'neuron': NEURON, 'oscillator': OSCILLATOR, 'linear': ROLES[role].linear}[name]


def default_x0(role: str, name: str) -> tuple[float, ...]:
    """Return the initial state of ``role`` with the model called ``name``.

    A model that is not the role's own takes as many of the role's values as it has states, and
    zeros beyond.
    """
    spec = ROLES[role]
    x0 = spec.x0_linear if name == 'linear' else spec.x0
    dimension = model_of(role, name).dimension
    return (x0 + (0.0,) * dimension)[:dimension]
