# SPDX-License-Identifier: Apache-2.0
"""A scenario run with real nodes, recorded and judged: what ``eventreg run`` does, for Python."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..analysis.learning import foreseen, learners_of
from ..analysis.recorded import Analysis, analyze
from ..analysis.signal import Signals
from ..analysis.verdict import Report
from ..bags.finding import Finding
from ..errors import EventregError, ros_is_missing
from ..nodes import environment
from ..scenario import Criteria, Scenario
from ..scenario.criteria import need_span
from ..scenario.interventions import need_before, read_all
from ..scenario.leads import unequal_leads
from ..simulation.trajectory import Array
from .bag import Recorded
from .judged import Judged
from .observer import Observer
from .session import Session

NODE_WARNING = 'node-warning'
"""The code of what a node warned of during a run."""

DURATION = 40.0
"""Seconds of a run unless something else is said, or the scenario settles late."""


@dataclass(frozen=True, repr=False)
class LiveRun(Judged):
    """What came of a run: its bag, judged, and what its nodes reported of themselves.

    ``analysis`` is None when the bag cannot be judged, for ``unjudged``. ``troubles`` are what went
    wrong after the start, ``measured`` the last diagnostics of each node, ``warnings`` what nodes
    warned of, second by second; ``noted`` is the same with its times, in model time.
    """

    scenario: Scenario
    bag: Path
    analysis: Analysis | None
    unjudged: str | None = None
    troubles: Sequence[str] = ()
    measured: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    warnings: Mapping[str, Sequence[str]] = field(default_factory=dict)
    noted: Sequence[Finding] = ()

    @property
    def recorded(self) -> Recorded:
        """The bag, judged. Raises EventregError where it could not be."""
        if self.analysis is None:
            raise EventregError(f'bag {self.bag} cannot be judged: {self.unjudged}')
        return Recorded(self.analysis)

    @property
    def report(self) -> Report:
        """The verdict and everything behind it."""
        return self.recorded.report

    @property
    def criteria(self) -> Criteria:
        """By what it was judged."""
        return self.recorded.criteria

    def judged_by(
        self,
        settle: float | None = None,
        window: float | None = None,
        *,
        blind: float | None = None,
        until: float | None = None,
    ) -> Report:
        """Return the report by other criteria; see :func:`.judged.judge`."""
        return self.recorded.judged_by(settle, window, blind=blind, until=until)

    def over_time(self) -> Signals:
        """Return the signals with their model times."""
        return self.recorded.over_time()

    @property
    def signals(self) -> dict[str, Array]:
        """The samples of each signal."""
        return self.recorded.signals

    @property
    def t(self) -> Array:
        """The model times of the first plant's output."""
        return self.recorded.t


def run(
    scenario: Scenario,
    duration: float | None = None,
    *,
    bag: str | Path | None = None,
    lockstep: bool = False,
    composed: bool = False,
    observer: Observer | None = None,
    at: Sequence[str] = (),
    settle: float | None = None,
    window: float | None = None,
    blind: float | None = None,
    network: bool = False,
) -> LiveRun:
    """Start the nodes of ``scenario``, record for ``duration`` seconds, and judge the bag.

    Without a duration for as long as :func:`usual_duration` says. The nodes are processes of their
    own, or with ``composed`` one; in ``lockstep`` they go as fast as they can and ``duration`` is
    simulated time. ``at`` holds interventions as texts ``S:NODE.PARAM:=VALUE``, ``S:NODE:activate``
    or ``S:NODE:deactivate``, S in seconds, before the end. ``settle``, ``window`` and ``blind``, in
    model time, replace the scenario's, in the bag too. Raises EventregError when the run cannot be
    started, or when its bag cannot be judged though nothing went wrong during it.

    The nodes keep to the loopback: nobody else on the network sees them or can set them, unless the
    run is open to the ``network``.
    """
    path = Path(bag) if bag is not None else bag_of(scenario)
    check(scenario, path)
    scenario = scenario.with_criteria(settle=settle, window=window, blind=blind)
    duration = usual_duration(scenario) if duration is None else duration
    end = duration * scenario.time_scale
    need_span(scenario.criteria, end, settle=settle, until=None)
    interventions = read_all(at, scenario)
    need_before(duration, interventions, 's')
    session = Session(
        scenario,
        path,
        duration,
        lockstep=lockstep,
        composed=composed,
        observer=observer,
        interventions=interventions,
        network=network,
    )
    said = [finding.text for finding in foreseen(learners_of(scenario))]
    for line in [*said, *unequal_leads(scenario)]:
        session.observer.warned(line)
    session.perform()
    analysis, unjudged = None, None
    try:
        analysis = analyze(path)
        _ = analysis.report
    except EventregError as error:
        if not session.troubles:
            raise
        analysis, unjudged = None, str(error)
    noted = [] if analysis is None else _noted(session, analysis)
    return LiveRun(
        scenario,
        path,
        analysis,
        unjudged,
        session.troubles,
        session.timing,
        session.warnings,
        noted,
    )


def _noted(session: Session, analysis: Analysis) -> list[Finding]:
    """Return what nodes warned of as findings, in model time."""
    start, scale = analysis.recording.start, analysis.time_scale
    return [
        Finding(
            NODE_WARNING, each.node, (each.stamp - start) * scale / 1e9, f'{each.node}: {each.text}'
        )
        for each in session.noted
    ]


def usual_duration(scenario: Scenario, settle: float | None = None) -> float:
    """Return the seconds of a run: 40, or 300 of model time after settling if that is longer."""
    scale = scenario.time_scale
    return scenario.criteria.overridden(settle=settle).duration(DURATION * scale) / scale


def bag_of(scenario: Scenario) -> Path:
    """Return the bag's path: the recorder's, where the scenario says one, else a dated name."""
    given = scenario.nodes.get('recorder', {}).get('path')
    return Path(given or time.strftime(f'eventreg_{scenario.name}_%Y_%m_%d-%H_%M_%S'))


def check(scenario: Scenario, bag: Path) -> None:
    """Raise EventregError for what would fail only after the run."""
    if not scenario.of_kind('plant'):
        raise EventregError(f'scenario {scenario.name} has no plant to judge; name one')
    _ = scenario.time_scale
    if bag.exists():
        raise EventregError(f'bag {bag} exists already; remove it or give another --bag')
    environment.check(os.environ)
    try:
        from . import client  # noqa: F401
    except ImportError as error:
        raise EventregError(ros_is_missing('run', error)) from None
    environment.check_security(os.environ)
