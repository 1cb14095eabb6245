# SPDX-License-Identifier: Apache-2.0
"""The report's words: numbers and sentences, and how the numbers are defined."""

from __future__ import annotations

import math

from ..analysis.rejection import ENOUGH
from ..scenario import Criteria


def sentence(reason: str) -> str:
    """Return a reason as a sentence; it begins with a capital letter unless with a signal."""
    first = reason.partition(' ')[0]
    words = first.isalpha() and len(first) > 2
    return (f'{reason[:1].upper()}{reason[1:]}' if words else reason) + '.'


def number(value: float | None) -> str:
    """Return a number to three digits, a dash for None."""
    return '-' if value is None else f'{value:.3g}'


def percent(share: float) -> str:
    """Return a part of a whole in percent; only all of it is 100 %."""
    tenths = math.floor(1000.0 * share)
    return '100 %' if share == 1.0 else f'{tenths / 10.0:.1f} %'


def definitions(settle: float, criteria: Criteria) -> list[tuple[str, str]]:
    """Return what each figure of the report means, as (term, meaning), with the values used."""
    return [
        ('model time', 'the time t of the paper; t = 0 is the first sample of the run.'),
        (
            'event',
            f'a signal rises through the threshold {criteria.threshold:g} after having been at or '
            f'below {criteria.reset:g} (or below the threshold at the start); its time is '
            'interpolated linearly between the two samples.',
        ),
        (
            'preserved, spurious, missed',
            f'events of y from t = {settle:g} on are matched one to one with events of y_r at most '
            f'{criteria.window:g} apart: matched ones are preserved, those of y alone spurious, '
            'those of y_r alone missed. Without a reference every event of y is spurious.',
        ),
        (
            'verdict',
            f'undecided with fewer than {ENOUGH} events of w after settling; otherwise rejected '
            'when no event is spurious and none is missed; undecided instead where something was '
            'not seen.',
        ),
        (
            'unseen',
            f'no finite sample for more than {criteria.blind:g} of model time: what happened there '
            'is not known.',
        ),
        ('ratio of rejection', '1 - spurious events / disturbance events.'),
        (
            'residual, synchronisation',
            'y - y_r (y without a reference) and w - u from settling on, the second signal '
            'interpolated at the times of the first; each interval is weighted by its length.',
        ),
        (
            'CV, CV2, LV',
            'how much the intervals between events vary: 0 for a clock, 1 for a Poisson process. '
            'CV2 and LV compare neighbouring intervals only.',
        ),
        ('width', 'from the rise of an event to its end; the median of them.'),
        (
            'locking',
            'how steady the phase of u between the events of w is: 1 where it stands still, near 0 '
            'where it drifts.',
        ),
        (
            'gap',
            'an interval of 1.5 median periods or more that the next does not make up for: at '
            'least one sample is missing.',
        ),
    ]
