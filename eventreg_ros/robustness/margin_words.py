# SPDX-License-Identifier: Apache-2.0
"""Margins in words and as JSON: the table of ``eventreg margin`` and what its --json writes."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from ..scenario import Scenario
from .evaluator import Setting
from .margins import Limit, Map

QUANTILE = 1.959964
"""Of the normal distribution, for an interval that holds in 95 of 100 cases."""


def result(
    scenario: Scenario, setting: Setting, limits: list[Limit], found: Map | None
) -> dict[str, Any]:
    """Return what --json writes."""
    holds: dict[str, dict[str, Any]] = {}
    for limit in limits:
        entry = asdict(limit)
        kind, hold, on = (entry.pop(key) for key in ('kind', 'hold', 'on'))
        if limit.lead is None:
            del entry['lead']
        entry['milliseconds'] = milliseconds(limit, scenario)
        of_hold = holds.setdefault(hold, {})
        if isinstance(on, str):
            of_hold.setdefault(f'{kind}_of', {})[on] = entry
        elif on is not None:
            of_hold[kind if kind not in of_hold else f'{kind}_at_lead'] = {**entry, 'on': list(on)}
        else:
            of_hold[kind if kind not in of_hold else f'{kind}_at_rate'] = entry
    for of_hold in holds.values():
        of_hold.setdefault('delay_at_rate', of_hold['delay'])
    report: dict[str, Any] = {
        'scenario': scenario.name,
        'time_scale': scenario.time_scale,
        'duration': setting.duration,
        'settle': setting.settle,
        'window': setting.window,
        'seeds': setting.seeds,
        'holds': holds,
    }
    if found is not None:
        report['map'] = {
            'rate': found.rate,
            'h': found.h,
            'delays': [round(delay, 12) for delay in found.delays.tolist()],
            'losses': [round(loss, 12) for loss in found.losses.tolist()],
            'rejected': {hold: share.tolist() for hold, share in found.rejected.items()},
        }
    return report


def milliseconds(limit: Limit, scenario: Scenario) -> float | None:
    """Return the largest delay or jitter as a time at the scenario's time_scale."""
    if limit.largest is None or limit.kind == 'loss':
        return None
    return round(1000.0 * limit.largest / scenario.time_scale, 9)


def table(scenario: Scenario, setting: Setting, limits: list[Limit]) -> str:
    """Return the limits as a short plain table, one row per impairment, one column per hold."""
    holds = list(dict.fromkeys(limit.hold for limit in limits))
    seeds = f'{setting.seeds} seed{"s" if setting.seeds != 1 else ""}'
    least = f'so at least {100.0 * least_share(setting.seeds):.0f} % of all runs'
    lines = [
        f'{scenario.name}: the largest that the loop tolerates, on every link or on those of one '
        f'signal (time_scale {scenario.time_scale:g}, {setting.duration:g} model time units, '
        f'counted after {setting.settle:g}; loss and jitter: every one of {seeds}, {least})',
        f'{"":12}' + ''.join(f'{f"hold {hold}":>20}' for hold in holds) + f'{"resolution":>12}  at',
    ]
    for name, rate in dict.fromkeys((limit.name, limit.rate) for limit in limits):
        row = [limit for limit in limits if (limit.name, limit.rate) == (name, rate)]
        cells = ''.join(f'{words(limit, scenario):>20}' for limit in row)
        at = f'{row[0].rate:g} samples per second (h = {row[0].h:g})'
        lines.append(f'{name:12}{cells}{row[0].resolution:>12g}  {at}')
    return '\n'.join([*lines, *notes(limits)])


def least_share(seeds: int) -> float:
    """Return the least part of all runs that are rejected, where those of all ``seeds`` are.

    The lower end of Wilson's interval at 95 %.
    """
    return seeds / (seeds + QUANTILE**2)


def words(limit: Limit, scenario: Scenario) -> str:
    """Return the cell of one limit."""
    if limit.largest is None:
        return 'none'
    text = f'{limit.largest:g}' if limit.fails_at is not None else f'>= {limit.largest:g}'
    time = milliseconds(limit, scenario)
    return text if time is None else f'{text} ({time:g} ms)'


def notes(limits: list[Limit]) -> list[str]:
    """Return what must be said about single limits, one line each."""
    lines = [
        f'{limit.name}, hold {limit.hold}: rejected again at '
        f'{", ".join(f"{value:g}" for value in limit.rejected_again)}: the verdict is not monotone'
        for limit in limits
        if limit.rejected_again
    ]
    for limit in limits:
        if isinstance(limit.on, tuple) and isinstance(limit.lead, float):
            lines.append(
                f'delay: of {" and ".join(limit.on)}, with the lead raised to it; {limit.name}: '
                'the same with the lead as it is'
            )
            break
    if any(limit.largest is None for limit in limits):
        lines.append('none: the verdict is not rejected even without delay, loss and jitter')
    if any(limit.fails_at is None for limit in limits):
        lines.append('>=: nothing failed as far as was searched')
    return lines
