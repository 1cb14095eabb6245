# SPDX-License-Identifier: Apache-2.0
"""The measured open input v: a function of model time, and the instants at which it jumps."""

from __future__ import annotations

import csv
import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import EventregError, ParameterError, shown
from ..files import UnreadableError, read_text

WAVEFORMS = ('constant', 'sine', 'square', 'pulses', 'csv')

MAX_BREAKS = 10_000
"""Jumps within one continuous integration; each costs it a millisecond."""

MAX_BYTES = 1 << 24
"""Of a csv file; half a million points."""


@dataclass(frozen=True)
class Stimulus:
    """A waveform and its parameters; every time is in model time.

    ``constant`` is offset + amplitude; ``sine`` is offset + amplitude sin(2 pi (t - phase) /
    period); ``square`` is high for ``width`` from each start of a period; ``pulses`` is high for
    ``width`` from each onset, the end excluded; ``csv`` runs straight from point to point, scaled
    by ``amplitude`` and shifted by ``offset``, and stays at its first and last value outside.
    """

    waveform: str = 'constant'
    amplitude: float = 1.0
    offset: float = 0.0
    period: float = 50.0
    phase: float = 0.0
    onsets: tuple[float, ...] = ()
    width: float = 10.0
    points: tuple[tuple[float, float], ...] = ()

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any]) -> Stimulus:
        """Build one from the resolved parameters of the stimulus node; reads the csv file.

        Raises ParameterError when the file cannot be read.
        """
        return cls(
            waveform=values['waveform'],
            amplitude=values['amplitude'],
            offset=values['offset'],
            period=values['period'],
            phase=values['phase'],
            onsets=tuple(sorted(values['onsets'])),
            width=values['width'],
            points=read_points(values['file']) if values['waveform'] == 'csv' else (),
        )

    def __call__(self, t: float) -> float:
        """Return v at model time ``t``."""
        return self.offset + self.amplitude * self._shape(t)

    def _shape(self, t: float) -> float:
        if self.waveform == 'sine':
            return math.sin(2.0 * math.pi * (t - self.phase) / self.period)
        if self.waveform == 'square':
            return 1.0 if (t - self.phase) % self.period < self.width else 0.0
        if self.waveform == 'pulses':
            return 1.0 if self._in_pulse(t) else 0.0
        if self.waveform == 'csv':
            return self._interpolate(t)
        return 1.0

    def _in_pulse(self, t: float) -> bool:
        return any(onset <= t < onset + self.width for onset in self.onsets)

    def _interpolate(self, t: float) -> float:
        right = bisect_right(self.points, (t, math.inf))
        if right == 0 or right == len(self.points):
            return self.points[max(right - 1, 0)][1]
        (t0, v0), (t1, v1) = self.points[right - 1], self.points[right]
        return v0 + (t - t0) / (t1 - t0) * (v1 - v0)

    def breaks(self, end: float) -> list[float]:
        """Return the model times in (0, ``end``) at which v or its slope jumps, in order.

        An integrator must not step across them. Raises EventregError when there are more than
        :data:`MAX_BREAKS`.
        """
        times: set[float] = set()
        if self.waveform == 'pulses':
            times = {t for onset in self.onsets for t in (onset, onset + self.width)}
        elif self.waveform == 'square':
            _need_few(2.0 * end / self.period, end)
            first = math.floor(-self.phase / self.period)
            for i in range(first, math.ceil((end - self.phase) / self.period) + 1):
                start = self.phase + i * self.period
                times |= {start, start + self.width}
        elif self.waveform == 'csv':
            times = {t for t, _ in self.points}
        found = sorted(t for t in times if 0.0 < t < end)
        _need_few(len(found), end)
        return found


def _need_few(breaks: float, end: float) -> None:
    if breaks > MAX_BREAKS:
        raise EventregError(
            f'the stimulus jumps {breaks:.4g} times within {end:g} (model time), and a continuous '
            f'integration stops at each of at most {MAX_BREAKS}; take a longer period, fewer '
            'points or a shorter duration, or simulate --sampled'
        )


def read_points(path: str) -> tuple[tuple[float, float], ...]:
    """Read a csv file with the columns t and v (a header line is optional); t must increase.

    Raises ParameterError that names the file and the line.
    """
    points: list[tuple[float, float]] = []
    try:
        lines = read_text(path, MAX_BYTES).splitlines()
        for number, row in enumerate(csv.reader(lines), 1):
            if not row or (number == 1 and row[0].strip() == 't'):
                continue
            points.append(_point(path, number, row, points))
    except (UnreadableError, csv.Error) as error:
        raise ParameterError(
            f'stimulus.file must be a readable csv file, got {shown(path)}: {error}'
        ) from None
    if not points:
        raise ParameterError(
            f'stimulus.file must hold at least one line t,v; {shown(path)} holds none'
        )
    return tuple(points)


def _point(
    path: str, number: int, row: list[str], before: list[tuple[float, float]]
) -> tuple[float, float]:
    try:
        t, v = (float(cell) for cell in row)
    except ValueError:
        t = v = math.nan
    if not (math.isfinite(t) and math.isfinite(v)) or (before and t <= before[-1][0]):
        raise ParameterError(
            f'stimulus.file {shown(path)}, line {number}: must be two finite numbers t,v with t '
            f'increasing, got {shown(",".join(row))}'
        )
    return t, v
