# SPDX-License-Identifier: Apache-2.0
"""A bag read and judged: what ``eventreg analyze`` does, for Python."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..analysis.recorded import Analysis
from ..analysis.signal import Signals
from ..analysis.verdict import Report
from ..bags.finding import Finding
from ..bags.recording import Recording
from ..scenario import Criteria, Scenario
from ..scenario.criteria import need_span
from ..simulation.trajectory import Array
from .judged import Judged


@dataclass(frozen=True, repr=False)
class Recorded(Judged):
    """A recorded run, judged; ``analysis`` has all that was read."""

    analysis: Analysis

    @property
    def report(self) -> Report:
        """The verdict and everything behind it."""
        return self.analysis.report

    @property
    def recording(self) -> Recording:
        """The signals as they were recorded, over ROS time, and where they come from."""
        return self.analysis.recording

    @property
    def findings(self) -> list[Finding]:
        """What the reader found to be wrong with the bag, in model time."""
        return self.analysis.findings

    @property
    def criteria(self) -> Criteria:
        """By what it was judged."""
        return self.analysis.criteria

    @property
    def scenario(self) -> Scenario | None:
        """By what it was judged, None where the bag has none and none was given."""
        return self.analysis.scenario

    def judged_by(
        self,
        settle: float | None = None,
        window: float | None = None,
        *,
        blind: float | None = None,
        until: float | None = None,
    ) -> Report:
        """Return the report by other criteria; see :func:`.judged.judge`."""
        wanted = self.criteria.overridden(settle=settle, window=window, blind=blind)
        end = self.analysis.until if until is None else until
        need_span(wanted, self.analysis.duration, settle=settle, until=until)
        if (wanted, end) == (self.criteria, self.analysis.until):
            return self.report
        return replace(self.analysis, criteria=wanted, until=end).report

    def over_time(self) -> Signals:
        """Return the signals with their model times."""
        return self.analysis.signals

    @cached_property
    def signals(self) -> dict[str, Array]:
        """The samples of each signal; their times are in ``times``, shape (n,) each."""
        return {name: x for name, (_, x) in self.analysis.signals.items()}

    @cached_property
    def times(self) -> dict[str, Array]:
        """The model times of each signal's samples."""
        return {name: t for name, (t, _) in self.analysis.signals.items()}

    @property
    def t(self) -> Array:
        """The model times of the first plant's output, on which ``signals['y']`` is."""
        plants = self.analysis.subject.plants
        return self.times[plants[0].output] if plants else np.empty(0)
