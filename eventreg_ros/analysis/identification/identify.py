# SPDX-License-Identifier: Apache-2.0
"""Which generator made a recorded spike train: its tau, and its k where that can be known.

A generator is the paper's exosystem, an oscillator of two neurons. Its signal is compared with the
equations themselves (least squares over tau and the initial state, integrated by the package's own
step), so any rate will do, irregular stamps and gaps too. It is seen directly, as a recorded w, or
through the plant: y without control, or y and u of a loop that runs.

tau is always identifiable. k is so only as long as the two neurons are out of antiphase; in it the
coupling cancels. A signal upside down has the same tau: every generator's signal is odd, w(t + T/2)
= -w(t), for half its period T. All times are model time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...errors import EventregError
from ...models.roles import ROLES
from .antiphase import fit_antiphase
from .apparent import apparent
from .coupling import Coupling, coupling
from .fit import MISFIT
from .layout import Plant
from .mixture import fit_several
from .orbit import period
from .recorded import Recorded, cleaned
from .result import Identifiable, Identification

PLANT = Plant(ROLES['plant'].k, ROLES['plant'].tau)


def identify_generator(
    t: npt.ArrayLike, x: npt.ArrayLike, *, signal: str = 'w', affine: bool = False
) -> Identification:
    """Identify a generator from its own signal, samples ``x`` at ``t`` (model time), shape (n,).

    Times must not decrease; samples that are not finite are left out. With ``affine`` the sensor's
    gain and offset are unknown too. Raises EventregError, one line with the reason, for what is no
    spike train of one generator: no spikes, too few periods, not periodic, sampled too thinly, or
    of another shape.
    """
    return _one(replace(cleaned(signal, t, x), affine=affine))


def identify_from_plant(
    t: npt.ArrayLike,
    y: npt.ArrayLike,
    u: npt.ArrayLike | None = None,
    v: npt.ArrayLike | None = None,
    *,
    plant: Plant | None = PLANT,
    signal: str = 'y',
    affine: bool = False,
) -> Identification:
    """Identify a generator from the y of the plant that it disturbs, all of shape (n,).

    ``u`` (and the open input ``v``) are what else drives the plant, y' being that of a neuron
    driven by w + v - u; leave out what is 0. With ``plant`` None the plant is fitted too: tau is
    right then, but the plant is not reported. Times, ``affine`` (for y without u), and what is
    raised as for :func:`identify_generator`.
    """
    if affine and u is not None:
        raise EventregError(
            f'{signal}: gain and offset cannot be found where u holds it near 0; leave affine '
            f'out, or take a part without control'
        )
    return _one(replace(_through(t, y, u, v, plant, signal), affine=affine))


def identify_generators(
    t: npt.ArrayLike, x: npt.ArrayLike, generators: int, *, signal: str = 'w'
) -> tuple[Identification, ...]:
    """Identify several generators from the sum of their signals, the slowest first.

    k is not sought. Raises EventregError as :func:`identify_generator` does, and where they are not
    separable: too near for the length of the recording, or another number of them.
    """
    return _several(cleaned(signal, t, x), generators)


def identify_generators_from_plant(
    t: npt.ArrayLike,
    y: npt.ArrayLike,
    generators: int,
    u: npt.ArrayLike | None = None,
    v: npt.ArrayLike | None = None,
    *,
    plant: Plant | None = PLANT,
    signal: str = 'y',
) -> tuple[Identification, ...]:
    """Identify several generators from the y of the plant that they disturb together.

    ``u`` is the sum of the control actions; else as :func:`identify_from_plant` and
    :func:`identify_generators`.
    """
    return _several(_through(t, y, u, v, plant, signal), generators)


def _through(
    t: npt.ArrayLike,
    y: npt.ArrayLike,
    u: npt.ArrayLike | None,
    v: npt.ArrayLike | None,
    plant: Plant | None,
    signal: str,
) -> Recorded:
    if plant is not None and not (plant.k > 0.0 and plant.tau > 0.0):
        raise EventregError(
            f'{signal}: the plant must have k > 0 and tau > 0, got {plant.k:g} and {plant.tau:g}; '
            f'leave it out to have it fitted'
        )
    recorded = cleaned(signal, t, y, u, v)
    return replace(recorded, plant=plant or PLANT, plant_known=plant is not None)


def _one(recorded: Recorded) -> Identification:
    seen = apparent(recorded)
    found = coupling(recorded, fit_antiphase(recorded, seen))
    misfit = found.fit.misfit
    if misfit > MISFIT * seen.gain:
        raise EventregError(
            f'{recorded.signal} repeats after {seen.period:.4g} of model time, but is not what a '
            f'generator makes: the best fit leaves {misfit:.2g} (root mean square, noise apart); '
            f'check plant, gain and which part is taken'
        )
    return _result(recorded, found)


def _several(recorded: Recorded, generators: int) -> tuple[Identification, ...]:
    if generators < 2:
        raise EventregError(f'several generators are at least 2, got {generators}; identify one')
    recorded = recorded.settled()
    fit = fit_several(recorded, apparent(recorded, generators), generators)
    found = Coupling(fit, False, 'k is not sought where several generators are in one signal')
    order = np.argsort(fit.unknowns[:generators])
    return tuple(_result(recorded, found, int(i)) for i in order)


def _result(recorded: Recorded, found: Coupling, generator: int = 0) -> Identification:
    fit, sd = found.fit, found.fit.deviations()
    tau = float(np.exp(fit.unknowns[generator]))
    k = k_sd = None
    if found.identifiable:
        where = fit.layout.log_k
        k = float(np.exp(fit.unknowns[where]))
        k_sd = k * float(sd[where])
    gain, offset = fit.unknowns[fit.layout.sensor] if recorded.affine else (1.0, 0.0)
    return Identification(
        tau=tau,
        tau_sd=tau * float(sd[generator]),
        k=k,
        k_sd=k_sd,
        identifiable=Identifiable(tau=True, k=found.identifiable),
        period=period(tau),
        residual_rms=fit.rms,
        signal=recorded.signal,
        reason=found.reason,
        samples=len(recorded.t),
        duration=float(recorded.t[-1]),
        gain=float(gain),
        offset=float(offset),
    )
