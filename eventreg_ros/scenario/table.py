# SPDX-License-Identifier: Apache-2.0
"""The table of parameters: every parameter of every kind of node, once, as data.

Name, ROS type, default, meaning, rule, and until which state of the node it may be set. Nodes
declare these rows to ROS, offline tools check scenarios by them, docs list them. Here are those of
blocks, and those that several kinds share; the rest is in :mod:`.other_nodes`.
"""

from __future__ import annotations

from ..models.catalogue import model_names
from ..models.roles import STIMULUS_OUTPUT
from ..simulation.hold import HOLDS
from .parameter import ACTIVE, UNCONFIGURED, Parameter

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
    'seconds before each tick during which the node busy-waits (half a period at most); costs CPU',
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
    low=1e-9,
    high=1e9,
    settable=ACTIVE,
)

NAMES = 256
"""Entries of a list of signals or nodes, at most."""

ROUTE = (
    Parameter(
        'package',
        'string',
        '',
        'the package whose executable runs the node; empty: eventreg_ros',
        settable=UNCONFIGURED,
    ),
    Parameter(
        'executable',
        'string',
        '',
        "the executable that runs the node; empty: the node's kind",
        settable=UNCONFIGURED,
    ),
)
"""How a block of another package is started."""

MODEL = (
    Parameter('model', 'string', '', 'the dynamics of the block', choices=model_names),
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
)
"""What a block steps; a block of another package has a ``step`` of its own instead."""

WIRES = (
    Parameter(
        'excitatory',
        'string[]',
        [],
        'input signals that enter with sign +1',
        most=NAMES,
        settable=UNCONFIGURED,
    ),
    Parameter(
        'inhibitory',
        'string[]',
        [],
        'input signals that enter with sign -1',
        most=NAMES,
        settable=UNCONFIGURED,
    ),
    Parameter('output', 'string', '', 'the signal that the block publishes', settable=UNCONFIGURED),
)
"""What a block listens to and publishes."""

FORESIGHT = (
    Parameter(
        'predict',
        'bool',
        False,
        'observe the plant in the past and predict, for loops with delay',
        settable=UNCONFIGURED,
    ),
    Parameter(
        'plant_k', 'double', 1.0, 'conductance of the plant as predict takes it to be', low=0.0
    ),
    Parameter(
        'plant_tau',
        'double',
        1 / 11,
        'time constant of the plant as predict takes it to be',
        low=0.0,
        open_low=True,
    ),
    Parameter(
        'plant_inputs',
        'string[]',
        [STIMULUS_OUTPUT],
        'measured signals that excite the plant, which predict hears too',
        settable=UNCONFIGURED,
    ),
    Parameter(
        'coding',
        'string',
        'samples',
        'how u travels: every sample, or two spikes a period (needs predict)',
        choices=('samples', 'spikes'),
        settable=UNCONFIGURED,
    ),
)
"""How a controller looks ahead."""

PACE = (
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
    Parameter(
        'input_limit',
        'double',
        100.0,
        'samples of larger magnitude are dropped, counted and reported (real time)',
        low=0.0,
        open_low=True,
        settable=ACTIVE,
    ),
    Parameter(
        'output_limit',
        'double',
        0.0,
        'magnitude at which the output is cut off and reported; 0: none',
        low=0.0,
        settable=ACTIVE,
    ),
    Parameter(
        'recover',
        'double',
        0.0,
        'seconds after a fault after which the node starts again from x0; 0: never',
        low=0.0,
        high=3600.0,
        settable=ACTIVE,
    ),
    Parameter(
        'lead',
        'double',
        0.0,
        'model time by which u is ahead of its time stamp; of a plant and of a controller that '
        'predicts, the same',
        low=0.0,
        high=1000.0,
        settable=UNCONFIGURED,
    ),
    LOCKSTEP,
    LOCKSTEP_TIMEOUT,
    Parameter(
        'send_on_delta',
        'double',
        0.0,
        'a sample goes out when it differs from the last one sent by so much, and every half '
        'input_timeout; 0: every sample',
        low=0.0,
        settable=UNCONFIGURED,
    ),
    Parameter(
        'held_inputs',
        'string[]',
        [],
        'inputs that are sent on delta: held between samples, and gaps in them are none',
        settable=UNCONFIGURED,
    ),
    Parameter(
        'spike_inputs',
        'string[]',
        [],
        'SIGNAL:TAU for each input that comes as spikes; TAU is that of the generator that makes '
        'a signal of them',
        settable=UNCONFIGURED,
    ),
    Parameter(
        'lockstep_delays',
        'string[]',
        [],
        'in lockstep: SIGNAL:T for each input that is late, by T of model time',
        settable=UNCONFIGURED,
    ),
    PRECISION,
    LATE_WARN,
    LATE_ERROR,
    Parameter(
        'delay_margin',
        'double',
        0.25,
        'delay per link that the loop tolerates with the linear hold, model time (eventreg margin)',
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
"""When a block steps, and what it reports of it."""
