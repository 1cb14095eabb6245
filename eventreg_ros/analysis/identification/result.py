# SPDX-License-Identifier: Apache-2.0
"""What identification returns."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from ...errors import EventregError
from ...printed import Printed


class Identifiable(NamedTuple):
    """What can be known from the recording."""

    tau: bool
    k: bool


class Interval(NamedTuple):
    """A confidence interval."""

    low: float
    high: float


@dataclass(frozen=True, repr=False)
class Identification(Printed):
    """A generator, as far as its recording shows it.

    ``tau`` and ``k`` with their standard deviations, k None where it is not identifiable, which
    ``reason`` explains; ``period`` in model time, what its spikes repeat after; ``residual_rms`` of
    the recorded signal against the fit; ``samples`` and ``duration`` (model time) are what was
    fitted; ``gain`` and ``offset`` are the sensor's, 1 and 0 unless they were asked for;
    ``others`` are the other generators in the same signal, where several were asked for.
    """

    tau: float
    tau_sd: float
    k: float | None
    k_sd: float | None
    identifiable: Identifiable
    period: float
    residual_rms: float
    signal: str
    reason: str
    samples: int
    duration: float
    gain: float = 1.0
    offset: float = 0.0
    others: tuple[Identification, ...] = ()

    def __repr__(self) -> str:
        k = '' if self.k is None else f', k {self.k:g}'
        more = f', and {len(self.others)} more' if self.others else ''
        return f'<Identification from {self.signal}: tau {self.tau:.8g}{k}{more}>'

    def __str__(self) -> str:
        from .words import table

        return table(self)

    @property
    def all(self) -> tuple[Identification, ...]:
        """The generator itself and the others."""
        return (self, *self.others)

    def interval(self, level: float = 0.95) -> Interval:
        """Return the interval that holds the true tau with probability ``level``, 0 < level < 1."""
        return _interval(self.tau, self.tau_sd, level)

    def k_interval(self, level: float = 0.95) -> Interval | None:
        """Return the interval of k, None where it is not identifiable."""
        return None if self.k is None or self.k_sd is None else _interval(self.k, self.k_sd, level)

    def to_dict(self) -> dict[str, object]:
        """Return what ``eventreg identify --json`` writes."""
        others = [other.to_dict() for other in self.others]
        return {
            'tau': self.tau,
            'tau_sd': self.tau_sd,
            'k': self.k,
            'k_sd': self.k_sd,
            'identifiable': self.identifiable._asdict(),
            'period': self.period,
            'residual_rms': self.residual_rms,
            'signal': self.signal,
            **({'others': others} if others else {}),
        }


def _interval(value: float, sd: float, level: float) -> Interval:
    """Return the interval of a value whose logarithm is normally distributed."""
    if not 0.0 < level < 1.0:
        raise EventregError(f'level must be between 0 and 1, got {level:g}; 0.95 is usual')
    factor = float(np.exp(NormalDist().inv_cdf(0.5 + 0.5 * level) * sd / value))
    return Interval(value / factor, value * factor)
