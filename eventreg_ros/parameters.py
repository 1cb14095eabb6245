"""Every parameter of every node, once: name, type, default, rule. Nodes and offline tools read it.

:func:`resolve` turns what somebody gave into checked values; the nodes declare the same table to
ROS (with its descriptions and ranges), so a scenario that is refused here is refused there.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from .errors import ParameterError
from .models.neuron import FOLD
from .models.roles import MODEL_NAMES, ROLES, SIGNALS, STIMULUS_OUTPUT, default_x0, model_of
from .simulation.hold import HOLDS
from .simulation.stimulus import WAVEFORMS

Value = bool | int | float | str | list[float] | list[str]


@dataclass(frozen=True)
class Parameter:
    """One parameter: its ROS type, default, meaning and rule.

    ``type`` is one of bool, int, double, string, double[], string[]. ``low`` is the least value
    allowed, or the bound that it must exceed when ``open_low``; ``live`` says that it may be set
    while the node is active.
    """

    name: str
    type: str
    default: Any
    doc: str
    low: float | None = None
    open_low: bool = False
    high: float | None = None
    choices: tuple[str, ...] = ()
    length: int | None = None
    live: bool = False

    @property
    def rule(self) -> str:
        """The rule in words, as errors and ``ros2 param describe`` show it."""
        words = {
            'bool': 'true or false',
            'int': 'a whole number',
            'double': 'a finite number',
            'string': 'a string',
            'double[]': 'a list of finite numbers',
            'string[]': 'a list of strings',
        }[self.type]
        if self.choices:
            words = 'one of ' + ', '.join(self.choices)
        if self.low is not None:
            words += f' {">" if self.open_low else ">="} {self.low:g}'
        if self.high is not None:
            words += f'{" and" if self.low is not None else ""} <= {self.high:g}'
        if self.length is not None:
            words += f' of length {self.length}'
        return words

    def check(self, where: str, value: Any) -> Value:
        """Return ``value`` in the parameter's type.

        Whole numbers are taken where a double is meant. Raises ParameterError that names ``where``.
        """
        try:
            result = _convert(self.type, value)
            if self._allows(result):
                return result
        except (TypeError, ValueError):
            pass
        raise ParameterError(f'{where}.{self.name} must be {self.rule}, got {value!r}')

    def _allows(self, value: Value) -> bool:
        if self.choices:
            return value in self.choices
        if self.length is not None and len(value) != self.length:  # type: ignore[arg-type]
            return False
        if isinstance(value, bool | str | list):
            return True
        if self.low is not None and not (value > self.low if self.open_low else value >= self.low):
            return False
        return self.high is None or value <= self.high


def _convert(kind: str, value: Any) -> Value:
    if kind.endswith('[]'):
        if isinstance(value, str | bytes) or not isinstance(value, Sequence):
            value = value.tolist() if hasattr(value, 'tolist') else _refuse()
        return [_convert(kind[:-2], item) for item in value]  # type: ignore[return-value]
    if kind == 'double' and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value) if math.isfinite(value) else _refuse()  # type: ignore[no-any-return]
    if kind == 'int' and isinstance(value, int) and not isinstance(value, bool):
        return value
    if (kind == 'bool' and isinstance(value, bool)) or (
        kind == 'string' and isinstance(value, str)
    ):
        return value
    return _refuse()


def _refuse() -> Any:
    raise TypeError


AUTOSTART = Parameter(
    'autostart', 'bool', True, 'configure and activate the node as soon as it starts'
)
START_TIME = Parameter(
    'start_time', 'double', 0.0,
    'ROS time in seconds at which the first sample is published once active; 0: at once', low=0.0,
)  # fmt: skip
RATE = Parameter('rate', 'double', 200.0, 'steps per second', low=0.0, open_low=True, high=100000.0)
TIME_SCALE = Parameter(
    'time_scale', 'double', 10.0, 'model time units per second',
    low=0.0, open_low=True, live=True,
)  # fmt: skip

_BLOCK = (
    Parameter('model', 'string', '', 'the dynamics of the block', choices=MODEL_NAMES),
    Parameter('k', 'double', 0.0, 'synaptic conductance; 0: uncoupled', low=0.0, live=True),
    Parameter(
        'tau', 'double', 0.0, 'time constant of the recovery', low=0.0, open_low=True, live=True
    ),
    Parameter(
        'gain', 'double[]', [1.0, 0.0], "K_eta of the linear controller's output", length=2, live=True
    ),
    Parameter('k_y', 'double', 0.0, "direct gain from y in the linear controller's output"),
    Parameter('x0', 'double[]', [], "initial state, in the paper's order"),
    Parameter('excitatory', 'string[]', [], 'input signals that enter with sign +1'),
    Parameter('inhibitory', 'string[]', [], 'input signals that enter with sign -1'),
    Parameter('output', 'string', '', 'the signal that the block publishes'),
    RATE,
    TIME_SCALE,
    Parameter(
        'hold', 'string', 'linear', 'how an input is reconstructed between samples', choices=HOLDS
    ),
    Parameter(
        'input_timeout', 'double', 0.5, 'seconds after which a silent input counts as 0',
        low=0.0, open_low=True,
    ),
    Parameter(
        'max_catch_up', 'double', 1.0,
        'seconds of model steps that are caught up at once after a pause; more is dropped', low=0.0,
    ),
    START_TIME,
    AUTOSTART,
)  # fmt: skip


def _role_parameters(name: str) -> tuple[Parameter, ...]:
    role = ROLES[name]
    own = {
        'model': role.model,
        'k': role.k,
        'tau': role.tau,
        'x0': list(role.x0),
        'excitatory': list(role.excitatory),
        'inhibitory': list(role.inhibitory),
        'output': role.output,
    }
    return tuple(replace(p, default=own.get(p.name, p.default)) for p in _BLOCK)


_SIGNALS = Parameter('signals', 'string[]', list(SIGNALS), 'the signals to watch')

NODES: dict[str, tuple[Parameter, ...]] = {
    **{role: _role_parameters(role) for role in ROLES},
    'stimulus': (
        Parameter('waveform', 'string', 'constant', 'the shape of v', choices=WAVEFORMS),
        Parameter('amplitude', 'double', 1.0, 'height of the waveform above offset', live=True),
        Parameter('offset', 'double', 0.0, 'added to the waveform', live=True),
        Parameter(
            'period', 'double', 50.0, 'of sine and square, model time', low=0.0, open_low=True
        ),
        Parameter('phase', 'double', 0.0, 'model time at which sine and square begin a period'),
        Parameter('onsets', 'double[]', [], 'model times at which the pulses begin'),
        Parameter('width', 'double', 10.0, 'length of a pulse or of the high part, model time',
                  low=0.0, open_low=True),
        Parameter('file', 'string', '', 'csv file with the columns t (model time) and v'),
        Parameter('output', 'string', STIMULUS_OUTPUT, 'the signal that the node publishes'),
        RATE,
        TIME_SCALE,
        START_TIME,
        AUTOSTART,
    ),
    'spike_monitor': (
        _SIGNALS,
        Parameter('threshold', 'double', FOLD, 'an event begins where the signal rises through it'),
        Parameter('reset', 'double', 0.0, 'the next event may begin once the signal is at or below'),
        AUTOSTART,
    ),
    'recorder': (
        _SIGNALS,
        Parameter('path', 'string', '', 'directory of the bag; empty: eventreg_<date>-<time>'),
        Parameter('storage', 'string', 'mcap', 'storage of the bag', choices=('mcap', 'sqlite3')),
        Parameter('scenario', 'string', '', 'parameter file whose text is stored in the bag'),
        Parameter('scenario_name', 'string', '', 'name under which the bag knows its scenario'),
        AUTOSTART,
    ),
}  # fmt: skip


def is_ros_parameter(name: str) -> bool:
    """Say whether every ROS node knows the parameter ``name`` without declaring it."""
    return name in ('use_sim_time', 'start_type_description_service') or name.startswith(
        'qos_overrides.'
    )


def resolve(node: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return all parameters of ``node``: those given, checked, and the defaults of the others.

    Parameters that belong to ROS itself pass unchecked. Raises ParameterError for a parameter that
    the node does not have, a wrong type, a broken rule, or values that do not fit each other.
    """
    table = {p.name: p for p in NODES[node]}
    values: dict[str, Any] = {}
    for name, value in given.items():
        if name in table:
            values[name] = table[name].check(node, value)
        elif not is_ros_parameter(name):
            raise ParameterError(f'{node} has no parameter {name!r}{hint(name, table)}')
    for name, parameter in table.items():
        values.setdefault(name, parameter.default)
    if node in ROLES and 'x0' not in given:
        values['x0'] = list(default_x0(node, values['model']))
    _check_together(node, values)
    return values


def _check_together(node: str, values: Mapping[str, Any]) -> None:
    if node in ROLES:
        dimension = model_of(node, values['model']).dimension
        if len(values['x0']) != dimension:
            raise ParameterError(
                f'{node}.x0 must have {dimension} numbers for model {values["model"]}, '
                f'got {values["x0"]!r}'
            )
        inputs = [*values['excitatory'], *values['inhibitory']]
        if values['output'] in inputs or len(set(inputs)) < len(inputs):
            raise ParameterError(
                f'{node}.excitatory, {node}.inhibitory and {node}.output must name different '
                f'signals, got {values["excitatory"]}, {values["inhibitory"]}, {values["output"]!r}'
            )
    if node == 'spike_monitor' and not values['reset'] < values['threshold']:
        raise ParameterError(
            f'spike_monitor.reset must be < threshold ({values["threshold"]:g}), '
            f'got {values["reset"]:g}'
        )
    if values.get('waveform') == 'csv' and not values['file']:
        raise ParameterError("stimulus.file must name a csv file for waveform csv, got ''")


def hint(name: str, known: Mapping[str, Any]) -> str:
    """Return the remedy for a name that is not among ``known``: the nearest, or all of them."""
    close = difflib.get_close_matches(name, known, 1)
    return f'; did you mean {close[0]!r}?' if close else f'; it has {", ".join(sorted(known))}'
