"""A bag read and judged: what ``eventreg analyze`` does, for Python."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis.recorded import Analysis
from ..analysis.signal import Signals
from ..analysis.verdict import Report
from ..scenario import Criteria
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
    def criteria(self) -> Criteria:
        """By what it was judged."""
        return self.analysis.criteria

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

    def __getitem__(self, signal: str) -> Array:
        """Return the samples of one signal. Raises KeyError when the bag has none of that name."""
        return self.signals[signal]
