"""A recorded bag, judged: the signals, the scenario they belong to, and the report."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from .. import scenario as scenarios
from ..bags.reader import read_bag
from ..bags.recording import Recording
from ..errors import BagError
from ..scenario import Scenario
from ..scenario.table import TIME_SCALE
from .criteria import SETTLE, WINDOW
from .export import to_dataframe, to_xarray
from .timing import timing
from .verdict import Report, Signals, judge

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True)
class Analysis:
    """A bag, what it was read with, and what came out; times are in model time."""

    recording: Recording
    scenario: Scenario | None
    settle: float = SETTLE
    window: float = WINDOW

    @property
    def monitor(self) -> tuple[float, float]:
        """Threshold and reset of the events."""
        return self.scenario.monitor if self.scenario else scenarios.monitor_defaults()

    @property
    def time_scale(self) -> float:
        """Model time units per second."""
        return self.scenario.time_scale if self.scenario else float(TIME_SCALE.default)

    @cached_property
    def signals(self) -> Signals:
        """The signals over model time."""
        return self.recording.in_model_time(self.time_scale)

    @cached_property
    def report(self) -> Report:
        """The contract's report."""
        threshold, reset = self.monitor
        report = judge(
            self.signals,
            scenario=self.scenario.name if self.scenario else 'unknown',
            time_scale=self.time_scale,
            threshold=threshold,
            reset=reset,
            settle=self.settle,
            window=self.window,
        )
        for name, entry in report['signals'].items():
            entry['timing'] = timing(self.recording.signals[name][0])
        return report

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the signals as a pandas DataFrame over t; see :func:`.export.to_dataframe`."""
        return to_dataframe(self.signals, **self._attrs())

    def to_xarray(self) -> xarray.Dataset:
        """Return the signals as an xarray Dataset over t; see :func:`.export.to_xarray`."""
        return to_xarray(self.signals, **self._attrs())

    def _attrs(self) -> dict[str, str]:
        return {key: self.report[key] for key in ('scenario', 'verdict')}


def analyze(
    bag: str | Path,
    scenario: Scenario | str | None = None,
    *,
    settle: float = SETTLE,
    window: float = WINDOW,
    namespace: str | None = None,
) -> Analysis:
    """Read a bag and judge it by ``scenario`` (an object, a name or a path), else by its own.

    Raises BagError or ScenarioError, also when the bag lacks a signal that the scenario publishes.
    """
    recording = read_bag(bag, namespace)
    found = _scenario_of(recording, scenario)
    if found is not None:
        _need_signals(bag, recording, found)
    return Analysis(recording, found, settle, window)


def _scenario_of(recording: Recording, given: Scenario | str | None) -> Scenario | None:
    if isinstance(given, Scenario):
        return given
    if given is not None:
        return scenarios.load(given)
    if recording.scenario is not None:
        return scenarios.parse(recording.scenario, recording.name or 'of the bag')
    return None


def _need_signals(bag: str | Path, recording: Recording, scenario: Scenario) -> None:
    missing = [
        f'{signal} (of {node})'
        for signal, node in scenario.publishers.items()
        if not len(recording.signals.get(signal, ((),))[0])
    ]
    if missing:
        raise BagError(
            f'bag {bag} holds no sample of {", ".join(missing)}, which scenario {scenario.name} '
            'publishes; record it, or give the --scenario that the bag was made with'
        )
