# SPDX-License-Identifier: Apache-2.0
"""Given values checked against the table of parameters, and completed by its defaults.

:func:`resolve` turns what somebody gave into checked values; the nodes declare the same rows to ROS
(with descriptions and ranges), so a scenario that is refused here is refused there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import Any

from ..control.adaptive import GAIN, learning_parameters
from ..errors import ModelError, ParameterError, shown
from ..models.catalogue import default_x0, model_names, model_of, try_out
from ..models.model import Model, ModelParameter
from ..models.neuron import OSCILLATOR
from ..models.roles import ROLES
from .hint import hint
from .inputs import OSCILLATES, delays_of, templates_of
from .names import NodeName, split
from .other_nodes import OTHERS
from .parameter import ACTIVE, INACTIVE, Parameter
from .table import FORESIGHT, MODEL, PACE, ROUTE, WIRES

ROS_OWN = {
    name: Parameter(name, 'bool', False, 'of every ROS node')
    for name in ('use_sim_time', 'start_type_description_service')
}
"""What every ROS node declares itself."""

_TOPIC = re.compile(r'[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*')


def parameters_of(node: str, given: Mapping[str, Any] | None = None) -> dict[str, Parameter]:
    """Return the parameters of the node called ``node``, by name, with its defaults.

    ``given`` decides what there is: the parameters of its ``model``, or, with a ``package``, none
    of a model. Raises ScenarioError for a name of no kind, ModelError for an unknown model.
    """
    given = given or {}
    foreign = is_foreign(given)
    name = split(node, foreign)
    if name.kind in OTHERS:
        rows = OTHERS[name.kind]
    elif foreign:
        rows = ROUTE + _wires(name) + PACE
    else:
        foresight = FORESIGHT if name.kind == 'controller' else ()
        rows = ROUTE + _model_rows(name.kind, given) + _wires(name) + foresight + PACE
    return {row.name: _named_after(name, row) for row in rows}


def is_foreign(values: Mapping[str, Any]) -> bool:
    """Say whether the node with these parameters is run by another package."""
    return values.get('package', '') not in ('', 'eventreg_ros')


def _named_after(name: NodeName, row: Parameter) -> Parameter:
    """Return a row whose default is the output of this very node, where it is about that."""
    renamed = row.name == 'output' and name.output
    return replace(row, default=name.output) if renamed else row


def _wires(name: NodeName) -> tuple[Parameter, ...]:
    role = ROLES.get(name.kind)
    if role is None:
        return WIRES
    own = {'excitatory': list(role.excitatory), 'inhibitory': list(role.inhibitory)}
    return tuple(replace(row, default=own.get(row.name, row.default)) for row in WIRES)


def _model_rows(kind: str, given: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """Return the rows of :data:`.table.MODEL` in a role, and those of the model in it."""
    role = ROLES[kind]
    own = {'model': role.model, 'k': role.k, 'tau': role.tau, 'x0': list(role.x0)}
    rows = {row.name: replace(row, default=own.get(row.name, row.default)) for row in MODEL}
    name = given.get('model', role.model)
    if isinstance(name, str) and name in model_names():
        for parameter in model_of(kind, name).parameters:
            if parameter.default is not None or parameter.name not in rows:
                rows[parameter.name] = _row_of(parameter)
        if kind == 'controller':
            rows |= {row.name: row for row in _learning_rows(model_of(kind, name))}
    return tuple(rows.values())


def _learning_rows(model: Model) -> tuple[Parameter, ...]:
    """Return the rows of a controller that can learn a parameter of its ``model``."""
    return tuple(map(_row_of, learning_parameters(model.learns) if model.learns else ()))


def _row_of(parameter: ModelParameter) -> Parameter:
    """Return the ROS parameter that a model's parameter becomes."""
    default: float | list[float]
    if isinstance(parameter.default, tuple) or parameter.length is not None:
        kind = 'double[]'
        given = parameter.default if isinstance(parameter.default, tuple) else ()
        default = list(given) or [0.0] * (parameter.length or 0)
    else:
        kind, default = 'double', parameter.default or 0.0
    return Parameter(
        parameter.name,
        kind,
        default,
        parameter.doc + (f' ({parameter.unit})' if parameter.unit else ''),
        low=parameter.low,
        open_low=parameter.open_low,
        high=parameter.high,
        length=parameter.length,
        settable=ACTIVE if parameter.live else INACTIVE,
    )


def all_parameters() -> dict[str, None]:
    """Return the names of all parameters that a node of ours may have, models of others apart."""
    rows = [*ROUTE, *MODEL, *_learning_rows(OSCILLATOR), *WIRES, *FORESIGHT, *PACE]
    rows += [row for table in OTHERS.values() for row in table]
    return {row.name: None for row in rows}


def has(node: str, given: Mapping[str, Any], parameter: str) -> bool:
    """Say whether ``node``, with the parameters ``given``, takes ``parameter`` from a wildcard."""
    return is_ros_parameter(parameter) or parameter in parameters_of(node, given)


def is_ros_parameter(name: str) -> bool:
    """Say whether every ROS node knows the parameter ``name`` without declaring it."""
    return name in ROS_OWN or name.startswith('qos_overrides.')


def need_no_part(node: str, name: str, table: Mapping[str, Parameter]) -> None:
    """Raise ParameterError where ``name`` is NAME.PART of a parameter NAME that has no parts."""
    whole = name.partition('.')[0]
    if whole in table and whole != name:
        raise ParameterError(
            f'{node}.{whole} must be {table[whole].rule}, got a mapping with '
            f'{shown(name[len(whole) + 1 :])}'
        )


def resolve(node: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return all parameters of ``node``: those given, checked, and the defaults of the others.

    Parameters that belong to ROS itself, or to a node of another package, pass unchecked. Raises
    ParameterError for a parameter that the node does not have, a wrong type, a broken rule, or
    values that do not fit each other; ScenarioError for a name of no kind.
    """
    try:
        table = parameters_of(node, given)
    except ModelError as error:
        raise ParameterError(f'{node}.model: {error}') from None
    foreign = is_foreign(given)
    if 'model' in table and 'model' in given:  # first: it decides what other parameters there are
        table['model'].check(node, given['model'])
    for name, value in given.items():
        if name in ROS_OWN:
            ROS_OWN[name].check(node, value)
        elif not foreign:
            need_no_part(node, name, table)
        if not (name in table or foreign or is_ros_parameter(name)):
            raise ParameterError(f'{node} has no parameter {name!r}{hint(name, table)}')
    others = {name: value for name, value in given.items() if name not in table}
    values = completed(node, table, given) | (others if foreign else {})
    if foreign and not values['executable']:
        raise ParameterError(
            f"{node}.executable must name an executable of package {values['package']}, got ''"
        )
    return values


def completed(
    node: str, table: Mapping[str, Parameter], given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the values of ``table``: those given, checked, and the defaults of the others.

    Raises ParameterError that names ``node``.
    """
    values = {n: row.check(node, given[n]) for n, row in table.items() if n in given}
    values |= {n: copy(row.default) for n, row in table.items() if n not in given}
    if 'model' in table:
        _settle_x0(node, values, 'x0' in given)
        _check_learning(node, values)
    _check_together(node, values)
    return values


def _check_together(node: str, values: Mapping[str, Any]) -> None:
    _check_signals(node, values)
    if values.get('predict'):
        _check_prediction(node, values)
    _check_coding(node, values)
    try:
        delays_of(values), templates_of(values)
    except ParameterError as error:
        raise ParameterError(f'{node}.{error}') from None
    if 'threshold' in values and not values['reset'] < values['threshold']:
        raise ParameterError(
            f'{node}.reset must be < threshold ({values["threshold"]:g}), got {values["reset"]:g}'
        )
    if values.get('waveform') == 'csv' and not values['file']:
        raise ParameterError(f"{node}.file must name a csv file for waveform csv, got ''")


def _check_learning(node: str, values: Mapping[str, Any]) -> None:
    """Check the bounds of what a controller learns; with adapt 0 they do not matter."""
    learner = model_of(split(node).kind, values['model']).learns
    if learner is None or not values.get(GAIN):
        return
    name = learner.parameter
    low, high, value = (values[key] for key in (f'{name}_min', f'{name}_max', name))
    if not low < high:
        raise ParameterError(
            f'{node}.{name}_min must be < {name}_max ({high:g}) to learn {name}, got {low:g}'
        )
    if not low <= value <= high:
        raise ParameterError(
            f'{node}.{name} must lie between {name}_min and {name}_max ({low:g} to {high:g}) '
            f'to be learned, got {value:g}; set the bounds, or {GAIN} to 0'
        )


def _check_coding(node: str, values: Mapping[str, Any]) -> None:
    if values.get('coding', 'samples') != 'spikes':
        return
    if not values['predict']:
        raise ParameterError(
            f'{node}.coding must be samples without predict, got spikes: a code of u is not right '
            'to a tenth of a spike, and only an observer knows by how much; set predict to true'
        )
    if values['send_on_delta']:
        raise ParameterError(
            f'{node}.send_on_delta must be 0 with coding spikes, got {values["send_on_delta"]:g}'
        )
    low, high = OSCILLATES
    if not low <= values['tau'] <= high:
        raise ParameterError(
            f'{node}.tau must be >= {low:g} and <= {high:g} with coding spikes, got '
            f'{values["tau"]:g}: the generator of the receiver must oscillate'
        )


def _check_prediction(node: str, values: Mapping[str, Any]) -> None:
    if not values['plant_k'] >= 1.0:
        raise ParameterError(
            f'{node}.plant_k must be >= 1 to predict, got {values["plant_k"]:g}: below, the plant '
            'in the predictor does not contract, so that errors of its start never fade'
        )
    if values['model'] != 'oscillator':
        raise ParameterError(
            f'{node}.model must be oscillator to predict, got {values["model"]}; set predict to '
            'false'
        )
    if len(values['excitatory']) != 1:
        raise ParameterError(
            f"{node}.excitatory must name one signal, the plant's output, to predict, got "
            f'{values["excitatory"]!r}; measured inputs of the plant belong to plant_inputs'
        )


def _settle_x0(node: str, values: dict[str, Any], given: bool) -> None:
    kind = split(node).kind
    model = model_of(kind, values['model'])
    if not (given and values['x0']):
        values['x0'] = list(default_x0(kind, values['model']))
    if len(values['x0']) != model.dimension:
        raise ParameterError(
            f'{node}.x0 must have {model.dimension} numbers for model {values["model"]}, '
            f'got {shown(values["x0"])}'
        )
    try:
        try_out(values['model'], model, tuple(values['x0']), values)
    except ModelError as error:
        raise ParameterError(f'{node}.model: {error}') from None


def _check_signals(node: str, values: Mapping[str, Any]) -> None:
    for name in ('excitatory', 'inhibitory', 'plant_inputs', 'input', 'output', 'signals'):
        value = values.get(name, [])
        for signal in [value] if isinstance(value, str) else value:
            if not _TOPIC.fullmatch(signal):
                raise ParameterError(
                    f'{node}.{name} must name relative topics (letters, digits, _ and /), '
                    f'got {shown(signal)}'
                )
    groups = (
        ('excitatory', 'plant_inputs', 'output'),
        ('excitatory', 'inhibitory', 'output'),
        ('input', 'output'),
        ('signals',),
    )
    for group in groups:
        if not all(name in values for name in group):
            continue
        together: list[str] = []
        for name in group:
            together += values[name] if isinstance(values[name], list) else [values[name]]
        if len(set(together)) < len(together):
            raise ParameterError(
                f'{", ".join(f"{node}.{name}" for name in group)} must name different signals, '
                f'got {shown(together)}'
            )
