# SPDX-License-Identifier: Apache-2.0
"""What all pictures share: style, colour and line of each signal, marks, and how they are saved.

The colours are Okabe and Ito's, distinct for readers with any kind of colour vision; signals that
share a panel also differ in their line, for print without colour. Import matplotlib only where
something is drawn, never at the head of a module.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

BLACK, ORANGE, SKY, GREEN = '#000000', '#E69F00', '#56B4E9', '#009E73'
BLUE, VERMILLION, PURPLE, GREY = '#0072B2', '#D55E00', '#CC79A7', '#999999'

SOLID, DASHED, DASHDOT, DOTTED = '-', (0, (4.0, 1.5)), (0, (5.0, 1.5, 1.0, 1.5)), (0, (1.0, 1.2))
"""The four kinds of line, as matplotlib takes them."""


@dataclass(frozen=True)
class Look:
    """How one signal is drawn, in every picture."""

    colour: str
    line: Any = SOLID
    width: float = 1.0


LOOKS = {
    'w': Look(VERMILLION, SOLID, 1.3),
    'v': Look(PURPLE, DASHDOT),
    'y': Look(BLACK, SOLID),
    'y_r': Look(GREEN, DASHED),
    'u': Look(BLUE, DASHED),
}
"""The signals of the paper's loop."""

SERIES = (
    Look(BLACK, SOLID),
    Look(VERMILLION, DASHED),
    Look(BLUE, DASHDOT),
    Look(GREEN, DOTTED, 1.4),
)
"""Several runs of one signal, in this order."""

LABELS = {'w': '$w$', 'v': '$v$', 'y': '$y$', 'y_r': '$y_r$', 'u': '$u$'}
TIME = 'model time $t$'

STYLE = {
    'figure.dpi': 100,
    'figure.facecolor': 'white',
    'figure.constrained_layout.use': True,
    'figure.constrained_layout.h_pad': 0.02,
    'figure.constrained_layout.w_pad': 0.02,
    'font.family': 'DejaVu Sans',
    'font.size': 8.0,
    'mathtext.fontset': 'dejavusans',
    'axes.titlesize': 8.0,
    'axes.labelsize': 8.0,
    'axes.linewidth': 0.6,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.formatter.useoffset': False,
    'xtick.labelsize': 7.0,
    'ytick.labelsize': 7.0,
    'xtick.major.width': 0.6,
    'ytick.major.width': 0.6,
    'legend.fontsize': 7.0,
    'legend.frameon': False,
    'lines.linewidth': 1.0,
    'lines.dash_capstyle': 'butt',
    'pdf.fonttype': 42,
    'svg.fonttype': 'path',
    'svg.hashsalt': 'eventreg_ros',
}
"""Legible at a paper's column width (3.4 inches); fonts that come with matplotlib."""

METADATA = {
    'pdf': {'Creator': 'eventreg_ros', 'Producer': None, 'CreationDate': None},
    'svg': {'Creator': 'eventreg_ros', 'Date': None},
    'png': {'Software': None},
}
"""No dates and no versions: the same picture is the same file. Its keys are the formats."""


def look(signal: str) -> Look:
    """Return how ``signal`` is drawn; one that the paper does not know is drawn in orange."""
    return LOOKS.get(signal, Look(ORANGE))


def style(**more: Any) -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws in our style; ``more`` are further rcParams."""
    from matplotlib import rc_context

    settings: Any = {**STYLE, **more}
    return rc_context(settings)


def shade_settle(axes: Any, settle: float) -> None:
    """Shade the time before ``settle``, in which events are not counted."""
    start = axes.get_xlim()[0]
    axes.axvspan(start, settle, color=GREY, alpha=0.18, linewidth=0, zorder=0, label='settling')


def mark_threshold(axes: Any, threshold: float) -> None:
    """Draw the threshold that an event must rise through."""
    axes.axhline(
        threshold, color=GREY, linewidth=0.8, linestyle=(0, (2.0, 2.0)), zorder=0, label='threshold'
    )


def mark_events(axes: Any, rows: Sequence[tuple[str, Look, Iterable[float]]]) -> None:
    """Fill ``axes`` with one row per signal and in it a tick per event: (label, look, times).

    The first row is on top; each label stands beside its row in the colour of its signal.
    """
    for i, (_, shown, times) in enumerate(rows):
        axes.eventplot(
            list(times), lineoffsets=-i, linelengths=0.7, linewidths=1.2, colors=shown.colour
        )
    axes.set_ylim(0.6 - len(rows), 0.6)
    axes.set_yticks([-i for i in range(len(rows))], [label for label, _, _ in rows])
    axes.set_ylabel('events')
    axes.tick_params(axis='y', length=0)
    for tick, (_, shown, _) in zip(axes.get_yticklabels(), rows, strict=True):
        tick.set_color(shown.colour)


def save(figure: Any, path: Path) -> None:
    """Write ``figure`` to ``path`` in the format of its suffix: the same bytes every time.

    Raises KeyError for a suffix that is no key of :data:`METADATA`.
    """
    kind = path.suffix.removeprefix('.')
    with style():
        figure.savefig(path, format=kind, dpi=300, metadata=METADATA[kind])
