"""Runs, scenarios and bags compared: what ``eventreg compare`` does, for Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .. import scenario as scenarios
from ..analysis.comparison import Comparison, distinct, trains_of
from ..analysis.comparison import compare as compare_trains
from ..analysis.recorded import Analysis, analyze, need_span
from ..analysis.verdict import Report
from ..errors import EventregError
from ..scenario import Criteria, Scenario
from .simulated import Run, judge, simulate


def compare(
    *runs: Run | Analysis | Scenario | str | Path,
    names: Sequence[str] | None = None,
    settle: float | None = None,
    window: float | None = None,
) -> Comparison:
    """Compare two runs or more: verdicts, events that differ, distances, parameters.

    A run is what :func:`simulate` returns, a scenario (which is then simulated), or a bag, as
    :func:`open_run` takes them. ``names`` are what the runs are called, by default as their
    scenarios or files. ``settle`` and ``window`` are in model time; see :func:`judge`. The events
    of two runs match within ``window``, without one within that of the first run.
    """
    opened = [
        run if isinstance(run, Run | Analysis) else open_run(run, settle, window) for run in runs
    ]
    called = [_name(given, run) for given, run in zip(runs, opened, strict=True)]
    called = distinct(called) if names is None else list(names)
    reports = [_judged(run, settle, window) for run in opened]
    trains = [
        trains_of(name, report, run.scenario)
        for name, report, run in zip(called, reports, opened, strict=True)
    ]
    widest = Criteria().window if not reports else reports[0].subject.criteria.window
    return compare_trains(trains, widest if window is None else window)


def open_run(
    source: Scenario | str | Path, settle: float | None = None, window: float | None = None
) -> Run | Analysis:
    """Return the run that ``source`` means: a scenario is simulated, a bag is read and judged.

    A shipped name, or the path of a .yaml file, is a scenario; any other path a bag (a bag called
    like a scenario is ./NAME). A simulation lasts 400 of model time, or 300 after ``settle`` if
    that is longer. Raises EventregError for what is neither.
    """
    if not isinstance(source, Scenario):
        if not is_scenario(source):
            return analyze(source, settle=settle, window=window)
        source = scenarios.load(str(source))
    return simulate(source, source.criteria.overridden(settle=settle).duration(400.0))


def is_scenario(source: str | Path) -> bool:
    """Say whether ``source`` names a scenario, and not a bag; see :func:`open_run`.

    Raises EventregError for what is neither.
    """
    text = str(source)
    if text in scenarios.shipped() or Path(text).suffix in ('.yaml', '.yml'):
        return True
    if not Path(text).exists():
        raise EventregError(
            f'{text!r} is neither a bag nor a scenario: no such file, and shipped are '
            f'{", ".join(scenarios.shipped())}; check the name'
        )
    return False


def _name(given: object, run: Run | Analysis) -> str:
    if isinstance(given, str | Path):
        return Path(given).name or str(given)
    return run.scenario.name if run.scenario else 'bag'


def _judged(run: Run | Analysis, settle: float | None, window: float | None) -> Report:
    if isinstance(run, Run):
        return judge(run, settle, window)
    wanted = run.criteria.overridden(settle=settle, window=window)
    need_span(wanted, run.duration, settle=settle, until=None)
    return (run if wanted == run.criteria else replace(run, criteria=wanted)).report
