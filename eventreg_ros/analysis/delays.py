# SPDX-License-Identifier: Apache-2.0
"""When a recorded run came near its delay margin, as its spike monitor published it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..bags.finding import Finding
from ..bags.statuses import read_statuses
from .recorded import Analysis

VERDICT, MARGIN_USED = 'verdict', 'margin_used'
"""The monitor's topic, and its key for the largest part of the margin used so far."""

PARTS = (0.5, 1.0)
"""Parts of the margin that are noted when a delay reaches them for the first time."""

DELAY = 'delay'
"""The code of such a finding."""


def delay_findings(bag: str | Path, analysis: Analysis) -> list[Finding]:
    """Return when a delay took a half, and all, of the delay margin for the first time.

    Empty where the bag does not say it. Raises BagError where ``bag`` cannot be read any more.
    """
    topics = analysis.recording.topics
    outputs = [topics[p.output] for p in analysis.subject.plants if p.output in topics]
    if not outputs:
        return []
    topic = f'{outputs[0].rpartition("/")[0]}/{VERDICT}'
    start, scale = analysis.recording.start, analysis.time_scale
    return reached((s.values, (s.stamp - start) * scale / 1e9) for s in read_statuses(bag, topic))


def reached(said: Iterable[tuple[dict[str, str], float]]) -> list[Finding]:
    """Return the findings on statuses, keys and values with their model times, in order."""
    found: list[Finding] = []
    noted = 0
    for values, at in said:
        used = float(values.get(MARGIN_USED, 0.0))
        if (parts := sum(used >= part for part in PARTS)) > noted:
            noted = parts
            text = f'the longest delay so far was {used:.2f} times the delay margin'
            found.append(Finding(DELAY, None, at, text))
    return found
