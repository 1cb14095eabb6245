# SPDX-License-Identifier: Apache-2.0
"""Figures of controllers that learn their generator, and of the gain against the delay."""

from __future__ import annotations

import numpy as np

from ..plots.figures import Curve, Layout, Panel, curves, series
from ..plots.style import BLACK, BLUE, DASHED, DOTTED, GREY, ORANGE, SKY, VERMILLION, Look
from ..simulation.trajectory import Array
from .figure import Case, Columns, Derived, PaperFigure
from .identified import IdentifiedCase, IdentifiedFigure
from .swept import SweptCase, SweptFigure, rejected

BEYOND = 'Beyond the paper: docs/learning.md.'
LEARNS = 'controller.adapt:=0.04'
SLOW = ('controller.k:=1', 'exosystem.tau:=0.05')
TRUE = Look(GREY, DOTTED, 1.4)


def one_over(column: str) -> Derived:
    """Return the function that takes 1 / tau."""
    return lambda columns: np.asarray(1.0 / columns[column])


def always(value: float, like: str) -> Derived:
    """Return the function that gives a constant."""
    return lambda columns: np.full(len(columns[like]), value)


LEARNING = PaperFigure(
    'learning',
    BEYOND,
    'The generator has 1/20 and both controllers start at 1/12 with k = 1. The fixed one lets '
    'every event of w through. The adaptive one knows the time constant after two periods: y goes '
    'to 0 while w spikes on.',
    {'fixed': Case('exact', SLOW), 'adaptive': Case('exact', (*SLOW, LEARNS))},
    400.0,
    Layout(
        (
            Panel('$y$, fixed', (Curve('fixed.y', '', Look(VERMILLION)),), threshold=True),
            Panel('$y$, adaptive', (Curve('adaptive.y', '', Look(BLACK)),), threshold=True),
            Panel(
                r'$1/\tau_\eta$',
                (Curve('true', r'$1/\tau_w$', TRUE), Curve('learned', 'learned', Look(BLUE))),
            ),
        ),
        events=(
            Curve('fixed.w', '$w$', Look(VERMILLION)),
            Curve('fixed.y', '$y$, fixed', Look(VERMILLION)),
            Curve('adaptive.y', '$y$, adaptive', Look(BLACK)),
        ),
    ),
    {'learned': one_over('adaptive.u/tau'), 'true': always(20.0, 'fixed.y')},
)

SEPARATING = PaperFigure(
    'separating',
    BEYOND,
    'Two unknown generators, and a bank of two adaptive controllers that hear the same '
    'y. Each finds a generator of its own: u goes to w, u_2 to w_2, and y, which responds to both, '
    'to 0.',
    {'': Case('unknown')},
    900.0,
    Layout(
        (
            Panel('plant', curves('y'), threshold=True),
            Panel(
                r'$1/\tau_\eta$',
                (
                    Curve('true', '', TRUE),
                    Curve('true_2', '', Look(SKY, DOTTED, 2.2)),
                    Curve('learned', '$u$', Look(BLACK)),
                    Curve('learned_2', '$u_2$', Look(BLUE, DASHED)),
                ),
            ),
            Panel('$|w - u|$', (Curve('apart', '', Look(BLACK)),), log=True),
            Panel('$|w_2 - u_2|$', (Curve('apart_2', '', Look(BLUE, DASHED)),), log=True),
        ),
        events=(
            Curve('w', '$w$', Look(VERMILLION)),
            Curve('w_2', '$w_2$', Look(VERMILLION)),
            Curve('y', '$y$', Look(BLACK)),
        ),
        settle=600.0,
    ),
    {
        'learned': one_over('u/tau'),
        'learned_2': one_over('u_2/tau'),
        'true': always(12.0, 'y'),
        'true_2': always(19.0, 'y'),
        'apart': lambda columns: columns['w'] - columns['u'],
        'apart_2': lambda columns: columns['w_2'] - columns['u_2'],
    },
)

STEP, DRIFT_STEPS = 300.0, 25


def _drift() -> tuple[str, ...]:
    """Return tau_w from 1/12 to 1/24 in equal ratios, from 300 to 800 of model time."""
    return tuple(
        f'{STEP + 20.0 * i:g}:exosystem.tau:={2.0 ** (-(i + 1) / DRIFT_STEPS) / 12.0:.6f}'
        for i in range(DRIFT_STEPS)
    )


def _true_drift(columns: Columns) -> Array:
    """Return 1/tau_w over time, from the length of the columns: they end at 1000."""
    t = np.linspace(0.0, 1000.0, len(columns['drift.y']))
    steps = np.clip(np.floor((t - STEP) / 20.0) + 1.0, 0.0, DRIFT_STEPS)
    return np.asarray(12.0 * 2.0 ** (steps / DRIFT_STEPS))


TRACKING = PaperFigure(
    'tracking',
    BEYOND,
    'The generator changes while the loop runs. Above, its time constant steps from 1/12 to 1/20: '
    'one event of y, then it is learned. Below, it drifts by a factor of two within 500: no event.',
    {
        'step': Case('exact', ('controller.k:=1', LEARNS), ('300:exosystem.tau:=0.05',)),
        'drift': Case('exact', ('controller.k:=1', LEARNS), _drift()),
    },
    1000.0,
    Layout(
        (
            Panel('$y$, step', (Curve('step.y', '', Look(BLACK)),), threshold=True),
            Panel(
                r'$1/\tau$, step',
                (
                    Curve('step.true', r'$1/\tau_w$', TRUE),
                    Curve('step.learned', r'$1/\tau_\eta$', Look(BLUE)),
                ),
            ),
            Panel('$y$, drift', (Curve('drift.y', '', Look(BLACK)),), threshold=True),
            Panel(
                r'$1/\tau$, drift',
                (
                    Curve('drift.true', r'$1/\tau_w$', TRUE),
                    Curve('drift.learned', r'$1/\tau_\eta$', Look(BLUE)),
                ),
            ),
        ),
    ),
    {
        'step.learned': one_over('step.u/tau'),
        'drift.learned': one_over('drift.u/tau'),
        'step.true': lambda columns: np.where(
            np.linspace(0.0, 1000.0, len(columns['step.y'])) < STEP, 12.0, 20.0
        ),
        'drift.true': _true_drift,
    },
)


def backwards(column: str) -> Derived:
    """Return the function that turns a column round, since 1/tau falls where tau rises."""
    return lambda columns: columns[column][::-1]


TONGUES = {
    'weak': (r'fixed, $k = 0.7$', ('controller.k:=0.7',)),
    'fixed': ('fixed, $k = 1$', ('controller.k:=1',)),
    'adaptive': ('adaptive, $k = 1$', ('controller.k:=1', LEARNS)),
}
TAUS = 'exosystem.tau:=1/30..1/5/91log'

TONGUE = SweptFigure(
    'tongue',
    BEYOND,
    'Which generators a controller with tau = 1/12 rejects. Above: events of y from 300 to 900 '
    'that nothing asks for. Below: the largest |y|. The fixed controller has a tongue around its '
    'own time constant, narrower for a smaller k; the adaptive one rejects them all.',
    {
        name: SweptCase('exact', (*given, TAUS), 900.0, 300.0)
        for name, (_, given) in TONGUES.items()
    },
    lambda columns: np.asarray(1.0 / columns['fixed.exosystem.tau'])[::-1],
    Layout(
        (
            Panel(
                'spurious events',
                series([f'{name}.spurious' for name in TONGUES], [x for x, _ in TONGUES.values()]),
            ),
            Panel('largest $|y|$', series([f'{name}.residual' for name in TONGUES]), log=True),
        ),
        along=r'$1/\tau_w$',
        log=True,
    ),
    {
        **{f'{name}.spurious': backwards(f'{name}.spurious') for name in TONGUES},
        **{f'{name}.residual': backwards(f'{name}.residual_max_abs') for name in TONGUES},
    },
)

GAINS = 'controller.k:=0.5..8/17log'
HELD = ('/**.hold:=zero', '/**.rate:=500')
GENERATORS = 'exosystem.tau:=1/60..1/3/45log'
OWN = 1 / 12


def _by_gain(case: str, inner: str, columns: Columns) -> tuple[Array, Array, Array]:
    """Return the gains (n,), the values of the other parameter (m,), and what was rejected (n, m).

    The other parameter increases.
    """
    k, values = np.unique(columns[f'{case}.controller.k']), np.unique(columns[f'{case}.{inner}'])
    found = np.zeros((len(k), len(values)), dtype=bool)
    rows = np.searchsorted(k, columns[f'{case}.controller.k'])
    found[rows, np.searchsorted(values, columns[f'{case}.{inner}'])] = rejected(case, columns)
    return k, values, found


def margin(columns: Columns) -> Array:
    """Return the largest delay up to which every one is rejected, for each gain."""
    _, delays, found = _by_gain('delay', 'links.delay', columns)
    count = np.logical_and.accumulate(found, axis=1).sum(axis=1)
    return np.where(count, delays[np.maximum(count - 1, 0)], 0.0)


def tolerated(case: str, up: bool) -> Derived:
    """Return the function that gives the end of the 1/tau_w around 12 that are all rejected."""

    def end(columns: Columns) -> Array:
        _, taus, found = _by_gain(case, 'exosystem.tau', columns)
        own = int(np.searchsorted(taus, OWN))
        part = found[:, own::-1] if up else found[:, own:]
        count = np.logical_and.accumulate(part, axis=1).sum(axis=1)
        last = own - count + 1 if up else own + count - 1
        return np.asarray(1.0 / taus[np.clip(last, 0, len(taus) - 1)])

    return end


WHICH_K = SweptFigure(
    'which_k',
    'Beyond the paper: docs/which_k.md.',
    'What the gain k buys and costs. Above: the delay per link that is tolerated with the exact '
    'tau (zero hold) falls like 0.8/k. Below: the generators that a controller with tau = 1/12 '
    'rejects lie between two lines, dashed for the fixed one, solid for the adaptive one. Fixed, '
    'it needs k = 1.5; adaptive, a small k is enough, and the delay twice as long.',
    {
        'delay': SweptCase('exact', (*HELD, GAINS, 'links.delay:=0.02..1.2/60'), 400.0, 100.0),
        'fixed': SweptCase('exact', (GAINS, GENERATORS), 900.0, 300.0),
        'adaptive': SweptCase('exact', (LEARNS, GAINS, GENERATORS), 900.0, 300.0),
    },
    lambda columns: _by_gain('delay', 'links.delay', columns)[0],
    Layout(
        (
            Panel(
                'delay margin',
                (
                    Curve('margin', 'measured', Look(BLACK)),
                    Curve('rule', '$0.8/k$', Look(GREY, DOTTED, 1.4)),
                ),
            ),
            Panel(
                r'$1/\tau_w$',
                (
                    Curve('fixed.low', 'fixed', Look(VERMILLION, DASHED)),
                    Curve('fixed.high', '', Look(ORANGE, DASHED, 2.2)),
                    Curve('adaptive.low', 'adaptive', Look(BLUE)),
                    Curve('adaptive.high', '', Look(SKY, '-', 2.2)),
                ),
                limits=(0.0, 65.0),
            ),
        ),
        along='$k$',
        log=True,
    ),
    {
        'margin': margin,
        'rule': lambda columns: 0.8 / _by_gain('delay', 'links.delay', columns)[0],
        'fixed.low': tolerated('fixed', up=False),
        'fixed.high': tolerated('fixed', up=True),
        'adaptive.low': tolerated('adaptive', up=False),
        'adaptive.high': tolerated('adaptive', up=True),
    },
)

LEARNED = (LEARNING, SEPARATING, TRACKING)
SWEPT = (TONGUE, WHICH_K)

IDENTIFIED = IdentifiedFigure(
    'identification',
    'Beyond the paper: docs/unknown.md.',
    'How well tau is identified from a noisy recording of 200 units of model time: the median of '
    '|d ln tau| over white noise on every sample, of five draws that are the same at every level. '
    'From w, from y of the plant without control, and from y and u of a running loop '
    '(`mismatch`): each error is in proportion to the noise.',
    {
        'w': IdentifiedCase('uncontrolled', 'w'),
        'y': IdentifiedCase('uncontrolled', 'y'),
        'loop': IdentifiedCase('mismatch', 'y'),
    },
    Layout(
        (
            Panel(
                r'$|\Delta \ln \tau|$',
                series(['w', 'y', 'loop'], ['from w', 'from y', 'from y and u']),
                log=True,
            ),
        ),
        along='standard deviation of the noise',
        log=True,
    ),
)
