# SPDX-License-Identifier: Apache-2.0
"""What was changed while a run went on: it is not the run that its scenario describes any more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..bags.changes import as_set
from ..bags.recording import Recording
from ..scenario.interventions import Intervention

STARTING = 1.0
"""Seconds after the first sample in which nodes that are configured and activated just start."""

OURS = ('start_time', 'use_sim_time')
"""Parameters by which a run is brought about, not changed."""


class Change(NamedTuple):
    """A parameter set (``k:=3``) or a node switched (``deactivate``), ``at`` in model time."""

    at: float
    node: str
    what: str


def changes_of(recording: Recording, time_scale: float) -> tuple[Change, ...]:
    """Return what was changed during a recording, except the start of its nodes."""
    found: list[Change] = []
    switched: set[str] = set()
    for stamp, node, what in recording.changes:
        seconds = (stamp - recording.start) / 1e9
        starts = what in ('configure', 'activate')
        starting = starts and seconds <= STARTING and node not in switched
        switched |= set() if starts or ':=' in what else {node}
        if not starting and what.partition(':=')[0] not in OURS:
            found.append(Change((stamp - recording.start) * time_scale / 1e9, node, what))
    return tuple(found)


def changes_asked(interventions: Sequence[Intervention]) -> tuple[Change, ...]:
    """Return what a simulation changes: interventions whose times are in model time."""
    return tuple(
        Change(i.at, i.node, f'{i.parameter}:={as_set(i.value)}' if i.parameter else i.action)
        for i in interventions
    )


def named(change: Change) -> str:
    """Return what was changed as one types it: ``controller.k:=3``, ``plant: deactivate``."""
    return f'{change.node}{"." if ":=" in change.what else ": "}{change.what}'


def words(changes: Sequence[Change], most: int = 6) -> str:
    """Return one line on changes; empty without any."""
    if not changes:
        return ''
    shown = [f'{named(change)} at {change.at:.1f}' for change in changes]
    more = len(shown) - most
    return 'changed: ' + ', '.join(shown[:most]) + (f' and {more} more' if more > 0 else '')
