# SPDX-License-Identifier: Apache-2.0
"""A report as a short plain table for a terminal; it ends with the verdict."""

from __future__ import annotations

from . import changes, learning, messages
from .signal import Size
from .verdict import PlantReport, Report


def table(report: Report) -> str:
    """Return the report as a short plain table whose last lines are reason and verdict."""
    lines = [_head(report), *_signals(report)]
    for each in report.plants:
        lines += _plant(each, len(report.plants) > 1)
    lines += map(learning.words, report.learned)
    lines += [changes.words(report.changes)] if report.changes else []
    lines += messages.words(report)
    return '\n'.join([*lines, report.reason, f'verdict: {report.verdict}'])


def _head(report: Report) -> str:
    start, stop = report.evidence.span
    words = f'{report.scenario}: {report.duration:.1f} model time units, counted after {start:g}'
    return words if stop in (report.duration, start) else f'{words}, until {stop:g}'


def _signals(report: Report) -> list[str]:
    start, stop = report.evidence.span
    after = f'after {start:g}'
    lines = [f'{"signal":>8} {"samples":>8} {"min":>9} {"max":>9} {"events":>7} {after:>10}']
    for name, s in report.signals.items():
        counted = sum(start <= t <= stop for t in s.events)
        if s.min is None or s.max is None:
            lines.append(f'{name:>8} {s.samples:8d}{" none of them finite" if s.samples else ""}')
            continue
        lines.append(
            f'{name:>8} {s.samples:8d} {s.min:9.3g} {s.max:9.3g} {len(s.events):7d} {counted:10d}'
        )
    return lines


def _plant(report: PlantReport, several: bool) -> list[str]:
    plant, r = report.plant, report.rejection
    words = [f'disturbance events {r.disturbance_events}']
    if plant.reference is not None:
        words += [f'reference events {r.reference_events}', f'preserved {r.preserved}']
    words.append(f'spurious {r.spurious}')
    if plant.reference is not None:
        words.append(f'missed {r.missed}')
    if r.ratio is not None:
        words.append(f'rejection ratio {r.ratio:.2f}')
    lines = [(f'{plant.output}: ' if several else '') + ', '.join(words)]
    against = plant.output + ('' if plant.reference is None else f' - {plant.reference}')
    lines += _size(f'residual {against}', report.residual)
    left = ' + '.join(plant.disturbances) + ''.join(f' - {u}' for u in plant.controls)
    return lines + _size(f'synchronisation {left}', report.synchronisation)


def _size(name: str, size: Size) -> list[str]:
    if size.max_abs is None or size.rms is None:
        return []
    return [f'{name}: max {size.max_abs:.3g}, rms {size.rms:.3g}']
