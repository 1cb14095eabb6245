# SPDX-License-Identifier: Apache-2.0
"""The four figures that the paper shows, at the parameters of their captions."""

from __future__ import annotations

from ..plots.figures import Curve, Layout, Panel, curves, series
from ..plots.style import DASHED, ORANGE, PURPLE, Look
from ..scenario.criteria import SETTLE
from .figure import Case, PaperFigure, spread, starts

LOOP = Layout(
    (
        Panel('plant', curves('y'), threshold=True),
        Panel('oscillators', curves('w', 'u')),
    ),
    events=curves('w', 'y', 'u'),
    settle=SETTLE,
)
"""Plant above, disturbance and control action below: how the paper shows a controlled loop."""

STARTS = (
    {'plant': '[0.5, 0.0]', 'controller': '[0.5, 0.0, -0.5, 0.0]'},
    {'plant': '[-1.5, 0.5]', 'controller': '[-1.0, 0.0, 0.5, 0.5]'},
    {'plant': '[1.5, -0.5]', 'controller': '[0.0, 1.0, 0.0, -1.0]'},
    {'plant': '[0.0, 0.0]', 'controller': '[0.0, 0.0, 0.0, 0.0]'},
)
QUIET = [f'quiet_{i}.y' for i in range(1, 5)]
DRIVEN = [f'driven_{i}.y' for i in range(1, 5)]

NOT_CONTRACTIVE = PaperFigure(
    'not_contractive',
    'the figure in the discussion of closed-loop contraction.',
    'Plant and controller start from four initial states. Without w (top) three of them end on the '
    'same orbit in different phases and the fourth rests at 0: the loop is not contractive. '
    'With w (middle) all four come together, at y = 0: the input induces contraction. Bottom: the '
    'largest difference of y between any two of the four.',
    {**starts('quiescent', 'quiet', STARTS), **starts('exact', 'driven', STARTS)},
    80.0,
    Layout(
        (
            Panel('$y$', series(QUIET, '1234'), '$w = 0$'),
            Panel('$y$', series(DRIVEN), r'$w \neq 0$'),
            Panel(
                'spread of $y$',
                (
                    Curve('quiet_spread', '$w = 0$', Look(ORANGE, DASHED)),
                    Curve('driven_spread', r'$w \neq 0$', Look(PURPLE)),
                ),
                log=True,
            ),
        )
    ),
    {'quiet_spread': spread(*QUIET), 'driven_spread': spread(*DRIVEN)},
)

EXACT = PaperFigure(
    'exact',
    'the figure of exact regulation in the section on the nonlinear motif.',
    'The controller is a copy of the exosystem: u comes to equal w, spikes and all, and y goes to '
    '0. w and u have events, y has none.',
    {'': Case('exact')},
    400.0,
    LOOP,
)

MISMATCH = PaperFigure(
    'mismatch',
    'the figure of a mismatched controller in the section on the nonlinear motif.',
    'The controller is not a copy of the exosystem: u follows w with a small error and y does not '
    'vanish, but it stays far below the threshold of an event. The events are rejected, the '
    'trajectory is not.',
    {'': Case('mismatch')},
    400.0,
    LOOP,
)

OPEN = PaperFigure(
    'open',
    'the figure in the extension to open systems.',
    'The pulses v ask the plant for events; the disturbance w must add none. Internal model and '
    'reference are both wrong, so y is not y_r and u is not w; yet y has its events where the '
    'reference has them, and no other.',
    {'': Case('open')},
    400.0,
    Layout(
        (
            Panel('plant', curves('y', 'y_r'), threshold=True, pulses='v'),
            Panel('oscillators', curves('w', 'u'), pulses='v'),
        ),
        events=curves('v', 'y_r', 'y', 'w', 'u'),
        settle=SETTLE,
    ),
)

SHOWN = (NOT_CONTRACTIVE, EXACT, MISMATCH, OPEN)
