# SPDX-License-Identifier: Apache-2.0
"""Figures of what the paper argues in words."""

from __future__ import annotations

from ..plots.figures import Curve, Layout, Panel, curves, series
from ..plots.style import BLUE, DASHED, LOOKS, SKY, Look
from ..scenario.criteria import SETTLE
from .figure import Case, PaperFigure, difference, starts, total
from .figures_in_paper import LOOP

UNCONTROLLED = PaperFigure(
    'uncontrolled',
    'section on the nonlinear motif: if u = 0, each event provokes a corresponding event.',
    'Without a controller every event of w becomes an event of y.',
    {'': Case('uncontrolled')},
    400.0,
    Layout(
        (Panel('plant', curves('y'), threshold=True), Panel('exosystem', curves('w'))),
        events=curves('w', 'y'),
        settle=SETTLE,
    ),
)

SINGLE_NEURON = PaperFigure(
    'single_neuron',
    'discussion: could a single-neuron internal model suffice? (eq. single_neuron_candidate)',
    'The controller is one neuron. If y were 0 it would come to rest, and u would be 0 and not w: '
    'so y cannot vanish. u follows w only in part, and every event of w still becomes one of y.',
    {'': Case('single_neuron')},
    400.0,
    LOOP,
)

FOLLOWER = (
    'exosystem.model:=neuron',
    'exosystem.k:=0.0',
    'exosystem.x0:=[1.0, 0.0]',
    'exosystem.output:=z',
    "plant.excitatory:=['z']",
    'plant.k:=1.5',
    'plant.tau:=0.08333333333333333',
)
FOLLOWER_STARTS = (
    {'plant': '[0.0, 0.0]'},
    {'plant': '[-2.0, 0.5]'},
    {'plant': '[2.0, -1.5]'},
)

PASS_ALL = PaperFigure(
    'pass_all',
    'discussion, F2: the pass-all property.',
    'z comes from an uncoupled neuron (k = 0), so it belongs to the class F. A neuron with k > 1 '
    'and the same tau that is driven by z follows it, events and all, from every initial '
    'state: the error goes to 0.',
    starts('uncontrolled', 'start', FOLLOWER_STARTS, *FOLLOWER),
    150.0,
    Layout(
        (
            Panel(
                '$y$ and $z$',
                (
                    Curve('start_1.z', '$z$', Look(SKY, width=3.0)),
                    *series([f'start_{i}.y' for i in (1, 2, 3)], ('$y$, 1', '2', '3')),
                ),
                'three initial states',
            ),
            Panel('$|y - z|$', series([f'error_{i}' for i in (1, 2, 3)]), log=True),
        ),
        events=(
            Curve('start_1.z', '$z$', Look(SKY)),
            *series([f'start_{i}.y' for i in (1, 2, 3)], '123'),
        ),
    ),
    {f'error_{i}': difference(f'start_{i}.y', f'start_{i}.z') for i in (1, 2, 3)},
    {'exosystem': '_z', 'plant': ''},
)

LINEAR = PaperFigure(
    'linear',
    'section on the linear motif.',
    'The linear loop that the neurons imitate: the controller contains the harmonic oscillator, u '
    'comes to equal w, and y goes to 0 exponentially.',
    {'': Case('linear')},
    60.0,
    Layout(
        (
            Panel('plant', curves('y')),
            Panel('oscillators', curves('w', 'u')),
            Panel('$|y|$', (Curve('y', '', LOOKS['y']),), log=True, limits=(1e-8, 1e1)),
        )
    ),
)

PAIR = (
    'exosystem.model:=neuron',
    "exosystem.inhibitory:=['y']",
    'plant.excitatory:=[]',
    "plant.inhibitory:=['w']",
    'plant.tau:=0.08333333333333333',
)
"""The oscillator of eq. s.w as two neurons that inhibit each other: w is y_w1 and y is y_w2."""

PAIR_STARTS = (
    {'exosystem': '[1.0, 0.0]', 'plant': '[0.5, 0.2]'},
    {'exosystem': '[1.5, 0.5]', 'plant': '[-1.0, 0.5]'},
    {'exosystem': '[-2.0, 0.5]', 'plant': '[-0.5, -1.0]'},
    {'exosystem': '[1.0, 0.0]', 'plant': '[1.0, 0.0]'},
)
COUPLINGS = {'strong': '1.0', 'weak': '0.1'}
SUM = '$|y_{w_1} + y_{w_2}|$'


def _sums(coupling: str) -> Panel:
    sums = [f'{coupling}_{i}.sum' for i in range(1, 5)]
    return Panel(SUM, series(sums, ('start 1', '2', '3', '4')), log=True, limits=(1e-8, 1e1))


ANTIPHASE = PaperFigure(
    'antiphase',
    'section on the nonlinear motif: Lemma 2.',
    'The two neurons of the exosystem end in antiphase (top). Middle: for k_w > 1/2 their sum '
    'vanishes from every initial state, as Lemma 2 says; also where they start alike (dotted), but '
    'then both come to rest. Bottom: below 1/2 the lemma is silent, and here the sum does not '
    'vanish from every initial state: two neurons that start alike oscillate alike. From the other '
    'three it vanishes too, only later.',
    {
        name: case
        for coupling, k in COUPLINGS.items()
        for name, case in starts(
            'uncontrolled', coupling, PAIR_STARTS, *PAIR, f'exosystem.k:={k}', f'plant.k:={k}'
        ).items()
    },
    200.0,
    Layout(
        (
            Panel(
                'outputs',
                (
                    Curve('strong_1.w', '$y_{w_1}$', LOOKS['w']),
                    Curve('strong_1.y', '$y_{w_2}$', Look(BLUE, DASHED)),
                ),
            ),
            *map(_sums, COUPLINGS),
        )
    ),
    {
        f'{coupling}_{i}.sum': total(f'{coupling}_{i}.w', f'{coupling}_{i}.y')
        for coupling in COUPLINGS
        for i in range(1, 5)
    },
    {'exosystem': '_w', 'plant': '_w'},
    per_panel=True,
)

ARGUED = (UNCONTROLLED, SINGLE_NEURON, PASS_ALL, LINEAR, ANTIPHASE)
