r"""The library: what the commands do, for notebooks and scripts.

    from eventreg_ros import load, simulate, certificates

    scenario = load('exact', 'controller.k:=3')
    run = simulate(scenario, duration=400)
    print(run.verdict, run.events['w'], run['y'][-1])
    print(*certificates(scenario), sep='\n')

All public names of this module are there as ``from eventreg_ros import ...``.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from . import scenario as scenarios
from .analysis.comparison import Comparison, distinct, trains_of
from .analysis.comparison import compare as compare_trains
from .analysis.events import detect
from .analysis.export import to_dataframe, to_xarray
from .analysis.recorded import Analysis, analyze, need_span
from .analysis.report_table import table
from .analysis.signal import Signal, Signals
from .analysis.subject import subject_of
from .analysis.verdict import Report
from .analysis.verdict import judge as judge_signals
from .errors import EventregError
from .scenario import Criteria, Scenario
from .scenario.criteria import RESET, THRESHOLD
from .scenario.interventions import read_all, turns
from .scenario.links import need_linked
from .simulation.continuous import simulate as simulate_continuous
from .simulation.impairment import Impairment
from .simulation.sampled import simulate_sampled
from .simulation.trajectory import Array, Trajectory
from .theory.certificates import Certificate
from .theory.certify import certify

if TYPE_CHECKING:
    import pandas
    import xarray

    from .plots.run_plot import Figure

FINE = 0.02
"""Model time between the samples in which a continuous run's events are looked for, at most."""

__all__ = [
    'Certificate',
    'Comparison',
    'Run',
    'Scenario',
    'certificates',
    'compare',
    'events',
    'judge',
    'load',
    'simulate',
]


@dataclass(frozen=True, repr=False)
class Run:
    """A simulated scenario.

    ``t`` has shape (n,), in model time, every time_scale / rate from 0; so has each of ``signals``,
    the outputs of the blocks and of the stimulus by name, which ``run['y']`` reads as well.
    """

    scenario: Scenario
    t: Array
    signals: Mapping[str, Array]
    fine: Trajectory
    """The grid in which events are looked for; in a sampled run the same."""

    def __repr__(self) -> str:
        signals = ', '.join(self.signals)
        return f'<Run of {self.scenario.name}: {signals}; {self.t[-1]:g} model time units>'

    def __str__(self) -> str:
        """Return the table that ``eventreg simulate`` prints; it ends with the verdict."""
        return table(self.report)

    def __getitem__(self, signal: str) -> Array:
        """Return one signal. Raises KeyError when the scenario has none of that name."""
        return self.signals[signal]

    @cached_property
    def report(self) -> Report:
        """The verdict and everything behind it, by the scenario's criteria."""
        return judge(self)

    @property
    def verdict(self) -> str:
        """``rejected``, ``not rejected`` or ``undecided``."""
        return self.report.verdict

    @property
    def reason(self) -> str:
        """Why, in words."""
        return self.report.reason

    @property
    def events(self) -> dict[str, list[float]]:
        """The model times of all events of each signal."""
        return {name: list(signal.events) for name, signal in self.report.signals.items()}

    def plot(self) -> Figure:
        """Return a matplotlib figure of the signals and their events, which a notebook shows.

        ``run.plot().savefig('run.pdf')`` writes it.
        """
        from .plots.run_plot import draw_run

        criteria = self.scenario.criteria
        return draw_run(
            self._over_time(),
            self.events,
            threshold=criteria.threshold,
            settle=criteria.settle,
            title=f'{self.scenario.name}: {self.verdict}',
        )

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the signals as a pandas DataFrame over t; see :func:`.export.to_dataframe`."""
        return to_dataframe(self._over_time(), scenario=self.scenario.name, verdict=self.verdict)

    def to_xarray(self) -> xarray.Dataset:
        """Return the signals as an xarray Dataset over t; see :func:`.export.to_xarray`."""
        return to_xarray(self._over_time(), scenario=self.scenario.name, verdict=self.verdict)

    def _over_time(self) -> Signals:
        return {name: Signal(self.t, x) for name, x in self.signals.items()}


def load(scenario: str, *overrides: str) -> Scenario:
    """Read a scenario, by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are what follows -p on a command line: 'NODE.PARAM:=VALUE', NODE may be '/**'.
    Raises ScenarioError or ParameterError, one line with the remedy.
    """
    return scenarios.load(scenario, overrides)


def simulate(
    scenario: Scenario | str,
    duration: float | None = None,
    *,
    sampled: bool = False,
    delay: float = 0.0,
    loss: float = 0.0,
    jitter: float = 0.0,
    seed: int = 0,
    on: Collection[str] | None = None,
    at: Sequence[str] = (),
) -> Run:
    """Simulate a scenario (or the one of that name) over ``duration`` of model time.

    The default is 400, or 300 after settling if that is longer. The loop is one continuous system,
    or ``sampled``: sample by sample as the nodes do it in lockstep, each link with ``delay`` and
    ``jitter`` (model time) and ``loss`` (probability), drawn from ``seed``; ``on`` names the
    signals whose links are impaired (None: all). ``at`` holds interventions as texts
    ``T:NODE.PARAM:=VALUE``, ``T:NODE:activate`` or ``T:NODE:deactivate``, T in model time. Raises
    EventregError when the loop cannot be simulated or the state stops being finite.
    """
    scenario = _loaded(scenario)
    if duration is None:
        duration = scenario.criteria.duration(400.0)
    if not sampled and (delay or loss or jitter or seed or on):
        raise EventregError(
            f'delay, loss, jitter, seed and on belong to a sampled simulation, got '
            f'{delay:g}, {loss:g}, {jitter:g}, {seed} and {on}; add sampled=True'
        )
    loop, done = scenario.loop, turns(read_all(at, scenario), scenario)
    if sampled:
        links = None if on is None else frozenset(on)
        impairment = Impairment(delay, loss, jitter, seed, need_linked(loop, links))
        found = simulate_sampled(loop, duration, impairment, done)
        return Run(scenario, found.t, found.signals, found)
    time_scale, rate = loop.grid
    every = max(math.ceil(time_scale / rate / FINE - 1e-9), 1)
    fine = loop.sampled_at(every * rate)
    found = simulate_continuous(fine, duration, turns=done)
    coarse = {name: x[::every] for name, x in found.signals.items()}
    return Run(scenario, found.t[::every], coarse, found)


def events(
    t: Array,
    values: Array,
    threshold: float = THRESHOLD,
    reset: float = RESET,
    refractory: float = 0.0,
    min_width: float = 0.0,
) -> list[float]:
    """Return the times of the events of one signal, samples ``values`` at ``t``, both shape (n,).

    An event rises through ``threshold`` after the signal was at or below ``reset``, lasts until it
    is there again, at least ``min_width``, and begins at least ``refractory`` after the last event.
    """
    return detect(t, values, threshold, reset, refractory, min_width)


def judge(
    run: Run,
    settle: float | None = None,
    window: float | None = None,
    *,
    blind: float | None = None,
    until: float | None = None,
) -> Report:
    """Return the report on a run: verdict, reason, evidence, rejection, signals.

    By the scenario's criteria, but for those given (model time): events before ``settle`` and after
    ``until`` do not count; those of y and y_r match within ``window``. Raises EventregError when
    that leaves nothing of the run.
    """
    subject = subject_of(run.scenario, run.signals)
    criteria = subject.criteria.overridden(settle=settle, window=window, blind=blind)
    need_span(criteria, float(run.t[-1]), settle=settle, until=until)
    signals = {name: Signal(run.fine.t, x) for name, x in run.fine.signals.items()}
    report = judge_signals(signals, replace(subject, criteria=criteria), until=until)
    coarse = {  # the fine grid is for the events alone
        name: replace(signal, samples=len(run.t)) for name, signal in report.signals.items()
    }
    return replace(report, signals=coarse)


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
    if isinstance(source, Scenario):
        return simulate(source, source.criteria.overridden(settle=settle).duration(400.0))
    text = str(source)
    if text in scenarios.shipped() or Path(text).suffix in ('.yaml', '.yml'):
        return open_run(load(text), settle, window)
    if not Path(text).exists():
        raise EventregError(
            f'{text!r} is neither a bag nor a scenario: no such file, and shipped are '
            f'{", ".join(scenarios.shipped())}; check the name'
        )
    return analyze(text, settle=settle, window=window)


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


def certificates(scenario: Scenario | str) -> list[Certificate]:
    """Return what theory says of a scenario, and what is measured where theory is silent.

    What ``eventreg certify`` prints; the measured Lyapunov exponents take a second or two.
    """
    return certify(_loaded(scenario).loop)


def _loaded(scenario: Scenario | str) -> Scenario:
    return load(scenario) if isinstance(scenario, str) else scenario
