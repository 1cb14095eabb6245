# SPDX-License-Identifier: Apache-2.0
"""Whether a recording shows k: only while the generator's two neurons are out of antiphase.

In antiphase the coupling cancels, so w does not depend on k at all. A generator that was recorded
from its start may be out of it for some ten units of model time; then the oscillator with four
states fits better than one neuron does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .fit import ROUGH, Fit, descend, solve
from .layout import Array, Layout
from .recorded import Recorded

LEAST_F, LEAST_SCORE = 4.0, 5.0
LEAST_EFFECT = 1e-5
LARGEST_SD = 0.3
"""k is identifiable if the F statistic of the fit out of antiphase, the root mean square of
d w / d ln k and the standard deviation of ln k are on the right side of these."""

LIKELY = 9.0
"""Fits whose sums of squares differ by less than this, in variances, are about as good."""

FAITHFUL, HELD = 1e-6, 5e-4
"""Residuals smaller than these (root mean square) are the integration's, and through a plant also
those of how it holds its inputs between samples: there is nothing to add."""

ATTEMPT = 10
"""Evaluations that a start out of antiphase is given."""

TRIED = (0.7, 1.5, 4.0)
TRANSIENT = 30.0
"""Model time in which a start out of antiphase is looked for."""


@dataclass(frozen=True)
class Coupling:
    """The fit that holds, and whether it shows k, with the reason in words."""

    fit: Fit
    identifiable: bool
    reason: str


def coupling(recorded: Recorded, antiphase: Fit) -> Coupling:
    """Decide between antiphase and not, and whether k is identifiable."""
    f = _score(recorded, antiphase)
    if f < LEAST_SCORE:
        return Coupling(antiphase, False, _in_antiphase(f, LEAST_SCORE))
    fit, rivals = _out_of_antiphase(recorded, antiphase)
    f = f_statistic(antiphase, fit)
    if f < LEAST_F:
        return Coupling(antiphase, False, _in_antiphase(f, LEAST_F))
    where = fit.layout.log_k
    effect = float(np.sqrt(np.mean(fit.jacobian[:, where] ** 2)))
    sd = float(fit.deviations()[where])
    if effect < LEAST_EFFECT:
        reason = f'k changes what was recorded by {effect:.1g} only, less than {LEAST_EFFECT:g}'
    elif sd > LARGEST_SD:
        reason = (
            f'the generator starts out of antiphase, but what that shows of k is too little: the '
            f'standard deviation of ln k is {sd:.2g}, more than {LARGEST_SD:g}'
        )
    elif fit.unknowns[where] > fit.layout.bounds[1][where] - 0.1:
        reason = 'the generator starts out of antiphase, but k is too large to be seen in it'
    elif rivals:
        reason = (
            f'the generator starts out of antiphase, but k = {np.exp(rivals[0]):.2g} explains that '
            f'as well as k = {np.exp(fit.unknowns[where]):.2g}'
        )
    else:
        return Coupling(
            fit, True, f'the generator starts out of antiphase, which shows k (F = {f:.3g})'
        )
    return Coupling(fit, False, reason)


def _in_antiphase(f: float, least: float) -> str:
    return (
        f'in antiphase the coupling cancels, so w does not depend on k, and nothing recorded shows '
        f'the generator out of antiphase (F = {f:.2g}, less than {least:g})'
    )


def f_statistic(without: Fit, with_more: Fit) -> float:
    """Return the F statistic of what ``with_more`` unknowns explain beyond ``without``.

    Residuals that are correlated count as fewer.
    """
    more = with_more.layout.size - without.layout.size
    gain = without.squares - with_more.squares
    return gain / more / (with_more.squares / with_more.free) / with_more.repetition


def _score(recorded: Recorded, antiphase: Fit) -> float:
    """Return the F statistic that leaving antiphase a little would have, k being one of TRIED."""
    if antiphase.rms < (FAITHFUL if recorded.plant is None else HELD):
        return 0.0
    layout = replace(antiphase.layout, antiphase=False)
    forward = recorded.forward(layout, ROUGH)
    base, _ = np.linalg.qr(antiphase.jacobian)
    found = [0.0]
    for k in TRIED:
        second = range(layout.states(0).start + 2, layout.states(0).stop)
        more = forward.jacobian(_coupled(antiphase, k), second)
        more, _ = np.linalg.qr(more - base @ (base.T @ more))
        part = more.T @ antiphase.residual
        left = replace(antiphase, residual=antiphase.residual - more @ part)
        found.append(float(part @ part) / 2.0 / (left.squares / left.free) / left.repetition)
    return max(found)


def _coupled(antiphase: Fit, k: float) -> Array:
    """Return the unknowns of the oscillator in antiphase that moves as ``antiphase``."""
    own, unknowns = antiphase.layout, antiphase.unknowns
    first = unknowns[own.states(0)]
    rest = unknowns[own.plant_state.start :]
    return np.concatenate([unknowns[:1], [np.log(k)], first, -first, rest])


def _out_of_antiphase(recorded: Recorded, antiphase: Fit) -> tuple[Fit, list[float]]:
    """Return the best fit of an oscillator that need not be in antiphase.

    And each ln k far from its own that explains the beginning about as well.
    """
    layout = replace(antiphase.layout, antiphase=False)
    begin = recorded.beginning(TRANSIENT, 4 * layout.size)
    forward = begin.forward(layout, ROUGH)
    ends = [descend(forward, begin.x, at, ATTEMPT) for at in _starts(begin, layout, antiphase)]
    squares = [float(np.sum((forward.predict(end) - begin.x) ** 2)) for end in ends]
    first = int(np.argmin(squares))
    best = solve(recorded, layout, ends[first], ())
    where = layout.log_k
    likely = squares[first] + LIKELY * best.squares / best.free
    values = [float(end[where]) for end, sum_ in zip(ends, squares, strict=True) if sum_ < likely]
    return best, [k for k in values if abs(k - ends[first][where]) > LARGEST_SD]


def _starts(begin: Recorded, layout: Layout, antiphase: Fit) -> list[Array]:
    """Return, for each k of TRIED, the best of a grid over the four states, and antiphase."""
    where = layout.states(0)
    states = np.meshgrid(*(np.linspace(-2.0, 2.0, 5),) * 4)
    sample = begin.part(np.unique(np.floor(begin.t / ROUGH), return_index=True)[1])
    forward = sample.forward(layout, ROUGH)
    found = []
    for k in TRIED:
        lanes = np.repeat(_coupled(antiphase, k)[:, None], states[0].size, axis=1)
        lanes[where] = [each.ravel() for each in states]
        with np.errstate(all='ignore'):
            errors = np.sum((forward.predict(lanes) - sample.x[:, None]) ** 2, axis=0)
        found.append(lanes[:, np.argmin(np.nan_to_num(errors, nan=np.inf))])
    return [*found, _coupled(antiphase, 1.0)]
