# SPDX-License-Identifier: Apache-2.0
"""Everything that the event trains of one run say, for tables, pages and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..scenario.criteria import Criteria
from .events import rises
from .noise import Noise, examine
from .rejection import outcomes
from .signal import Array, Signals, with_events
from .subject import JudgedPlant
from .trains import Coincidence, Phase, Train, coincidence, describe, phase, settling_time

PAPERS = (JudgedPlant('y', 'y_r', ('w',), ('u',)),)
"""The paper's loop: one plant."""


@dataclass(frozen=True)
class PlantTrains:
    """How the trains of one plant go together.

    ``answer`` matches y with y_r, ``following`` is the phase of u between the events of w; None
    where one of the two is not there, or there are several. ``settling`` is the model time of the
    last unwanted event, 0 without any, None where too few events of w followed it to know.
    """

    answer: Coincidence | None = None
    following: Phase | None = None
    settling: float | None = None


@dataclass(frozen=True)
class TrainReport:
    """The trains of a run: each signal's figures and noise, and how they go together.

    ``plants`` are by output; ``answer``, ``following`` and ``settling`` are those of the first.
    """

    trains: Mapping[str, Train]
    noise: Mapping[str, Noise]
    plants: Mapping[str, PlantTrains]

    @property
    def first(self) -> PlantTrains:
        """How the trains of the first plant go together."""
        return next(iter(self.plants.values()), PlantTrains())

    @property
    def answer(self) -> Coincidence | None:
        """How y answers y_r."""
        return self.first.answer

    @property
    def following(self) -> Phase | None:
        """The phase of u between the events of w."""
        return self.first.following

    @property
    def settling(self) -> float | None:
        """The model time of the last unwanted event."""
        return self.first.settling


def train_report(
    signals: Signals, criteria: Criteria | None = None, plants: Sequence[JudgedPlant] = PAPERS
) -> TrainReport:
    """Return what the trains of ``signals`` say; each is (t, values), t in model time.

    The figures are of the events from ``settle`` on, the settling time of all.
    """
    limits = criteria or Criteria()
    events, trains, noise = {}, {}, {}
    for name in with_events(signals):
        t, x = signals[name]
        found = rises(t, x, limits.threshold, limits.reset)
        kept = found.events(limits.refractory, limits.min_width)
        events[name] = found.start[kept]
        stop = float(t[-1]) if len(t) else limits.settle
        trains[name] = describe(events[name], limits.settle, stop, found.width[kept])
        noise[name] = examine(t, x, limits)
    together = {plant.output: _together(plant, events, limits) for plant in plants}
    return TrainReport(trains, noise, together)


def _together(plant: JudgedPlant, events: Mapping[str, Array], limits: Criteria) -> PlantTrains:
    after = {name: times[times >= limits.settle] for name, times in events.items()}
    y, y_r = plant.output, plant.reference or ''
    wrong = outcomes(_all((y,), events), _all((y_r,), events), 0.0, limits.window)
    one = len(plant.disturbances) == len(plant.controls) == 1
    followed = {*plant.disturbances, *plant.controls} <= after.keys()
    return PlantTrains(
        answer=coincidence(after[y], after[y_r], limits.window)
        if {y, y_r} <= after.keys()
        else None,
        following=phase(after[plant.controls[0]], after[plant.disturbances[0]])
        if one and followed
        else None,
        settling=settling_time(
            sorted(wrong.spurious + wrong.missed), _all(plant.disturbances, events)
        ),
    )


def _all(names: Sequence[str], events: Mapping[str, Array]) -> list[float]:
    """Return the events of all ``names`` together, in order."""
    found = [events[name] for name in names if name in events]
    times: list[float] = np.sort(np.concatenate(found)).tolist() if found else []
    return times
