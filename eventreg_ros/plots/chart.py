# SPDX-License-Identifier: Apache-2.0
"""What a chart of the page shows, before it is drawn: panels over one span of model time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..analysis.signal import Span
from .axis import Axis
from .decimate import Array


class Line(NamedTuple):
    """A line in a panel: its name, its look (a class of the page's style) and its points.

    ``t`` in model time and ``x``, both of shape (n,); broken where ``x`` is NaN.
    """

    name: str
    look: str
    t: Array
    x: Array
    points: bool = False
    """Whether each sample is a point of its own, where there is room for that."""


class Events(NamedTuple):
    """Events as open circles at one height."""

    look: str
    times: Sequence[float]
    level: float


@dataclass(frozen=True)
class Panel:
    """Lines over one axis; ``level`` is marked and named, ``height`` in pixels.

    A panel with a ``title`` shows it in place of the names of its lines.
    """

    lines: Sequence[Line]
    axis: Axis
    level: float | None = None
    level_name: str = 'threshold'
    events: Sequence[Events] = ()
    height: int = 110
    title: str = ''


class Fault(NamedTuple):
    """Events that should not be, or are missing: a cross or a triangle."""

    kind: str
    times: Sequence[float]


class Row(NamedTuple):
    """The events of one signal as ticks, and which of them are faults."""

    name: str
    look: str
    times: Sequence[float]
    faults: Sequence[Fault] = ()


@dataclass(frozen=True)
class Raster:
    """Rows of events, with a title where there is something else above them."""

    rows: Sequence[Row]
    title: str = ''


class Key(NamedTuple):
    """What lines of one look are, in all panels."""

    look: str
    words: str


class Mark(NamedTuple):
    """A vertical line at ``at``, numbered, and what it means."""

    at: float
    words: str


@dataclass(frozen=True)
class Chart:
    """Panels over one span of model time, one below the other.

    Shaded is what is ``uncounted``, hatched what is ``unseen``, and ``marks`` are lines.
    """

    title: str
    span: Span
    panels: Sequence[Panel | Raster]
    uncounted: Sequence[Span] = ()
    unseen: Sequence[Span] = ()
    marks: Sequence[Mark] = ()
    keys: Sequence[Key] = ()
    at: float | None = None
    """The instant that the chart is about, marked by a line of its own."""
