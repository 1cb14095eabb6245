"""What came of one run: the verdict in numbers, and how near it was; a row of a sweep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..analysis.decision import decide, summary
from ..analysis.events import detect
from ..analysis.evidence import complete
from ..analysis.rejection import outcomes
from ..analysis.signal import Signal, size
from ..analysis.subject import subject_by_name
from ..analysis.verdict import residual
from ..errors import EventregError
from ..scenario import Criteria
from ..simulation.impairment import Impairment
from ..simulation.loop import Loop
from ..simulation.sampled import simulate_sampled
from ..simulation.trajectory import Array, Trajectory

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
``latency``, the mean of y - y_r over the preserved events; times are model times."""

Rows = npt.NDArray[np.void]
JUDGED = ('w', 'y', 'y_r')
"""The signals that decide the verdict."""


class Case(NamedTuple):
    """One run: a loop, what happens on its links, and what it is judged by (model time)."""

    loop: Loop
    impairment: Impairment
    criteria: Criteria
    duration: float


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
        run = simulate_sampled(case.loop, case.duration, case.impairment)
    except EventregError as error:
        return Outcome(nothing(1)[0], str(error))
    return Outcome(judged(run, case.criteria), '')


def judged(run: Trajectory, criteria: Criteria) -> Rows:
    """Return the row of a run."""
    signals = {s: Signal(run.t, run.signals[s]) for s in JUDGED if s in run.signals}
    subject = subject_by_name(signals, criteria)
    events = {s: detect(t, x, *criteria.detector) for s, (t, x) in signals.items()}
    evidence = complete(criteria.settle, float(run.t[-1]))
    found = summary(decide(subject, events, evidence))
    row = nothing(1)
    row['verdict'] = VERDICTS.index(found.verdict)
    for name in ('disturbance_events', 'preserved', 'spurious', 'missed'):
        row[name] = getattr(found.rejection, name)
    left_over = size(residual(signals, subject.plants[0]), evidence.span)
    for name, value in left_over._asdict().items():
        row[f'residual_{name}'] = np.nan if value is None else value
    late = run.t >= criteria.settle
    y, y_r = run.signals['y'], run.signals.get('y_r')
    left = (y if y_r is None else y - y_r)[late]
    row['peak'] = left.max() if len(left) else np.nan
    row['settling'], row['latency'] = _times(run, y, y_r, criteria)
    only: Rows = row[0]
    return only


def _times(run: Trajectory, y: Array, y_r: Array | None, criteria: Criteria) -> tuple[float, float]:
    events = detect(run.t, y, *criteria.detector)
    asked = [] if y_r is None else detect(run.t, y_r, *criteria.detector)
    whole = outcomes(events, asked, -np.inf, criteria.window)
    late = outcomes(events, asked, criteria.settle, criteria.window)
    answered = [t for t in asked if t >= criteria.settle and t not in late.missed]
    latency = 0.0
    for t, t_r in zip(late.preserved, answered, strict=True):
        latency += t - t_r
    count = len(answered)
    settling = max([0.0, *whole.spurious, *whole.missed])
    return settling, latency / count if count else 0.0
