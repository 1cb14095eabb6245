# SPDX-License-Identifier: Apache-2.0
"""Several generators in one signal: where the fit of all of them starts.

Each tau has one periodic orbit, so one template; what is left open is its phase. Templates are
taken out of the signal one by one, the one that explains most first, and then each again and again
while the others are held, until nothing changes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...errors import EventregError
from .antiphase import extended
from .apparent import Apparent
from .fit import MISFIT, Fit, solve
from .layout import Array
from .orbit import ORBITS, PHASES, Template, orbits
from .recorded import Recorded

HARMONICS = np.arange(1, 12, 2)
"""An orbit is odd, so only odd harmonics are in it."""

DRIFT = 0.2
"""Neighbouring templates drift apart by this part of a period over the recording."""

ROUNDS = 8


APART = 4.0
"""Standard deviations between the ln tau of two generators that count as different."""


def fit_several(recorded: Recorded, seen: Apparent, generators: int) -> Fit:
    """Return the fit of several generators, each in antiphase, the slowest first.

    Raises EventregError where they are not separable.
    """
    templates = Search(seen.t, seen.w).find(generators)
    states = [state for _, state in templates]
    own = np.concatenate([[np.log(template.tau) for template, _ in templates], *states])
    layout = replace(recorded.layout, generators=generators)
    fit = solve(recorded, layout, extended(recorded, seen, own), (4.0 * seen.period,))
    _check(recorded.signal, fit, seen.gain)
    return fit


def _check(name: str, fit: Fit, gain: float) -> None:
    count = fit.layout.generators
    log_tau = fit.unknowns[:count]
    found = ', '.join(f'{tau:.3g}' for tau in np.exp(-log_tau))
    if fit.misfit > MISFIT * gain:
        raise EventregError(
            f'{name} is not separable into {count} generators: the best fit, with 1/tau {found}, '
            f'leaves {fit.misfit:.2g} (root mean square, noise apart); record longer, or ask for '
            f'another number'
        )
    order = np.argsort(log_tau)
    sd = fit.deviations()[:count][order]
    apart = np.diff(log_tau[order]) / np.hypot(sd[1:], sd[:-1])
    if not (apart > APART).all():
        raise EventregError(
            f'{name}: {count} generators are not separable: 1/tau {found} are too near for '
            f'{fit.t[-1]:.4g} of model time; record longer'
        )


class Search:
    """Looks for templates in a smoothed signal ``w`` at ``t``, both of shape (n,)."""

    def __init__(self, t: Array, w: Array) -> None:
        self._t, self._w, self._orbits = t, w, orbits()
        known = self._orbits
        fewest = int(np.ceil(np.log(known.period.max() / known.period.min()) * t[-1]))
        steps = int(fewest / (DRIFT * known.period.min()))
        self._log_tau = np.linspace(known.log_tau[0], known.log_tau[-1], max(steps, 4 * ORBITS))
        self._period = np.interp(self._log_tau, known.log_tau, known.period)
        series = np.fft.rfft(known.states[:, 0], axis=1)[:, HARMONICS] / PHASES
        self._series = np.stack(
            [np.interp(self._log_tau, known.log_tau, c.real)
             + 1j * np.interp(self._log_tau, known.log_tau, c.imag) for c in series.T], axis=1
        )  # fmt: skip
        angle = 2j * np.pi * t[:, None] / self._period
        turns = np.exp(-angle)
        square = turns * turns
        powers = [turns]
        for _ in HARMONICS[1:]:
            powers.append(powers[-1] * square)
        self._waves = np.stack(powers)
        phases = np.arange(PHASES) / PHASES
        self._turned = np.exp(2j * np.pi * HARMONICS[:, None] * phases)

    def find(self, generators: int) -> list[tuple[Template, Array]]:
        """Return so many templates and their states at t = 0, which together explain the most."""
        found: list[tuple[int, int]] = []
        for count in range(1, generators + 1):
            found.append(self._best(found))
            for _ in range(ROUNDS if count > 1 else 0):
                before = list(found)
                for i in range(count):
                    found[i] = self._best(found[:i] + found[i + 1 :])
                if found == before:
                    break
        templates = [
            Template(float(np.exp(self._log_tau[i])), phase / PHASES) for i, phase in found
        ]
        return [(template, self._orbits.state(template)) for template in templates]

    def _best(self, others: list[tuple[int, int]]) -> tuple[int, int]:
        """Return (tau, phase), as indices, of the template that explains most beside ``others``."""
        left = self._w - sum((self._signal(*each) for each in others), np.zeros_like(self._w))
        sums = np.einsum('mnk,n->km', self._waves, left)
        match = 2.0 * ((self._series * sums.conj()) @ self._turned).real
        power = 2.0 * np.sum(np.abs(self._series) ** 2, axis=1) * len(left)
        explained = 2.0 * match - power[:, None]
        i, phase = np.unravel_index(int(np.argmax(explained)), explained.shape)
        return int(i), int(phase)

    def _signal(self, i: int, phase: int) -> Array:
        """Return a template's w."""
        c = self._series[i] * self._turned[:, phase]
        return 2.0 * np.real(c @ self._waves[:, :, i].conj())  # type: ignore[no-any-return]
