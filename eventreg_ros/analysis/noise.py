# SPDX-License-Identifier: Apache-2.0
"""Whether a recorded signal is noisy, and which limits of the event detector help.

Noise on a signal shows in two ways: the threshold is crossed again before the signal was at reset,
and some rises end sooner than a spike can. White noise around a level at or below reset leaves it
upwards with probability 1/2 at each sample, so that of n samples hardly a rise lasts longer than
log2(n) of them. That is the scale by which rises are called short. A mean over as many samples
shows the spikes without the noise; the limits are put between the two scales. Noise that is
correlated over longer than a few samples looks like a signal, and is not recognised.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..scenario.criteria import Criteria
from .events import Rises, detect, finite, rises

Array = npt.NDArray[np.float64]

SPARE = 2.0
"""Samples beyond log2(n) for which noise alone may hold a signal up: once in four runs."""

CLEAN, COARSE = 0.02, 0.7
"""Noise of less than the one, or more than the other, of the way from rest to threshold is not
judged: it does no harm, or the signal is sampled so coarsely that its changes look like noise."""

EXPLAINED = 2.0
"""At most so many times as many samples reach the threshold as white noise makes on average."""

MANY = 100_000
"""Samples enough for a median."""

HYSTERESIS = 4.0
"""Standard deviations of noise that should lie between threshold and reset."""


@dataclass(frozen=True)
class Widths:
    """The distribution of the widths of a signal's rises, in model time; None without any."""

    count: int
    least: float | None
    median: float | None
    largest: float | None


@dataclass(frozen=True)
class Suggestion:
    """Limits that keep noise out, why, and how many events are left with them."""

    criteria: Criteria
    reasons: tuple[str, ...]
    events: int


@dataclass(frozen=True)
class Noise:
    """What noise does to the events of one signal.

    ``sd`` is the standard deviation of white noise on it, None where it cannot be estimated.
    ``crossings`` of the threshold upwards, ``recrossings`` those without a crossing of reset since
    the last, ``short`` rises that noise alone may make, those of less than ``scale`` (model time).
    """

    sd: float | None
    scale: float
    crossings: int
    recrossings: int
    short: int
    events: int
    widths: Widths
    noisy: bool
    suggestion: Suggestion | None


def examine(t: Array, x: Array, criteria: Criteria | None = None) -> Noise:
    """Return what noise does to the events of a signal, ``x`` at ``t``, both of shape (n,).

    ``t`` in model time, not decreasing. Without ``criteria`` the contract's.
    """
    limits = criteria or Criteria()
    t, x = finite(t, x)
    found = rises(t, x, limits.threshold, limits.reset)
    sd, scale = noise_level(x), _scale(t)
    high = x >= limits.threshold
    crossings = int(np.count_nonzero(high[1:] & ~high[:-1]))
    recrossings = crossings - len(found.start)
    short = int(np.count_nonzero(found.width < scale))
    noisy, suggestion = False, None
    if sd is not None and recrossings + short > 0 and _matters(sd, x, limits):
        spikes = _spikes(t, x, limits, scale)
        noisy = len(spikes.start) > 0 or _explains(sd, x, limits)
        suggestion = _suggest(t, x, limits, sd, scale, spikes) if noisy else None
    return Noise(
        sd=sd,
        scale=scale,
        crossings=crossings,
        recrossings=recrossings,
        short=short,
        events=len(found.events(limits.refractory, limits.min_width)),
        widths=_widths(found.width),
        noisy=noisy,
        suggestion=suggestion,
    )


def _matters(sd: float, x: Array, limits: Criteria) -> bool:
    way = limits.threshold - _rest(x, limits)
    return CLEAN * way < sd < COARSE * way


def _explains(sd: float, x: Array, limits: Criteria) -> bool:
    """Say whether so many samples reach the threshold as white noise around rest makes."""
    share = 0.5 * math.erfc((limits.threshold - _rest(x, limits)) / (sd * math.sqrt(2.0)))
    return float(np.mean(x >= limits.threshold)) <= EXPLAINED * share + 1.0 / len(x)


def _spikes(t: Array, x: Array, limits: Criteria, scale: float) -> Rises:
    """Return the rises of the smoothed signal that were seen whole and outlast noise."""
    smooth = rises(*_smoothed(t, x), limits.threshold, limits.reset)
    whole = np.isfinite(smooth.end) & (smooth.width >= scale)
    return Rises(smooth.start[whole], smooth.end[whole], smooth.width[whole])


def noise_level(x: Array) -> float | None:
    """Return the standard deviation of white noise on ``x``, shape (n,).

    From the median size of second differences, which a slow signal and its spikes leave alone. None
    for fewer than ten samples, and where they overflow.
    """
    if len(x) < 10:
        return None
    every = 1 + len(x) // MANY
    with np.errstate(over='ignore', invalid='ignore'):
        bends = x[:-2:every] - 2.0 * x[1:-1:every] + x[2::every]
        size = float(np.median(np.abs(bends)))
    return size / (0.6745 * math.sqrt(6.0)) if math.isfinite(size) else None


def words(name: str, noise: Noise) -> str:
    """Return a line on the noise of signal ``name``, and one with the reasons for what it suggests.

    Empty where there is nothing to say.
    """
    if not noise.noisy or noise.sd is None:
        return ''
    line = (
        f'{name} is noisy (sd {noise.sd:.2g}): {noise.crossings} crossings of threshold, '
        f'{noise.recrossings} of them without reset between; {noise.short} of '
        f'{noise.widths.count} rises shorter than {noise.scale:.2g}'
    )
    if noise.suggestion is None:
        return f'{line}; no event depends on it'
    limits = noise.suggestion.criteria
    return (
        f'{line}; {noise.events} events, {noise.suggestion.events} with min_width '
        f'{limits.min_width:g}, refractory {limits.refractory:g}, reset {limits.reset:g}\n'
        f'  because {"; ".join(noise.suggestion.reasons)}'
    )


def table(signals: Mapping[str, tuple[Array, Array]], criteria: Criteria | None = None) -> str:
    """Return :func:`words` on every signal, (t, values) with t in model time; empty if clean."""
    lines = [words(name, examine(t, x, criteria)) for name, (t, x) in signals.items()]
    return '\n'.join(line for line in lines if line)


def _suggest(
    t: Array, x: Array, old: Criteria, sd: float, scale: float, spikes: Rises
) -> Suggestion | None:
    """Put the limits between the noise and the spikes."""
    reasons = [f'noise alone lasts up to {scale:.2g}']
    if len(spikes.start):
        usual = float(np.median(spikes.width))
        shortest = float(np.diff(spikes.start).min(initial=math.inf))
        min_width = _rounded(math.sqrt(scale * usual))
        refractory = _rounded(min(usual + 2.0 * scale, 0.5 * shortest))
        limits = replace(old, min_width=min_width, refractory=refractory)
        reasons.append(f'a spike lasts {usual:.3g}: min_width {min_width:g}, between them')
        reasons.append(f'no second event within a spike: refractory {refractory:g}')
    else:
        limits = replace(old, min_width=_rounded(max(2.0 * scale, old.min_width)))
        reasons.append(f'no spike lasts longer: min_width {limits.min_width:g}, twice that')
    reset = _rounded(max(old.threshold - HYSTERESIS * sd, _rest(x, old)))
    if reset < old.reset - sd:  # not below rest: noise there must soon end what it began
        limits = replace(limits, reset=reset)
        reasons.append(f'noise leaps from threshold to reset: reset {reset:g}, at rest or above')
    return _unless_idle(t, x, old, limits, tuple(reasons))


def _unless_idle(
    t: Array, x: Array, old: Criteria, new: Criteria, reasons: tuple[str, ...]
) -> Suggestion | None:
    """Return the suggestion, or None when every event stays what it is."""
    now, then = (detect(t, x, *c.detector) for c in (old, new))
    return None if now == then else Suggestion(new, reasons, len(then))


def _rest(x: Array, limits: Criteria) -> float:
    """Return the level between spikes: the median of what is below the threshold."""
    below = x[x < limits.threshold]
    return float(np.median(below)) if len(below) else limits.reset


def _smoothed(t: Array, x: Array) -> tuple[Array, Array]:
    """Return means over as many samples as noise may last, at the mean times."""
    size = min(math.ceil(math.log2(len(x)) + SPARE), len(x))
    with np.errstate(over='ignore', invalid='ignore'):  # what overflows is passed over
        sums = [np.concatenate(([0.0], np.cumsum(a))) for a in (t - t[0], x)]
        times, means = ((s[size:] - s[:-size]) / size for s in sums)
    return times + t[0], means


def _scale(t: Array) -> float:
    """Return how long noise alone may hold a signal up, in model time."""
    if len(t) < 2:
        return 0.0
    every = 1 + len(t) // MANY
    return float(np.median(t[1::every] - t[:-1:every])) * (math.log2(len(t)) + SPARE)


def _widths(width: Array) -> Widths:
    if len(width) == 0:
        return Widths(0, None, None, None)
    return Widths(len(width), float(width.min()), float(np.median(width)), float(width.max()))


def _rounded(value: float) -> float:
    """Return ``value`` with two significant digits, as people type it."""
    return float(f'{value:.2g}')
