# SPDX-License-Identifier: Apache-2.0
"""What came of one run: the verdict in numbers, and how near it was; a row of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.decision import decide, summary
from ..analysis.events import rises
from ..analysis.rejection import outcomes
from ..analysis.signal import Signal, size, together
from ..analysis.subject import Subject
from ..analysis.verdict import evidence_of, residual
from ..errors import EventregError
from ..simulation.impairment import Impairment
from ..simulation.loop import Loop
from ..simulation.noise import SILENCE, Noise
from ..simulation.sampled import simulate_sampled
from ..simulation.trajectory import Trajectory

VERDICTS = ('', 'rejected', 'not rejected', 'undecided')
"""A row holds the place of its verdict here; '' is that of a set that could not be run."""

ROW = np.dtype(
    [
        ('verdict', np.int8),
        ('disturbance_events', np.int32),
        ('preserved', np.int32),
        ('spurious', np.int32),
        ('missed', np.int32),
        ('residual_max_abs', np.float64),
        ('residual_rms', np.float64),
        ('peak', np.float64),
        ('settling', np.float64),
        ('latency', np.float64),
    ]
)
"""The numbers of a row. Beyond those of the report: ``peak``, the largest y - y_r after ``settle``
(y without a reference); ``settling``, when the last event came that y and y_r do not share;
``latency``, the mean of y - y_r over the preserved events; times are model times. With several
plants, over all of them."""

Rows = npt.NDArray[np.void]


class Case(NamedTuple):
    """One run: a loop, what happens on its links, what is judged of it, how long (model time).

    ``noise`` is on what its plants publish.
    """

    loop: Loop
    impairment: Impairment
    subject: Subject
    duration: float
    noise: Noise = SILENCE


class Outcome(NamedTuple):
    """A row, shape (), and why there is no verdict; '' where there is one."""

    row: Rows
    reason: str


class Outcomes(NamedTuple):
    """Rows, shape (n,), and by their places why some have no verdict."""

    rows: Rows
    reasons: dict[int, str]


def nothing(count: int) -> Rows:
    """Return rows without verdicts."""
    rows = np.zeros(count, dtype=ROW)
    for name in ROW.names or ():
        if rows[name].dtype.kind == 'f':
            rows[name] = np.nan
    return rows


def one_by_one(case: Case) -> Outcome:
    """Run one case as ``eventreg simulate --sampled`` does it, and judge it so."""
    try:
        run = simulate_sampled(case.loop, case.duration, case.impairment, noise=case.noise)
    except EventregError as error:
        return Outcome(nothing(1)[0], str(error))
    return Outcome(judged(run, case.subject), '')


def judged(run: Trajectory, subject: Subject) -> Rows:
    """Return the row of a run."""
    limits = subject.criteria
    signals = {s: Signal(run.t, run.signals[s]) for s in subject.needed}
    found_rises = {s: rises(t, x, *limits.detector[:2]) for s, (t, x) in signals.items()}
    events = {
        name: each.start[each.events(limits.refractory, limits.min_width)].tolist()
        for name, each in found_rises.items()
    }
    end = float(run.t[-1])
    span = limits.settle, max(limits.settle, end)
    evidence = evidence_of(signals, found_rises, subject, span, end)
    found = summary(decide(subject, events, evidence))
    row = nothing(1)
    row['verdict'] = VERDICTS.index(found.verdict)
    for name in ('disturbance_events', 'preserved', 'spurious', 'missed'):
        row[name] = getattr(found.rejection, name)
    left = [residual(signals, plant) for plant in subject.plants]
    sizes = together([size(signal, evidence.span) for signal in left])
    for name, value in sizes._asdict().items():
        row[f'residual_{name}'] = np.nan if value is None else value
    if (late := run.t >= limits.settle).any():
        row['peak'] = max(signal.x[late].max() for signal in left)
    row['settling'], row['latency'] = _times(events, subject)
    only: Rows = row[0]
    return only


def _times(events: Mapping[str, Sequence[float]], subject: Subject) -> tuple[float, float]:
    limits = subject.criteria
    settling, count, total = 0.0, 0, 0.0
    for plant in subject.plants:
        y = events[plant.output]
        y_r = [] if plant.reference is None else events[plant.reference]
        whole = outcomes(y, y_r, -np.inf, limits.window)
        settling = max([settling, *whole.spurious, *whole.missed])
        late = outcomes(y, y_r, limits.settle, limits.window)
        answered = [t for t in y_r if t >= limits.settle and t not in late.missed]
        delay = 0.0
        for t, t_r in zip(late.preserved, answered, strict=True):
            delay += t - t_r
        total += delay
        count += len(answered)
    return settling, total / count if count else 0.0
