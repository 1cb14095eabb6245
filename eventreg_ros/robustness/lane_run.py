# SPDX-License-Identifier: Apache-2.0
"""Many runs at once: cases sorted into lanes, run, and judged; or one by one where that must be."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..analysis.rejection import REJECTED
from ..analysis.subject import Subject
from ..errors import EventregError
from ..simulation.block import BlockSpec
from ..simulation.impairment import Impairment, Received, received
from ..simulation.jit import compiles
from ..simulation.lanes import Course, Lanes, Links, Start, structure_of
from ..simulation.lanes_source import COMMON, LANES, PERFECT, SCATTERED
from ..simulation.loop import Loop
from ..simulation.model_errors import ANYTHING
from ..simulation.model_time import count_steps, model_times
from ..simulation.noise import SILENCE, Noise, draws
from ..simulation.sampled import Waveform
from ..simulation.trajectory import Array
from .lane_judge import judge_lanes
from .outcome import VERDICTS, Case, Outcomes, Rows, nothing, one_by_one

MOST = 1 << 30
"""Bytes that one block of lanes may take; longer runs go one by one."""

ENOUGH = LANES // 2
"""Cases with the same links that are worth lanes of their own."""


class Template(NamedTuple):
    """What the cases of a group have in common: all but parameters, states and links.

    ``loop`` is that of any of them.
    """

    loop: Loop
    subject: Subject
    duration: float


def run(cases: Sequence[Case], pool: ThreadPoolExecutor | None = None) -> Outcomes:
    """Run cases of any kind and judge them, in lanes where they can be."""
    rows, reasons = nothing(len(cases)), dict[int, str]()
    groups: dict[Any, list[int]] = defaultdict(list)
    for i, case in enumerate(cases):
        groups[_kind(case)].append(i)
    for key, places in groups.items():
        members = [cases[i] for i in places]
        found = _run_alone(members) if key is None else _run_group(members, pool)
        rows[places] = found.rows
        reasons |= {places[i]: reason for i, reason in found.reasons.items()}
    return Outcomes(rows, reasons)


def _run_alone(cases: Sequence[Case]) -> Outcomes:
    rows, reasons = nothing(len(cases)), dict[int, str]()
    for i, case in enumerate(cases):
        rows[i], reason = one_by_one(case)
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
    known = subject.plants and set(subject.needed) <= set(loop.signals)
    return compiles() and plain and steps > 0 and size <= MOST and bool(known)


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
    group = _Group(template, start, impairments, noises)
    rows, reasons = nothing(len(start.outputs[0])), dict[int, str]()
    blocks = list(group.blocks())
    mapped = pool.map(group.run, blocks) if pool else map(group.run, blocks)
    for places, (found, holds) in zip(blocks, mapped, strict=True):
        rows[places] = found[: len(places)]
        # An output so far up without an event may be up all the time: it is judged by itself.
        up = found['peak'] >= template.subject.criteria.threshold
        holds = holds & ~(up & (found['verdict'] == VERDICTS.index(REJECTED)))
        for i in places[~holds[: len(places)]].tolist():
            rows[i], reason = one_by_one(group.case(i))
            if reason:
                reasons[i] = reason
    return Outcomes(rows, reasons)


class _Group:
    """Cases of one template, ready to be run a block of lanes at a time."""

    def __init__(
        self,
        template: Template,
        start: Start,
        impairments: Sequence[Impairment],
        noises: Sequence[Noise],
    ) -> None:
        loop = template.loop
        self._template, self._start = template, start
        count = len(start.outputs[0])
        self._impairments = [
            each if each.random else replace(each, seed=0)
            for each in list(impairments) * (count if len(impairments) == 1 else 1)
        ]
        self._noises = list(noises) * (count if len(noises) == 1 else 1)
        self._noisy = [s for s in noises[0].on if any(noise.reaches(s) for noise in noises)]
        time_scale, rate = loop.grid
        self._h = time_scale / rate
        self._steps = count_steps(template.duration, self._h)
        self._t = model_times(self._steps, time_scale, rate)
        self._signals = tuple(signal for _, signal in loop.links)
        self._judged = template.subject.needed
        waves = [Waveform(stimulus).at(self._t) for stimulus in loop.stimuli.values()]
        self._open = np.array(waves).reshape(len(waves), len(self._t), 1)
        self._fails = False
        self._horizons = np.array([spec.horizon for spec in loop.blocks.values()])

    def blocks(self) -> Iterator[Any]:
        """Yield the places of the cases of each block: those with the same links together."""
        alike: dict[Impairment, list[int]] = defaultdict(list)
        for i, impairment in enumerate(self._impairments):
            alike[impairment].append(i)
        several = len(alike) > 1
        rest = [i for group in alike.values() if several and len(group) < ENOUGH for i in group]
        groups = [group for group in alike.values() if not several or len(group) >= ENOUGH]
        for places in [*groups, rest]:
            for first in range(0, len(places), LANES):
                yield np.array(places[first : first + LANES])

    def case(self, i: int) -> Case:
        """Return the case at place ``i`` by itself."""
        specs = list(self._template.loop.blocks.items())
        blocks = {
            name: _with(spec, self._start.x[b][i], self._start.params[b][i])
            for b, (name, spec) in enumerate(specs)
        }
        loop = Loop(blocks, self._template.loop.stimuli)
        subject, duration = self._template.subject, self._template.duration
        return Case(loop, self._impairments[i], subject, duration, self._noises[i])

    def run(self, places: Any) -> tuple[Rows, Any]:
        """Return the rows of one block of lanes, and which of them hold.

        None holds where the model of another package fails, in numba's eyes or in fact: such cases
        are run one by one, and say why.
        """
        if not self._template.loop.foreign_models:
            return self._in_lanes(places)
        if not self._fails:
            try:
                return self._in_lanes(places)
            except EventregError:
                raise
            except ANYTHING:
                self._fails = True
        return nothing(len(places)), np.zeros(len(places), dtype=bool)

    def _in_lanes(self, places: Any) -> tuple[Rows, Any]:
        noises = [self._noises[i] for i in places]
        x, params, outputs = ([array[places] for array in part] for part in self._parts)
        start = Start(x, params, outputs, [self._sds(noises, signal) for signal in self._noisy])
        kind, links = self._links([self._impairments[i] for i in places])
        structure = structure_of(self._template.loop, self._judged, kind, self._noisy)
        course = Course(
            structure, self._steps, self._h, self._horizons, self._open, links, self._draws(noises)
        )
        return judge_lanes(Lanes(course, start), self._judged, self._t, self._template.subject)

    def _sds(self, noises: Sequence[Noise], signal: str) -> Array:
        return np.array([noise.sds[noise.on.index(signal)] for noise in noises])

    def _draws(self, noises: Sequence[Noise]) -> Array:
        """Return the draws of each noisy signal for lanes with these noises; see :class:`Course`.

        Further lanes do as the last.
        """
        seeds = [noise.seed for noise in noises]
        seeds = seeds[:1] if len(set(seeds)) == 1 else seeds + seeds[-1:] * (LANES - len(seeds))
        table = np.empty((len(self._noisy), self._steps + 1, len(seeds)))
        for i, signal in enumerate(self._noisy):
            place = noises[0].on.index(signal)
            for lane, seed in enumerate(seeds):
                table[i, :, lane] = _drawn(seed, place, self._steps + 1)
        return table

    def _links(self, impairments: Sequence[Impairment]) -> tuple[str, Links]:
        """Return what the links of lanes with these impairments are, and what they receive."""
        alike = set(impairments)
        if not any(each.delay or each.loss or each.jitter for each in alike):
            return PERFECT, Links.perfect()
        asked = impairments[:1] if len(alike) == 1 else impairments
        have = [_received(self._signals, self._steps, self._h, each) for each in asked]
        if len(alike) == 1:
            return COMMON, Links.common(have[0])
        return SCATTERED, Links.scattered(have)

    @property
    def _parts(self) -> tuple[Sequence[Array], Sequence[Array], Sequence[Array]]:
        return self._start.x, self._start.params, self._start.outputs


def _with(spec: BlockSpec, x: Array, params: Array) -> BlockSpec:
    pack = type(spec.params)
    made = pack(*params.tolist()) if hasattr(pack, '_fields') else tuple(params.tolist())
    return replace(spec, x0=tuple(x.tolist()), params=made)


@lru_cache(maxsize=64)
def _drawn(seed: int, place: int, samples: int) -> Array:
    return draws(seed, place, samples)


@lru_cache(maxsize=64)
def _received(signals: tuple[str, ...], steps: int, h: float, impairment: Impairment) -> Received:
    return received(signals, steps, h, impairment)
