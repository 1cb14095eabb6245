# SPDX-License-Identifier: Apache-2.0
"""The periodic orbit of a generator in antiphase."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...models import NEURON
from .integration import course, integrate
from .layout import Array

CYCLES = 6
"""Cycles after which a generator is on its orbit."""

SLOWEST, FASTEST, ORBITS = 1 / 50, 0.45, 40
"""The range of tau of :func:`orbits`, and how many there are."""

PHASES = 96
"""Parts of a period."""


def period(tau: float) -> float:
    """Return the period (model time) of a generator in antiphase, for 0 < tau < 1.

    The mean over the last of some cycles, each from one passage upwards through 0 to the next.
    """
    h, p = 0.05, (0.0, tau)
    still = np.zeros(int(CYCLES * (25.0 + 2.3 / tau) / h))
    steps = np.full(len(still) - 1, h)
    v, slope = course(NEURON, np.array([1.0, 0.0]), still, still[1:], p, steps)
    n = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))[-CYCLES // 2 :]
    rise = (v[n + 1] - v[n]) / h
    s, before, after = -v[n] / rise / h, rise / slope[n], rise / slope[n + 1]  # t as a cubic of v
    part = s * s * (3.0 - 2.0 * s) + s * (1.0 - s) * ((1.0 - s) * before - s * after)
    passages = h * (n + part)
    return float(np.mean(np.diff(passages)))


class Template(NamedTuple):
    """A generator on its orbit: tau, and the phase at t = 0, a part of the period."""

    tau: float
    phase: float


@dataclass(frozen=True)
class Orbits:
    """The orbits of a grid of tau: ``log_tau`` and ``period`` of shape (n,), ``states`` (n, 2, m).

    The states are those at m equal parts of the period, from a passage of w upwards through 0 on.
    """

    log_tau: Array
    period: Array
    states: Array

    def state(self, template: Template) -> Array:
        """Return the state at t = 0."""
        i = int(np.argmin(np.abs(self.log_tau - np.log(template.tau))))
        where = template.phase % 1.0 * self.states.shape[2]
        wrapped = np.concatenate([self.states[i], self.states[i, :, :1]], axis=1)
        return np.array([np.interp(where, np.arange(wrapped.shape[1]), x) for x in wrapped])


def orbits() -> Orbits:
    """Return the orbits of :data:`ORBITS` tau from SLOWEST to FASTEST, at even steps of its log."""
    log_tau = np.linspace(np.log(SLOWEST), np.log(FASTEST), ORBITS)
    h, still = 0.1, np.zeros((int(3.0 * 130.0 / 0.1), 1))
    p = (0.0, np.exp(log_tau))
    start = np.stack([np.full(ORBITS, 1.0), np.zeros(ORBITS)])
    x = integrate(NEURON, start, still, still[1:], p, np.full(len(still) - 1, h))
    periods, states = [], []
    for i in range(ORBITS):
        v = x[0, :, i]
        n = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))[-2:]
        first, last = n - v[n] / (v[n + 1] - v[n])
        at = first + (last - first) * np.arange(PHASES) / PHASES
        states.append([np.interp(at, np.arange(len(v)), each) for each in x[:, :, i]])
        periods.append(h * (last - first))
    return Orbits(log_tau, np.array(periods), np.array(states))
