# SPDX-License-Identifier: Apache-2.0
"""The table of parameters: every parameter of every kind of node, once, as data.

Name, ROS type, default, meaning, rule, and until which state of the node it may be set. Nodes
declare these rows to ROS, offline tools check scenarios by them, docs list them.
"""

from __future__ import annotations

from ..models.catalogue import model_names
from ..models.roles import SIGNALS, STIMULUS_OUTPUT
from ..runtime.relay import ORDERS
from ..simulation.hold import HOLDS
from ..simulation.stimulus import WAVEFORMS
from .criteria import BLIND, RESET, SETTLE, THRESHOLD, WINDOW
from .parameter import ACTIVE, START, UNCONFIGURED, Parameter

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

_SIGNALS = Parameter(
    'signals',
    'string[]',
    list(SIGNALS),
    'the signals to watch',
    most=NAMES,
    settable=UNCONFIGURED,
)

OTHERS: dict[str, tuple[Parameter, ...]] = {
    'stimulus': (
        Parameter('waveform', 'string', 'constant', 'the shape of v', choices=WAVEFORMS),
        Parameter(
            'amplitude', 'double', 1.0, 'height of the waveform above offset', settable=ACTIVE
        ),
        Parameter('offset', 'double', 0.0, 'added to the waveform', settable=ACTIVE),
        Parameter('period', 'double', 50.0, 'of sine and square, model time', low=1e-9, high=1e9),
        Parameter(
            'phase',
            'double',
            0.0,
            'model time at which sine and square begin a period',
            low=-1e9,
            high=1e9,
        ),
        Parameter('onsets', 'double[]', [], 'model times at which the pulses begin'),
        Parameter(
            'width',
            'double',
            10.0,
            'length of a pulse or of the high part, model time',
            low=0.0,
            open_low=True,
        ),
        Parameter(
            'file',
            'string',
            '',
            'csv file with the columns t (model time) and v; its place counts from that of the '
            'parameter file that names it',
            settable=START,
        ),
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
        Parameter('threshold', 'double', THRESHOLD, 'an event is a rise of the signal through it'),
        Parameter('reset', 'double', RESET, 'the next event may begin at or below it'),
        Parameter('settle', 'double', SETTLE, 'model time before which no event counts', low=0.0),
        Parameter(
            'window', 'double', WINDOW, 'model time within which events of y and y_r match', low=0.0
        ),
        Parameter(
            'blind',
            'double',
            BLIND,
            'model time without a sample after which a signal counts as unseen',
            low=0.0,
            open_low=True,
        ),
        Parameter(
            'refractory',
            'double',
            0.0,
            'model time after an event in which no other begins; 0: off',
            low=0.0,
        ),
        Parameter(
            'min_width', 'double', 0.0, 'model time that an event lasts at least; 0: off', low=0.0
        ),
        Parameter(
            'scenario',
            'string',
            '',
            'parameter file that says what is judged; empty: the names of the signals',
            settable=START,
        ),
        TIME_SCALE,
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
            settable=START,
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
            settable=START,
        ),
        Parameter(
            'scenario_name',
            'string',
            '',
            'name under which the bag knows its scenario',
            settable=START,
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
            most=NAMES,
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
            'pause_at',
            'double[]',
            [],
            'simulated seconds at which the clock waits for the service resume',
        ),
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
"""The parameters of every kind of node that is no block."""
