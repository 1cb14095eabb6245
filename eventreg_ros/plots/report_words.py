"""The report's words: what the verdict means, how the numbers are defined."""

from __future__ import annotations

from ..analysis.decision import count
from ..analysis.rejection import ENOUGH, REJECTED, UNDECIDED
from ..analysis.verdict import Report
from ..scenario import Criteria


def in_words(report: Report) -> str:
    """Return what the verdict means for this run, in one or two sentences."""
    r, settle = report.rejection, report.settle
    events = count(r.disturbance_events, 'event')
    if report.verdict == UNDECIDED and r.verdict != UNDECIDED:
        return f'{report.reason[:1].upper()}{report.reason[1:]}.'
    if report.verdict == UNDECIDED:
        return (
            f'The disturbance had {events} after t = {settle:g}: at least {ENOUGH} are needed to '
            'judge. Run for longer, or count from an earlier time with --settle.'
        )
    reference = r.reference_events
    if report.verdict == REJECTED:
        asked = f' The {count(reference, "event")} that the reference asks for came.'
        return (
            f'After t = {settle:g} the disturbance had {events}, and none of them made the plant '
            'spike.' + (asked if reference else '')
        )
    faults = [f'Not asked for: {count(r.spurious, "event")} of y.'] if r.spurious else []
    if r.missed:
        faults.append(f'Missing: {count(r.missed, "event")} that the reference asks for.')
    return ' '.join([f'After t = {settle:g} the disturbance had {events}.', *faults])


def number(value: float | None) -> str:
    """Return a number to three digits, a dash for None."""
    return '-' if value is None else f'{value:.3g}'


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
            'when no event is spurious and none is missed.',
        ),
        ('ratio of rejection', '1 - spurious events / disturbance events.'),
        (
            'residual, synchronisation',
            'y - y_r (y without a reference) and w - u from settling on, the second signal '
            'interpolated at the times of the first; the rms weighs each interval by its length.',
        ),
        (
            'gap',
            'an interval of 1.5 median periods or more that the next does not make up for: at '
            'least one sample is missing.',
        ),
    ]
