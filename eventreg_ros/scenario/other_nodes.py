# SPDX-License-Identifier: Apache-2.0
"""The table of parameters, its other part: the nodes that are no blocks; see :mod:`.table`."""

from __future__ import annotations

from ..models.roles import SIGNALS, STIMULUS_OUTPUT
from ..runtime.relay import ORDERS
from ..simulation.stimulus import WAVEFORMS
from .criteria import BLIND, RESET, SETTLE, THRESHOLD, WINDOW
from .parameter import ACTIVE, START, UNCONFIGURED, Parameter
from .table import (
    AUTOSTART,
    LATE_ERROR,
    LATE_WARN,
    LOCKSTEP,
    LOCKSTEP_TIMEOUT,
    MAX_CATCH_UP,
    NAMES,
    PRECISION,
    RATE,
    START_TIME,
    TIME_SCALE,
)

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
