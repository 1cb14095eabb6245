# SPDX-License-Identifier: Apache-2.0
"""Many runs at once: cases sorted into lanes, run, and judged; or one by one where that must be."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..analysis.rejection import UNDECIDED
from ..analysis.subject import Subject
from ..errors import EventregError
from ..simulation.impairment import Impairment
from ..simulation.jit import compiles
from ..simulation.lanes import Start, structure_of
from ..simulation.lanes_source import LANES
from ..simulation.loop import Loop
from ..simulation.model_time import count_steps
from ..simulation.noise import SILENCE, Noise
from ..simulation.sampled import not_finite
from .lane_group import Group, Template
from .outcome import VERDICTS, Case, Outcomes, nothing, one_by_one

MANY = 128
"""Sets that diverge for which it pays to look in lanes when they do, by code of its own."""

MOST = 1 << 30
"""Bytes that one block of lanes may take; longer runs go one by one."""


def run(cases: Sequence[Case], pool: ThreadPoolExecutor | None = None) -> Outcomes:
    """Run cases of any kind and judge them, in lanes where they can be."""
    rows, reasons = nothing(len(cases)), dict[int, str]()
    groups: dict[Any, list[int]] = defaultdict(list)
    for i, case in enumerate(cases):
        groups[_kind(case)].append(i)
    for key, places in groups.items():
        members = [cases[i] for i in places]
        found = _run_alone(members, pool) if key is None else _run_group(members, pool)
        rows[places] = found.rows
        reasons |= {places[i]: reason for i, reason in found.reasons.items()}
    return Outcomes(rows, reasons)


def _run_alone(cases: Sequence[Case], pool: ThreadPoolExecutor | None) -> Outcomes:
    rows, reasons = nothing(len(cases)), dict[int, str]()
    found = pool.map(one_by_one, cases) if pool else map(one_by_one, cases)
    for i, (row, reason) in enumerate(found):
        rows[i] = row
        if reason:
            reasons[i] = reason
    return Outcomes(rows, reasons)


def _run_group(cases: Sequence[Case], pool: ThreadPoolExecutor | None) -> Outcomes:
    first = cases[0]
    template = Template(first.loop, first.subject, first.duration)
    start = Start.of([list(case.loop.blocks.values()) for case in cases])
    noises = [case.noise for case in cases]
    return run_alike(template, start, [case.impairment for case in cases], noises, pool)


def _kind(case: Case) -> Any:
    """Return what the cases of one group share, None for a case that must be run alone."""
    try:
        grid = case.loop.grid
        steps = count_steps(case.duration, grid[0] / grid[1])
    except EventregError:
        return None
    if not lanes_can(case.loop, steps, case.subject):
        return None
    structure = structure_of(case.loop, case.subject.needed)
    judged = case.subject.plants, case.subject.criteria
    holds = tuple(spec.hold for spec in case.loop.blocks.values())
    open_inputs = tuple(case.loop.stimuli.values())
    return structure, grid, holds, judged, case.duration, open_inputs, case.noise.on


def lanes_can(loop: Loop, steps: int, subject: Subject) -> bool:
    """Say whether such runs can go in lanes; else they go one by one, to the same end."""
    size = 8 * LANES * steps * (2 * len(subject.plants) + len(loop.links) + len(loop.signals))
    plain = subject.criteria.refractory == 0.0 and subject.criteria.min_width == 0.0
    plain = plain and all(block.plain for block in loop.blocks.values())
    plain = plain and _sampled_well(loop, steps, subject)
    known = subject.plants and set(subject.needed) <= set(loop.signals)
    return compiles() and plain and steps > 0 and size <= MOST and bool(known)


def _sampled_well(loop: Loop, steps: int, subject: Subject) -> bool:
    """Say whether runs are judged on all that they were asked for, unless spikes are short.

    What the evidence may withhold a verdict for otherwise is the business of :func:`one_by_one`.
    """
    time_scale, rate = loop.grid
    h, blind = time_scale / rate, subject.criteria.blind
    early = subject.duration is not None and steps * h < subject.duration - blind + h
    return h < 0.999 * blind and not early


def run_alike(
    template: Template,
    start: Start,
    impairments: Sequence[Impairment],
    noises: Sequence[Noise] = (SILENCE,),
    pool: ThreadPoolExecutor | None = None,
) -> Outcomes:
    """Run cases that differ in parameters, initial states, links and noise only, in lanes.

    ``start`` has one row per case; ``impairments`` and ``noises``, which are all on the same
    signals, one entry per case, or one for all.
    """
    group = Group(template, start, impairments, noises)
    rows, reasons = nothing(group.count), dict[int, str]()
    run = pool.map if pool else map
    alone, again, stuck = list[int](), list[int](), set[int]()
    goes = list(group.goes())
    for places, found in zip(goes, run(group.run, goes), strict=True):
        rows[places] = found.rows
        looked_at = ~found.finite | (found.holds & found.stuck)
        again += places[looked_at].tolist()
        stuck.update(places[found.finite & found.stuck].tolist())
        alone += places[~looked_at & ~found.holds].tolist()
    if len(again) < MANY:
        alone, again = alone + again, []
    goes = list(group.goes(again))
    for places, ends in zip(goes, run(group.ends, goes), strict=True):
        for i, time, held_up in zip(places.tolist(), *map(np.ndarray.tolist, ends), strict=True):
            if i not in stuck:
                rows[i], reasons[i] = nothing(1)[0], not_finite(time)
            elif held_up:
                rows['verdict'][i] = VERDICTS.index(UNDECIDED)
    if alone:
        left = _run_alone([group.case(i) for i in alone], pool)
        rows[alone] = left.rows
        reasons |= {alone[i]: reason for i, reason in left.reasons.items()}
    return Outcomes(rows, reasons)
