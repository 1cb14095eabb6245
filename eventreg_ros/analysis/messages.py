# SPDX-License-Identifier: Apache-2.0
"""What a run took: messages per second and per event of the disturbance, energy of controls."""

from __future__ import annotations

from typing import NamedTuple

from .verdict import Report


class Messages(NamedTuple):
    """The messages of one signal; ``per_event`` is None where the disturbance has no event."""

    number: int
    per_second: float
    per_event: float | None


def messages(report: Report) -> dict[str, Messages]:
    """Return the messages of every signal of a run that were sent."""
    seconds = report.duration / report.time_scale
    events = _disturbances(report)
    return {
        name: Messages(s.messages, s.messages / seconds, s.messages / events if events else None)
        for name, s in report.signals.items()
        if s.messages is not None and seconds > 0.0
    }


def _disturbances(report: Report) -> int:
    """Return how many events of the disturbance there were in the whole run."""
    names = {name for plant in report.subject.plants for name in plant.disturbances}
    return sum(len(report.signals[name].events) for name in names & report.signals.keys())


def words(report: Report) -> list[str]:
    """Return a line on the messages, and one on the energy, where they are known."""
    sent = [_both(name, s.per_second, s.per_event) for name, s in messages(report).items()]
    energy, events = energies(report), _disturbances(report)
    spent = [_both(name, e, e / events if events else None) for name, e in energy.items()]
    lines = {'messages a second': sent, 'energy of control': spent}
    return [
        f'{what} (per disturbance event): {", ".join(found)}'
        for what, found in lines.items()
        if found
    ]


def energies(report: Report) -> dict[str, float]:
    """Return the integral of the square of every control over the run, in model time."""
    return {name: s.energy for name, s in report.signals.items() if s.energy is not None}


def _both(name: str, value: float, per_event: float | None) -> str:
    return f'{name} {value:.3g}' + ('' if per_event is None else f' ({per_event:.3g})')
