# SPDX-License-Identifier: Apache-2.0
"""From the parameters of a node to its block."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..control.adaptive import GAIN, adaptive
from ..control.prediction import Prediction
from ..control.spikes import Spikes
from ..models.catalogue import model_of
from ..models.limited import limited
from ..models.neuron import NeuronParams
from ..simulation.block import BlockSpec
from ..simulation.coding import Coding, Delta
from .inputs import signs_of
from .names import full_name, split

Values = Mapping[str, Any]


def block_spec(node: str, values: Values) -> BlockSpec:
    """Build the block of ``node`` from its resolved parameters; signals get its namespace."""
    name = split(node)
    model = model_of(name.kind, values['model'])
    x0 = tuple(values['x0'])
    if model.learns is not None and values.get(GAIN):
        model = adaptive(model)
        x0 += tuple(values[parameter] for parameter in model.learned)
    if values['output_limit']:
        model = limited(model, values['output_limit'])
    numbered = None
    if values.get('predict'):
        plant = NeuronParams(values['plant_k'], values['plant_tau'])
        numbered = Prediction(plant, values['input_timeout'] * values['time_scale'])
    return BlockSpec(
        name=node,
        role=name.kind,
        model=model,
        params=model.params(values),
        x0=x0,
        inputs=tuple(
            (full_name(name.namespace, signal), sign) for signal, sign in signs_of(values)
        ),
        output=full_name(name.namespace, values['output']),
        rate=values['rate'],
        time_scale=values['time_scale'],
        hold=values['hold'],
        lead=values['lead'],
        numbered=numbered,
        coding=coding_of(values),
        held=frozenset(full_name(name.namespace, s) for s in values['held_inputs']),
    )


def coding_of(values: Values) -> Coding | None:
    """Return how the output of a block is coded, None where every sample is sent."""
    if values.get('coding') == 'spikes':
        return Spikes(values['tau'])
    delta = values.get('send_on_delta', 0.0)
    return Delta(delta, 0.5 * values['input_timeout']) if delta else None
