"""In how many messages signals came: per second, and per event of the disturbance."""

from __future__ import annotations

from typing import NamedTuple

from .verdict import Report


class Messages(NamedTuple):
    """The messages of one signal; ``per_event`` is None where the disturbance has no event."""

    number: int
    per_second: float
    per_event: float | None


def messages(report: Report) -> dict[str, Messages]:
    """Return the messages of every recorded signal of a run."""
    seconds = report.duration / report.time_scale
    disturbances = {name for plant in report.subject.plants for name in plant.disturbances}
    known = disturbances & report.signals.keys()
    events = sum(len(report.signals[name].events) for name in known)
    return {
        name: Messages(s.samples, s.samples / seconds, s.samples / events if events else None)
        for name, s in report.signals.items()
        if s.timing is not None and seconds > 0.0
    }


def words(report: Report) -> str:
    """Return them in a line."""
    found = [
        f'{name} {each.per_second:.3g}'
        + (f' ({each.per_event:.3g})' if each.per_event is not None else '')
        for name, each in messages(report).items()
    ]
    return f'messages a second (per event of the disturbance): {", ".join(found)}' if found else ''
