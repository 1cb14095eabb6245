# SPDX-License-Identifier: Apache-2.0
"""What the paper says: the models as pure functions, the roles they play, the table of models."""

from .catalogue import default_x0, model_names, model_of
from .linear import HARMONIC, INTERNAL_MODEL, LAG
from .model import Learner, Model, ModelParameter, Observed, Params, State, first_state
from .morris_lecar import MORRIS_LECAR, MORRIS_LECAR_OSCILLATOR
from .neuron import FOLD, NEURON, OSCILLATOR
from .roles import ROLES, SIGNALS, Role

__all__ = [
    'FOLD',
    'HARMONIC',
    'INTERNAL_MODEL',
    'LAG',
    'MORRIS_LECAR',
    'MORRIS_LECAR_OSCILLATOR',
    'NEURON',
    'OSCILLATOR',
    'ROLES',
    'SIGNALS',
    'Learner',
    'Model',
    'ModelParameter',
    'Observed',
    'Params',
    'Role',
    'State',
    'default_x0',
    'first_state',
    'model_names',
    'model_of',
]
