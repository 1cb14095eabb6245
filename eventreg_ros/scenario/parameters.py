"""Every parameter of every node, once: name, type, default, rule. Nodes and offline tools read it.

:func:`resolve` turns what somebody gave into checked values; the nodes declare the same table to
ROS (with its descriptions and ranges), so a scenario that is refused here is refused there.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import Any

from ..errors import ParameterError
from ..models.neuron import FOLD
from ..models.roles import MODEL_NAMES, ROLES, SIGNALS, STIMULUS_OUTPUT, default_x0, model_of
from ..runtime.relay import ORDERS
from ..simulation.hold import HOLDS
from ..simulation.stimulus import WAVEFORMS
from .parameter import ACTIVE, UNCONFIGURED, Parameter

_TOPIC = re.compile(r'[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*')

AUTOSTART = Parameter(
    'autostart', 'bool', True, 'configure and activate the node as soon as it starts'
)
START_TIME = Parameter(
    'start_time',
    'double',
    0.0,
    'ROS time in seconds at which the first sample is published once active; 0: at once',
    low=0.0,
    high=9e9,
)
LOCKSTEP = Parameter(
    'lockstep',
    'bool',
    False,
    'step n waits for sample n of every input; needs the clock node',
    settable=UNCONFIGURED,
)
LOCKSTEP_TIMEOUT = Parameter(
    'lockstep_timeout',
    'double',
    5.0,
    'seconds without a step after which lockstep stops with an error',
    low=0.0,
    open_low=True,
)
PRECISION = Parameter(
    'precision',
    'double',
    0.0,
    'seconds before each tick from which on it spins (half a period at most); costs CPU',
    low=0.0,
    high=0.01,
)
LATE_WARN = Parameter(
    'late_warn', 'double', 1.0, 'steps by which a tick is late that make a WARN', low=0.0
)
LATE_ERROR = Parameter(
    'late_error', 'double', 20.0, 'steps by which a tick is late that make an ERROR', low=0.0
)
MAX_CATCH_UP = Parameter(
    'max_catch_up',
    'double',
    1.0,
    'seconds of model steps that are caught up at once after a pause; more is dropped',
    low=0.0,
    high=3600.0,
)
RATE = Parameter('rate', 'double', 200.0, 'steps per second', low=0.001, high=100000.0)
TIME_SCALE = Parameter(
    'time_scale',
    'double',
    10.0,
    'model time units per second',
    low=0.0,
    open_low=True,
    settable=ACTIVE,
)

_BLOCK = (
    Parameter('model', 'string', '', 'the dynamics of the block', choices=MODEL_NAMES),
    Parameter('k', 'double', 0.0, 'synaptic conductance; 0: uncoupled', low=0.0, settable=ACTIVE),
    Parameter(
        'tau',
        'double',
        0.0,
        'time constant of the recovery',
        low=0.0,
        open_low=True,
        settable=ACTIVE,
    ),
    Parameter(
        'gain',
        'double[]',
        [1.0, 0.0],
        "K_eta of the linear controller's output",
        length=2,
        settable=ACTIVE,
    ),
    Parameter('k_y', 'double', 0.0, "direct gain from y in the linear controller's output"),
    Parameter('x0', 'double[]', [], "initial state, in the paper's order"),
    Parameter(
        'excitatory', 'string[]', [], 'input signals that enter with sign +1', settable=UNCONFIGURED
    ),
    Parameter(
        'inhibitory', 'string[]', [], 'input signals that enter with sign -1', settable=UNCONFIGURED
    ),
    Parameter('output', 'string', '', 'the signal that the block publishes', settable=UNCONFIGURED),
    RATE,
    TIME_SCALE,
    Parameter(
        'hold', 'string', 'linear', 'how an input is reconstructed between samples', choices=HOLDS
    ),
    Parameter(
        'input_timeout',
        'double',
        0.5,
        'seconds after which a silent input counts as 0',
        low=0.0,
        open_low=True,
    ),
    LOCKSTEP,
    LOCKSTEP_TIMEOUT,
    PRECISION,
    LATE_WARN,
    LATE_ERROR,
    Parameter(
        'delay_margin',
        'double',
        0.25,
        'delay per link that the loop bears with the linear hold, model time; see eventreg margin',
        low=0.0,
        open_low=True,
        settable=ACTIVE,
    ),
    Parameter(
        'delay_margin_zero',
        'double',
        0.2,
        'the same with the zero hold',
        low=0.0,
        settable=ACTIVE,
    ),
    Parameter(
        'delay_warn',
        'double',
        0.8,
        'part of delay_margin from which on a measured delay makes a WARN',
        low=0.0,
        settable=ACTIVE,
    ),
    MAX_CATCH_UP,
    START_TIME,
    AUTOSTART,
)


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


_SIGNALS = Parameter(
    'signals', 'string[]', list(SIGNALS), 'the signals to watch', settable=UNCONFIGURED
)

NODES: dict[str, tuple[Parameter, ...]] = {
    **{role: _role_parameters(role) for role in ROLES},
    'stimulus': (
        Parameter('waveform', 'string', 'constant', 'the shape of v', choices=WAVEFORMS),
        Parameter(
            'amplitude', 'double', 1.0, 'height of the waveform above offset', settable=ACTIVE
        ),
        Parameter('offset', 'double', 0.0, 'added to the waveform', settable=ACTIVE),
        Parameter(
            'period', 'double', 50.0, 'of sine and square, model time', low=0.0, open_low=True
        ),
        Parameter('phase', 'double', 0.0, 'model time at which sine and square begin a period'),
        Parameter('onsets', 'double[]', [], 'model times at which the pulses begin'),
        Parameter(
            'width',
            'double',
            10.0,
            'length of a pulse or of the high part, model time',
            low=0.0,
            open_low=True,
        ),
        Parameter('file', 'string', '', 'csv file with the columns t (model time) and v'),
        Parameter(
            'output',
            'string',
            STIMULUS_OUTPUT,
            'the signal that the node publishes',
            settable=UNCONFIGURED,
        ),
        RATE,
        TIME_SCALE,
        LOCKSTEP,
        LOCKSTEP_TIMEOUT,
        PRECISION,
        LATE_WARN,
        LATE_ERROR,
        MAX_CATCH_UP,
        START_TIME,
        AUTOSTART,
    ),
    'spike_monitor': (
        _SIGNALS,
        Parameter('threshold', 'double', FOLD, 'an event is a rise of the signal through it'),
        Parameter('reset', 'double', 0.0, 'the next event may begin at or below it'),
        RATE,
        LOCKSTEP,
        LOCKSTEP_TIMEOUT,
        AUTOSTART,
    ),
    'recorder': (
        _SIGNALS,
        Parameter(
            'path',
            'string',
            '',
            'directory of the bag; empty: eventreg_<date>-<time>',
            settable=UNCONFIGURED,
        ),
        Parameter(
            'storage',
            'string',
            'mcap',
            'storage of the bag',
            choices=('mcap', 'sqlite3'),
            settable=UNCONFIGURED,
        ),
        Parameter(
            'scenario',
            'string',
            '',
            'parameter file whose text is stored in the bag',
            settable=UNCONFIGURED,
        ),
        Parameter(
            'scenario_name',
            'string',
            '',
            'name under which the bag knows its scenario',
            settable=UNCONFIGURED,
        ),
        RATE,
        LOCKSTEP,
        LOCKSTEP_TIMEOUT,
        AUTOSTART,
    ),
    'clock': (
        Parameter(
            'participants',
            'string[]',
            [],
            'the nodes that the clock waits for; none: it only publishes /clock',
            settable=UNCONFIGURED,
        ),
        Parameter(
            'real_time_factor',
            'double',
            0.0,
            'simulated seconds per second; 0: as fast as the nodes go',
            low=0.0,
            high=1e4,
            settable=ACTIVE,
        ),
        Parameter('steps', 'int', 0, 'steps after which the clock stops; 0: never', low=0.0),
        Parameter(
            'window', 'int', 150, 'steps granted at once', low=1.0, high=500.0, settable=ACTIVE
        ),
        LOCKSTEP_TIMEOUT,
        RATE,
        AUTOSTART,
    ),
    'link': (
        Parameter(
            'input', 'string', 'in', 'the signal that enters the link', settable=UNCONFIGURED
        ),
        Parameter(
            'output', 'string', 'out', 'the signal that leaves the link', settable=UNCONFIGURED
        ),
        Parameter(
            'delay',
            'double',
            0.0,
            'seconds from entering to leaving',
            low=0.0,
            high=60.0,
            settable=ACTIVE,
        ),
        Parameter(
            'jitter',
            'double',
            0.0,
            'more seconds of delay, uniform from 0 to this',
            low=0.0,
            high=60.0,
            settable=ACTIVE,
        ),
        Parameter(
            'loss',
            'double',
            0.0,
            'probability that a sample is dropped',
            low=0.0,
            high=1.0,
            settable=ACTIVE,
        ),
        Parameter(
            'duplicate',
            'double',
            0.0,
            'probability that a sample is sent twice',
            low=0.0,
            high=1.0,
            settable=ACTIVE,
        ),
        Parameter(
            'order',
            'string',
            'newest',
            'a sample that a later one would overtake is discarded (newest), holds that one up '
            '(fifo), or leaves late (any)',
            choices=ORDERS,
            settable=ACTIVE,
        ),
        Parameter(
            'seed',
            'int',
            0,
            'of the random numbers; setting another begins anew',
            low=0.0,
            high=2.0**53,
            settable=ACTIVE,
        ),
        AUTOSTART,
    ),
}


def kind_of(node: str) -> str:
    """Return the kind of node called ``node``: a link may be called link_<anything>."""
    return 'link' if node.startswith('link_') else node


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
    table = {p.name: p for p in NODES[kind_of(node)]}
    values: dict[str, Any] = {}
    for name, value in given.items():
        if name in table:
            values[name] = table[name].check(node, value)
        elif not is_ros_parameter(name):
            raise ParameterError(f'{node} has no parameter {name!r}{hint(name, table)}')
    for name, parameter in table.items():
        values.setdefault(name, copy(parameter.default))
    if node in ROLES and ('x0' not in given or not values['x0']):
        values['x0'] = list(default_x0(node, values['model']))
    _check_together(node, values)
    return values


def _check_together(node: str, values: Mapping[str, Any]) -> None:
    _check_signals(node, values)
    if node in ROLES:
        dimension = model_of(node, values['model']).dimension
        if len(values['x0']) != dimension:
            raise ParameterError(
                f'{node}.x0 must have {dimension} numbers for model {values["model"]}, '
                f'got {values["x0"]!r}'
            )
    if node == 'spike_monitor' and not values['reset'] < values['threshold']:
        raise ParameterError(
            f'spike_monitor.reset must be < threshold ({values["threshold"]:g}), '
            f'got {values["reset"]:g}'
        )
    if values.get('waveform') == 'csv' and not values['file']:
        raise ParameterError("stimulus.file must name a csv file for waveform csv, got ''")


def _check_signals(node: str, values: Mapping[str, Any]) -> None:
    for name in ('excitatory', 'inhibitory', 'input', 'output', 'signals'):
        value = values.get(name, [])
        for signal in [value] if isinstance(value, str) else value:
            if not _TOPIC.fullmatch(signal):
                raise ParameterError(
                    f'{node}.{name} must name relative topics (letters, digits, _ and /), '
                    f'got {signal!r}'
                )
    groups = (('excitatory', 'inhibitory', 'output'), ('input', 'output'), ('signals',))
    for group in groups:
        if not all(name in values for name in group):
            continue
        together: list[str] = []
        for name in group:
            together += values[name] if isinstance(values[name], list) else [values[name]]
        if len(set(together)) < len(together):
            raise ParameterError(
                f'{", ".join(f"{node}.{name}" for name in group)} must name different signals, '
                f'got {", ".join(map(repr, together))}'
            )


def hint(name: str, known: Mapping[str, Any]) -> str:
    """Return the remedy for a name that is not among ``known``: the nearest, or all of them."""
    close = difflib.get_close_matches(name, known, 1)
    return f'; did you mean {close[0]!r}?' if close else f'; it has {", ".join(sorted(known))}'
