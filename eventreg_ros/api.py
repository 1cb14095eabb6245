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
from .analysis.criteria import RESET, SETTLE, THRESHOLD, WINDOW
from .analysis.events import detect
from .analysis.export import to_dataframe, to_xarray
from .analysis.recorded import Analysis, analyze
from .analysis.verdict import Report, Signals, table
from .analysis.verdict import judge as judge_signals
from .errors import EventregError
from .scenario import Scenario
from .scenario.hint import hint
from .scenario.interventions import read_all, turns
from .simulation.continuous import simulate as simulate_continuous
from .simulation.impairment import Impairment
from .simulation.loop import Loop
from .simulation.sampled import simulate_sampled
from .simulation.trajectory import Array, Trajectory
from .theory.certificates import Certificate
from .theory.certify import certify

if TYPE_CHECKING:
    import pandas
    import xarray

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
        """Everything that ``eventreg simulate --json`` writes, with its defaults."""
        return judge(self)

    @property
    def verdict(self) -> str:
        """``rejected``, ``not rejected`` or ``undecided``."""
        return str(self.report['verdict'])

    @property
    def events(self) -> dict[str, list[float]]:
        """The model times of all events of each signal."""
        found = self.report['signals']
        return {name: [float(t) for t in entry['events']] for name, entry in found.items()}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the signals as a pandas DataFrame over t; see :func:`.export.to_dataframe`."""
        return to_dataframe(self._over_time(), scenario=self.scenario.name, verdict=self.verdict)

    def to_xarray(self) -> xarray.Dataset:
        """Return the signals as an xarray Dataset over t; see :func:`.export.to_xarray`."""
        return to_xarray(self._over_time(), scenario=self.scenario.name, verdict=self.verdict)

    def _over_time(self) -> Signals:
        return {name: (self.t, x) for name, x in self.signals.items()}


def load(scenario: str, *overrides: str) -> Scenario:
    """Read a scenario, by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are what follows -p on a command line: 'NODE.PARAM:=VALUE', NODE may be '/**'.
    Raises ScenarioError or ParameterError, one line with the remedy.
    """
    return scenarios.load(scenario, overrides)


def simulate(
    scenario: Scenario | str,
    duration: float = 400.0,
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

    As one continuous system, or ``sampled``: sample by sample as the nodes do it in lockstep, each
    link with ``delay`` and ``jitter`` (model time) and ``loss`` (probability), drawn from ``seed``;
    ``on`` names the signals whose links are impaired (None: all). ``at`` holds interventions as
    texts ``T:NODE.PARAM:=VALUE``, ``T:NODE:activate`` or ``T:NODE:deactivate``, T in model time.
    Raises EventregError when the loop cannot be simulated or the state stops being finite.
    """
    scenario = _loaded(scenario)
    if not sampled and (delay or loss or jitter or seed or on):
        raise EventregError(
            f'delay, loss, jitter, seed and on belong to a sampled simulation, got '
            f'{delay:g}, {loss:g}, {jitter:g}, {seed} and {on}; add sampled=True'
        )
    loop, done = scenario.loop, turns(read_all(at, scenario), scenario)
    if sampled:
        links = None if on is None else frozenset(on)
        impairment = Impairment(delay, loss, jitter, seed, _need_linked(loop, links))
        found = simulate_sampled(loop, duration, impairment, done)
        return Run(scenario, found.t, found.signals, found)
    time_scale, rate = loop.grid
    every = max(math.ceil(time_scale / rate / FINE - 1e-9), 1)
    fine = loop.sampled_at(every * rate)
    found = simulate_continuous(fine, duration, turns=done)
    coarse = {name: x[::every] for name, x in found.signals.items()}
    return Run(scenario, found.t[::every], coarse, found)


def _need_linked(loop: Loop, on: frozenset[str] | None) -> frozenset[str] | None:
    """Return ``on``. Raises EventregError when it names a signal that no block listens to."""
    linked = {signal for _, signal in loop.links}
    for signal in sorted((on or frozenset()) - linked):
        raise EventregError(f'on: no block listens to {signal!r}{hint(signal, linked)}')
    return on


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


def judge(run: Run, settle: float = SETTLE, window: float = WINDOW) -> Report:
    """Return the report on a run: verdict, rejection, residual, synchronisation, signals.

    Events before ``settle`` do not count; those of y and y_r match within ``window`` (model time).
    """
    threshold, reset = run.scenario.monitor
    report = judge_signals(
        {name: (run.fine.t, x) for name, x in run.fine.signals.items()},
        scenario=run.scenario.name,
        time_scale=run.scenario.time_scale,
        threshold=threshold,
        reset=reset,
        settle=settle,
        window=window,
    )
    for entry in report['signals'].values():
        entry['samples'] = len(run.t)  # the fine grid is for the events alone
    return report


def compare(
    *runs: Run | Analysis | Scenario | str | Path,
    names: Sequence[str] | None = None,
    settle: float = SETTLE,
    window: float = WINDOW,
) -> Comparison:
    """Compare two runs or more: verdicts, events that differ, distances, parameters.

    A run is what :func:`simulate` returns, a scenario (which is then simulated), or a bag, as
    :func:`open_run` takes them. ``names`` are what the runs are called, by default as their
    scenarios or files. ``settle`` and ``window`` are in model time; see :func:`judge`.
    """
    opened = [
        run if isinstance(run, Run | Analysis) else open_run(run, settle, window) for run in runs
    ]
    called = [_name(given, run) for given, run in zip(runs, opened, strict=True)]
    called = distinct(called) if names is None else list(names)
    trains = [
        trains_of(name, _judged(run, settle, window), run.scenario)
        for name, run in zip(called, opened, strict=True)
    ]
    return compare_trains(trains, window)


def open_run(
    source: Scenario | str | Path, settle: float = SETTLE, window: float = WINDOW
) -> Run | Analysis:
    """Return the run that ``source`` means: a scenario is simulated, a bag is read and judged.

    A shipped name, or the path of a .yaml file, is a scenario; any other path a bag (a bag called
    like a scenario is ./NAME). A simulation lasts 400 of model time, or 300 after ``settle`` if
    that is longer. Raises EventregError for what is neither.
    """
    if isinstance(source, Scenario):
        return simulate(source, max(400.0, settle + 300.0))
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


def _judged(run: Run | Analysis, settle: float, window: float) -> Report:
    if isinstance(run, Run):
        return judge(run, settle, window)
    same = (run.settle, run.window) == (settle, window)
    return (run if same else replace(run, settle=settle, window=window)).report


def certificates(scenario: Scenario | str) -> list[Certificate]:
    """Return what theory says of a scenario, and what is measured where theory is silent.

    What ``eventreg certify`` prints; the measured Lyapunov exponents take a second or two.
    """
    return certify(_loaded(scenario).loop)


def _loaded(scenario: Scenario | str) -> Scenario:
    return load(scenario) if isinstance(scenario, str) else scenario
