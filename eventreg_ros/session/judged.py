# SPDX-License-Identifier: Apache-2.0
"""What every run has, simulated, recorded or live: signals, events, a verdict, a picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.export import to_dataframe, to_xarray, write_signals
from ..analysis.report_table import table
from ..analysis.signal import Signals
from ..analysis.verdict import Report
from ..errors import EventregError, shown
from ..scenario import Criteria, Scenario
from ..simulation.trajectory import Array

if TYPE_CHECKING:
    import pandas
    import xarray

    from ..plots.run_plot import Figure


class Judged:
    """A run that has been judged.

    A subclass gives ``report``, ``over_time``, ``criteria``, ``scenario`` and ``judged_by``.
    """

    if TYPE_CHECKING:  # a dataclass would take a property for the default of its field

        @property
        def scenario(self) -> Scenario | None:
            """What was run, None where nobody knows."""

        @property
        def signals(self) -> Mapping[str, Array]:
            """The samples of each signal."""

        @property
        def t(self) -> Array:
            """Model time."""

    @property
    def report(self) -> Report:
        """The verdict and everything behind it."""
        raise NotImplementedError

    @property
    def criteria(self) -> Criteria:
        """By what it was judged."""
        raise NotImplementedError

    def over_time(self) -> Signals:
        """Return the signals, each with its own model times."""
        raise NotImplementedError

    def judged_by(
        self,
        settle: float | None = None,
        window: float | None = None,
        *,
        blind: float | None = None,
        until: float | None = None,
    ) -> Report:
        """Return the report by other criteria; see :func:`judge`."""
        raise NotImplementedError

    def __getitem__(self, signal: str) -> Array:
        """Return the samples of one signal. Raises KeyError when there is none of that name."""
        try:
            return self.signals[signal]
        except KeyError:
            raise KeyError(f'no signal {signal!r}; there are {", ".join(self.signals)}') from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.signals)

    def __len__(self) -> int:
        return len(self.signals)

    def __contains__(self, signal: object) -> bool:
        return signal in self.signals

    def keys(self) -> Iterable[str]:
        """Return the names of the signals."""
        return self.signals.keys()

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

        Where a signal that decides the verdict was not seen, it is shaded.
        ``run.plot().savefig('run.pdf')`` writes it.
        """
        from ..plots.run_plot import draw_report

        return draw_report(self.over_time(), self.report)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the signals as a pandas DataFrame over t; see :func:`.export.to_dataframe`."""
        return to_dataframe(self.over_time(), **self._attrs())

    def to_xarray(self) -> xarray.Dataset:
        """Return the signals as an xarray Dataset over t; see :func:`.export.to_xarray`."""
        return to_xarray(self.over_time(), **self._attrs())

    def save(self, path: str | Path) -> None:
        """Write the signals to a file that ends in .npz, .csv or .parquet.

        Where signals have times of their own, they are put on those of the first plant's output by
        straight lines. Raises EventregError when it cannot be written.
        """
        signals = {name: np.interp(self.t, *signal) for name, signal in self.over_time().items()}
        write_signals(Path(path), self.t, signals)

    def _attrs(self) -> dict[str, str]:
        return {'scenario': self.report.scenario, 'verdict': self.verdict}

    def __repr__(self) -> str:
        signals = ', '.join(self.over_time())
        end = self.report.duration
        return (
            f'<{type(self).__name__} of {self.report.scenario}: {signals}; {end:g} of model time; '
            f'{self.verdict}>'
        )

    def __str__(self) -> str:
        """Return the table that the command prints; it ends with the verdict."""
        return table(self.report)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the verdict, why, and the table."""
        head = f'<b>{escape(self.report.scenario)}: {escape(self.verdict)}</b>'
        words = f'<p>{escape(self.reason)}</p>'
        return f'{head}{words}<pre>{escape(str(self))}</pre>'


def judge(
    run: Judged,
    settle: float | None = None,
    window: float | None = None,
    *,
    blind: float | None = None,
    until: float | None = None,
) -> Report:
    """Return the report on a run: verdict, reason, evidence, rejection, signals.

    By the criteria of the run, except those given (model time): events before ``settle`` and after
    ``until`` do not count; those of y and y_r match within ``window``. Raises EventregError when
    that leaves nothing of the run, and for what is no run.

    >>> judge(simulate('exact'), settle=0)
    <Report on exact: rejected; after t = 0 w had 10 events; none made y spike>
    """
    if not isinstance(run, Judged):
        raise EventregError(
            f'judge takes a run, as simulate, run, analyze and open_run return it, got {shown(run)}'
        )
    return run.judged_by(settle, window, blind=blind, until=until)
