# SPDX-License-Identifier: Apache-2.0
"""A recorded bag, judged: the signals, the scenario they belong to, and the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from .. import scenario as scenarios
from ..bags.finding import Finding
from ..bags.reader import read_bag
from ..bags.recording import Recording
from ..errors import BagError
from ..scenario import Criteria, Scenario
from ..scenario.criteria import need_span
from .changes import changes_of
from .coded import Coded, as_received, codings
from .export import to_dataframe, to_xarray
from .signal import Signal, Signals
from .subject import Subject, subject_by_name, subject_of
from .timing import Timing, timing
from .verdict import Report, judge

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True)
class Analysis:
    """A bag, what it was read with, and what came out; times are in model time."""

    recording: Recording
    scenario: Scenario | None
    criteria: Criteria = field(default_factory=Criteria)
    until: float | None = None
    lenient: bool = False

    @cached_property
    def subject(self) -> Subject:
        """What is judged."""
        names = [name for name, (t, _) in self.recording.signals.items() if len(t)]
        found = subject_of(self.scenario, names) if self.scenario else subject_by_name(names)
        return replace(found, criteria=self.criteria)

    @property
    def time_scale(self) -> float:
        """Model time units per second."""
        return self.subject.time_scale

    @cached_property
    def signals(self) -> Signals:
        """The signals over model time; those that were coded as their receivers knew them."""
        read = self.recording.in_model_time(self.time_scale)
        found: Signals = {name: Signal(t, x) for name, (t, x) in read.items()}
        return as_received(found, self._coded)

    @cached_property
    def _coded(self) -> Mapping[str, Coded]:
        """The signals of which not every sample was sent."""
        return codings(self.scenario) if self.scenario else {}

    @property
    def findings(self) -> list[Finding]:
        """What the reader found to be wrong with the bag, in model time."""
        scale = self.time_scale
        return [f if f.at is None else f._replace(at=f.at * scale) for f in self.recording.findings]

    @cached_property
    def report(self) -> Report:
        """The report, with the timing of each signal."""
        return judge(
            self.signals,
            self.subject,
            until=self.until,
            findings=self.findings,
            changes=changes_of(self.recording, self.time_scale),
            lenient=self.lenient,
            timings=self._timings,
            counts={name: len(stamps) for name, (stamps, _) in self.recording.signals.items()},
        )

    @property
    def _timings(self) -> dict[str, Timing]:
        """How regularly each signal came."""
        return {
            name: timing(stamps, self._coded[name].patience if name in self._coded else None)
            for name, (stamps, _) in self.recording.signals.items()
        }

    @property
    def duration(self) -> float:
        """The model time of the last sample."""
        return max((float(t[-1]) for t, _ in self.signals.values() if len(t)), default=0.0)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the signals as a pandas DataFrame over t; see :func:`.export.to_dataframe`."""
        return to_dataframe(self.signals, **self._attrs())

    def to_xarray(self) -> xarray.Dataset:
        """Return the signals as an xarray Dataset over t; see :func:`.export.to_xarray`."""
        return to_xarray(self.signals, **self._attrs())

    def _attrs(self) -> dict[str, str]:
        return {'scenario': self.report.scenario, 'verdict': self.report.verdict}


def analyze(
    bag: str | Path,
    scenario: Scenario | str | None = None,
    *,
    settle: float | None = None,
    window: float | None = None,
    blind: float | None = None,
    until: float | None = None,
    lenient: bool = False,
    namespace: str | None = None,
    topics: Sequence[str] = (),
    time: str | None = None,
) -> Analysis:
    """Read a bag and judge it by ``scenario`` (an object, a name or a path), else by its own.

    ``settle``, ``window`` and ``blind``, in model time, replace the scenario's; what lies after
    ``until`` is not judged; ``lenient`` judges what was seen although something is missing.
    ``namespace``, ``topics`` and ``time`` say what is read: see :func:`.read_bag`. Raises BagError
    or ScenarioError, also when the bag lacks a signal that the scenario publishes, and
    EventregError when ``settle`` is not before the end.
    """
    recording = read_bag(bag, namespace, topics=topics, time=time)
    read = by_scenario(recording, scenario_of(recording, scenario, namespace))
    if read.scenario is not None:
        _need_signals(bag, recording, read.scenario)
    criteria = read.criteria.overridden(settle=settle, window=window, blind=blind)
    analysis = replace(read, criteria=criteria, until=until, lenient=lenient)
    need_span(criteria, analysis.duration, settle=settle, until=until)
    return analysis


def by_scenario(recording: Recording, scenario: Scenario | None) -> Analysis:
    """Return a recording to be judged by ``scenario``, and by its criteria; None: by names."""
    return Analysis(recording, scenario, scenario.criteria if scenario else Criteria())


def scenario_of(
    recording: Recording, given: Scenario | str | None, namespace: str | None = None
) -> Scenario | None:
    """Return the scenario of a recording, the part in ``namespace``: ``given``, else its own."""
    found = scenarios.load(given) if isinstance(given, str) else given
    if found is None and recording.scenario is not None:
        found = scenarios.parse(recording.scenario, recording.name or 'of the bag')
    return found.within(namespace) if found is not None and namespace else found


def _need_signals(bag: str | Path, recording: Recording, scenario: Scenario) -> None:
    missing = [
        f'{signal} (of {scenario.publishers[signal]})'
        for signal in scenario.outputs
        if not len(recording.signals.get(signal, ((),))[0])
    ]
    if missing:
        raise BagError(
            f'bag {bag} holds no sample of {", ".join(missing)}, which scenario {scenario.name} '
            'publishes; record it, or give the --scenario that the bag was made with'
        )
