"""Everything that the event trains of one run say, for tables, pages and JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..scenario.criteria import Criteria
from .events import rises
from .noise import Noise, examine
from .rejection import outcomes
from .signal import Signals, with_events
from .trains import Coincidence, Phase, Train, coincidence, describe, phase, settling_time


@dataclass(frozen=True)
class TrainReport:
    """The trains of a run: each signal's figures and noise, and how they go together.

    ``answer`` matches y with y_r, ``following`` is the phase of u between the events of w; None
    where one of the two is not there. ``settling`` is the model time of the last unwanted event, 0
    without any, None where too few events of w followed it to know.
    """

    trains: Mapping[str, Train]
    noise: Mapping[str, Noise]
    answer: Coincidence | None
    following: Phase | None
    settling: float | None


def train_report(signals: Signals, criteria: Criteria | None = None) -> TrainReport:
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
    y, y_r, w = (events[name].tolist() if name in events else [] for name in ('y', 'y_r', 'w'))
    wrong = outcomes(y, y_r, 0.0, limits.window)
    after = {name: times[times >= limits.settle] for name, times in events.items()}
    return TrainReport(
        trains=trains,
        noise=noise,
        answer=coincidence(after['y'], after['y_r'], limits.window)
        if {'y', 'y_r'} <= after.keys()
        else None,
        following=phase(after['u'], after['w']) if {'u', 'w'} <= after.keys() else None,
        settling=settling_time(sorted(wrong.spurious + wrong.missed), w),
    )
