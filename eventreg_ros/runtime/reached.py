# SPDX-License-Identifier: Apache-2.0
"""How a participant of lockstep signs what it reports: with its name and its rate."""

from __future__ import annotations


def signature(name: str, rate: float) -> str:
    """Return what goes into the frame_id of a report."""
    return f'{name} {rate!r}'


def signed_by(frame: str) -> tuple[str, float | None]:
    """Return (name, rate) from a frame_id; the rate is None where none was given."""
    name, _, rate = frame.partition(' ')
    try:
        return name, float(rate)
    except ValueError:
        return name, None
