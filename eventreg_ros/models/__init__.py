"""What the paper says: the models as pure functions, the roles they play, and the theory."""

from .linear import HARMONIC, INTERNAL_MODEL, LAG
from .model import Model, Params, State
from .neuron import FOLD, NEURON, OSCILLATOR
from .roles import MODEL_NAMES, ROLES, SIGNALS, Role, default_x0, model_of

__all__ = [
    'FOLD',
    'HARMONIC',
    'INTERNAL_MODEL',
    'LAG',
    'MODEL_NAMES',
    'NEURON',
    'OSCILLATOR',
    'ROLES',
    'SIGNALS',
    'Model',
    'Params',
    'Role',
    'State',
    'default_x0',
    'model_of',
]
