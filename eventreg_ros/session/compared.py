# SPDX-License-Identifier: Apache-2.0
"""Runs, scenarios and bags compared: what ``eventreg compare`` does, for Python."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from .. import scenario as scenarios
from ..analysis.comparison import Comparison, distinct, trains_of
from ..analysis.comparison import compare as compare_trains
from ..analysis.recorded import analyze
from ..errors import EventregError, shown
from ..scenario import Criteria, Scenario
from .bag import Recorded
from .judged import Judged, judge
from .simulated import simulate


def compare(
    *runs: Judged | Scenario | str | Path,
    names: Sequence[str] | None = None,
    settle: float | None = None,
    window: float | None = None,
) -> Comparison:
    """Compare two runs or more: verdicts, events that differ, distances, parameters.

    A run is what :func:`simulate`, ``run`` or ``analyze`` returns, a scenario (which is then
    simulated), or a bag, as :func:`open_run` takes them. ``names`` are what the runs are called, by
    default as their scenarios or files. ``settle`` and ``window`` are in model time; see
    :func:`judge`. The events of two runs match within ``window``, without one within that of the
    first run.

    >>> compare('exact', 'uncontrolled')
    <Comparison: exact rejected, uncontrolled not rejected>
    """
    opened = [open_run(run, settle, window) for run in runs]
    called = [_name(given, run) for given, run in zip(runs, opened, strict=True)]
    called = distinct(called) if names is None else list(names)
    reports = [judge(run, settle, window) for run in opened]
    trains = [
        trains_of(name, report, run.scenario)
        for name, report, run in zip(called, reports, opened, strict=True)
    ]
    widest = Criteria().window if not reports else reports[0].subject.criteria.window
    return compare_trains(trains, widest if window is None else window)


def open_run(
    source: Judged | Scenario | str | Path,
    settle: float | None = None,
    window: float | None = None,
) -> Judged:
    """Return the run that ``source`` means: a scenario is simulated, a bag is read and judged.

    A shipped name, or the path of a .yaml file, is a scenario; any other path a bag (a bag called
    like a scenario is ./NAME). A simulation lasts 400 of model time, or 300 after ``settle`` if
    that is longer. A run is returned as it is. Raises EventregError for what is neither.

    >>> open_run('linear')
    <Run of linear: w, y, u; 400 of model time; rejected>
    """
    if isinstance(source, Judged):
        return source
    if not isinstance(source, Scenario):
        if not isinstance(source, str | Path):
            raise EventregError(f'a run is a bag, a scenario or a result, got {shown(source)}')
        if not is_scenario(source):
            return Recorded(analyze(source, settle=settle, window=window))
        source = scenarios.load(str(source))
    return simulate(source, source.criteria.overridden(settle=settle).duration(400.0))


def is_scenario(source: str | Path) -> bool:
    """Say whether ``source`` names a scenario, and not a bag; see :func:`open_run`.

    Raises EventregError for what is neither.
    """
    text = str(source)
    if text in scenarios.shipped() or Path(text).suffix in ('.yaml', '.yml'):
        return True
    if not os.path.exists(text):  # False for a name that is too long, unlike Path.exists
        raise EventregError(
            f'{shown(text)} is neither a bag nor a scenario: no such file, and shipped are '
            f'{", ".join(scenarios.shipped())}; check the name'
        )
    return False


def _name(given: object, run: Judged) -> str:
    if isinstance(given, str | Path):
        return Path(given).name or str(given)
    return run.scenario.name if run.scenario else 'bag'
