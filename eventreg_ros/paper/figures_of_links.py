# SPDX-License-Identifier: Apache-2.0
"""Figures of links that are late, and of links that carry few messages."""

from __future__ import annotations

import numpy as np

from ..plots.figures import Curve, Layout, Panel, series
from ..plots.style import BLACK, BLUE, DASHED, DOTTED, GREY, Look
from ..simulation.trajectory import Array
from .figure import Case, Columns, Derived, PaperFigure
from .figures_of_learning import LEARNS
from .swept import SweptCase, SweptFigure

PREDICTS = 'controller.predict:=true'
FARTHEST = 8
"""The longest delay of the figure, which all its leads cover; model time."""

DELAYS = f'links.delay:=0.1..{FARTHEST}/14log'
LEADS = (PREDICTS, f'/**.lead:={FARTHEST}')

TO_AND_FRO = ('y', 'u')

LATE = {
    'exact': ('paper', SweptCase('exact', (DELAYS,), 400.0, 100.0, TO_AND_FRO)),
    'predicted': (
        'predict',
        SweptCase('exact', (*LEADS, DELAYS), 400.0, 100.0, TO_AND_FRO),
    ),
    'wrong': (
        'wrong',
        SweptCase('mismatch', (PREDICTS, '/**.lead:=0.8', DELAYS), 400.0, 100.0, TO_AND_FRO),
    ),
    'learned': (
        'learned',
        SweptCase('mismatch', (*LEADS, LEARNS, DELAYS), 600.0, 300.0, TO_AND_FRO),
    ),
}


def column(name: str) -> Derived:
    """Return the function that takes a column as it is."""
    return lambda columns: columns[name]


DELAY_MARGIN = SweptFigure(
    'delay_margin',
    'Beyond the paper: docs/slow_network.md.',
    'How much delay each of the links of y and u may have. Above: events of y that nothing asks '
    'for. Below: the largest |y|. The loop of the paper ends at 0.4. With observer and prediction '
    'it goes on, as far as is drawn and further, if the internal model is exact; a wrong one '
    '(`mismatch`, lead 0.8) ends at 0.8, and one that learns goes as far.',
    {name: case for name, (_, case) in LATE.items()},
    column('exact.links.delay'),
    Layout(
        (
            Panel(
                'spurious events',
                series(
                    [f'{name}.spurious' for name in LATE], [label for label, _ in LATE.values()]
                ),
            ),
            Panel('largest $|y|$', series([f'{name}.residual' for name in LATE]), log=True),
        ),
        along='delay of y and of u',
        log=True,
    ),
    {
        **{f'{name}.spurious': column(f'{name}.spurious') for name in LATE},
        **{f'{name}.residual': column(f'{name}.residual_max_abs') for name in LATE},
    },
)

BEAT = 50
"""Steps between two heartbeats at the default rate and timeout."""


def on_delta(name: str) -> Derived:
    """Return the function that is 1 where a message was sent of a column that is held between."""

    def sent(columns: Columns) -> Array:
        x = columns[name]
        changed = np.flatnonzero(np.diff(x, prepend=np.nan) != 0.0)
        since = (
            np.arange(len(x)) - changed[np.searchsorted(changed, np.arange(len(x)), 'right') - 1]
        )
        return np.asarray(since % BEAT == 0, dtype=np.float64)

    return sent


def spikes(name: str) -> Derived:
    """Return the function that is 1 where a column that is made of spikes passes 0."""

    def sent(columns: Columns) -> Array:
        sign = np.sign(columns[name])
        return np.asarray((sign != 0.0) & (np.diff(sign, prepend=0.0) != 0.0), dtype=np.float64)

    return sent


CODES = {
    'samples': ('samples', Look(GREY, DOTTED, 1.4), ()),
    'delta': ('on delta', Look(BLUE, DASHED), ('controller.send_on_delta:=0.1',)),
    'spikes': ('spikes', Look(BLACK), (PREDICTS, 'controller.coding:=spikes')),
}

MESSAGES = PaperFigure(
    'messages',
    'Beyond the paper: docs/narrow_link.md.',
    'Three ways to send u. Above: u as the plant makes it of the messages, 0 until the first '
    'spike. Below: y, which w moves until then. At the bottom the messages: as samples 20 a unit '
    'of time, on delta 0.1 two, as spikes two a period.',
    {name: Case('exact', given, sampled=True) for name, (_, _, given) in CODES.items()},
    75.0,
    Layout(
        (
            Panel('$u$', tuple(Curve(f'{n}.u', x, look) for n, (x, look, _) in CODES.items())),
            Panel(
                '$y$',
                tuple(Curve(f'{n}.y', '', look) for n, (_, look, _) in CODES.items()),
                threshold=True,
            ),
        ),
        events=tuple(Curve(f'{n}.sent', x, look) for n, (x, look, _) in CODES.items()),
        raster='sent',
    ),
    {
        'samples.sent': lambda columns: np.ones(len(columns['samples.u'])),
        'delta.sent': on_delta('delta.u'),
        'spikes.sent': spikes('spikes.u'),
    },
)
