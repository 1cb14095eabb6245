# SPDX-License-Identifier: Apache-2.0
"""Cases that differ in numbers only, sorted into blocks of lanes and run a block at a time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from ..analysis.subject import Subject
from ..errors import EventregError
from ..models import Params
from ..simulation.block import BlockSpec
from ..simulation.impairment import Impairment, Received, received
from ..simulation.lane_links import Links, law_of
from ..simulation.lanes import Course, Lanes, Start, structure_of
from ..simulation.lanes_source import COMMON, LANES, PERFECT, SCATTERED, Structure
from ..simulation.loop import Loop
from ..simulation.model_errors import ANYTHING
from ..simulation.model_time import count_steps, model_times
from ..simulation.noise import Noise, draws
from ..simulation.sampled import Waveform
from ..simulation.trajectory import Array
from .lane_end import Ends, ends_of
from .lane_judge import Judge, Judged
from .outcome import Case, nothing

BLOCKS, SHARES = 16, 4
"""Blocks with the same links that are run in one go, at most: as long as there are so many goes."""

ENOUGH = LANES // 2
"""Cases with the same links that are worth lanes of their own."""


class Template(NamedTuple):
    """What the cases of a group have in common: all but parameters, states, links and noise.

    ``loop`` is that of any of them.
    """

    loop: Loop
    subject: Subject
    duration: float


class Group:
    """Cases of one template, ready to be run a block of lanes at a time.

    ``start`` has one row per case; ``impairments`` and ``noises``, which are all on the same
    signals, one entry per case, or one for all.
    """

    def __init__(
        self,
        template: Template,
        start: Start,
        impairments: Sequence[Impairment],
        noises: Sequence[Noise],
    ) -> None:
        loop = template.loop
        self._template, self._start = template, start
        self._impairments, self._noises = list(map(_plain, impairments)), noises
        time_scale, rate = loop.grid
        self._h = time_scale / rate
        self._steps = count_steps(template.duration, self._h)
        self._t = model_times(self._steps, time_scale, rate)
        self._signals = tuple(signal for _, signal in loop.links)
        waves = [Waveform(stimulus).at(self._t) for stimulus in loop.stimuli.values()]
        self._open = np.array(waves).reshape(len(waves), len(self._t), 1)
        self._horizons = np.array([spec.horizon for spec in loop.blocks.values()])
        self._noisy = [s for s in noises[0].on if any(noise.reaches(s) for noise in noises)]
        self._places = [noises[0].on.index(signal) for signal in self._noisy]
        self._known, self._fails = dict[str, tuple[Structure, Judge]](), False

    @property
    def count(self) -> int:
        """How many cases there are."""
        return len(self._start.outputs[0])

    def goes(self, some: Sequence[int] | None = None) -> Iterator[Any]:
        """Yield the places of cases to be run in one go: those with the same links together.

        All cases, or ``some`` of them.
        """
        places = range(self.count) if some is None else some
        alike: dict[Impairment, list[int]] = defaultdict(list)
        if len(self._impairments) == 1:
            alike[self._impairments[0]] = list(places)
        else:
            for i in places:
                alike[self._impairments[i]].append(i)
        several = len(alike) > 1
        rest = [i for group in alike.values() if several and len(group) < ENOUGH for i in group]
        groups = [group for group in alike.values() if not several or len(group) >= ENOUGH]
        one = len({noise.seed for noise in self._noises}) > 1  # draws are of one block
        together = LANES * (1 if one else max(1, min(BLOCKS, len(places) // (LANES * SHARES))))
        for group in groups:
            for first in range(0, len(group), together):
                yield np.array(group[first : first + together])
        yield from self._mixed(rest, together)

    def _mixed(self, places: list[int], together: int) -> Iterator[Any]:
        """Yield places with various links, so many together; few different tables in each."""
        each = self._impairments
        go, laws = list[int](), set[Impairment]()
        for i in sorted(places, key=lambda i: _order(each[i])):
            law = law_of(each[i])
            if len(go) >= together or (len(laws) == LANES and law not in laws):
                yield np.array(go)
                go, laws = [], set()
            go.append(i)
            laws.add(law)
        if go:
            yield np.array(go)

    def case(self, i: int) -> Case:
        """Return the case at place ``i`` by itself."""
        specs = list(self._template.loop.blocks.items())
        blocks = {
            name: _with(spec, self._start.x[b][i], self._start.params[b][i])
            for b, (name, spec) in enumerate(specs)
        }
        loop = Loop(blocks, self._template.loop.stimuli)
        impairment, noise = _of(self._impairments, [i])[0], _of(self._noises, [i])[0]
        return Case(loop, impairment, self._template.subject, self._template.duration, noise)

    def run(self, places: Any) -> Judged:
        """Return the rows of the cases at these places, and which of them hold.

        None holds where the model of another package fails, in numba's eyes or in fact: such cases
        are run one by one, and say why; so is one that does not stay finite.
        """
        if not self._template.loop.foreign_models:
            return self._in_lanes(places)
        every = np.ones(len(places), dtype=bool)
        if not self._fails:
            try:
                found = self._in_lanes(places)
                return Judged(found.rows, found.holds & found.finite & ~found.stuck, every, ~every)
            except EventregError:
                raise
            except ANYTHING:
                self._fails = True
        return Judged(nothing(len(places)), ~every, every, ~every)

    def ends(self, places: Any) -> Ends:
        """Return how the cases at these places end, those that diverge."""
        signals, subject = self._template.loop.signals, self._template.subject
        _, lanes = self._lanes(places, partial(self._structure, signals))
        return ends_of(lanes, len(places), signals, subject, self._t)

    def _in_lanes(self, places: Any) -> Judged:
        kind, lanes = self._lanes(places, lambda kind: self._judges(kind)[0])
        return self._judges(kind)[1].run(lanes)

    def _lanes(self, places: Any, structures: Callable[[str], Structure]) -> tuple[str, Lanes]:
        """Return lanes with the cases at these places, and the kind of their links."""
        of = self._start
        x, params, outputs = (
            [array[places] for array in part] for part in (of.x, of.params, of.outputs)
        )
        noises = _of(self._noises, places.tolist())
        start = Start(x, params, outputs, list(self._sds(noises, len(places))))
        kind, links = self._links(_of(self._impairments, places.tolist()))
        draws = self._draws([noise.seed for noise in noises])
        structure = structures(kind)
        course = Course(structure, self._steps, self._h, self._horizons, self._open, links, draws)
        return kind, Lanes(course, start)

    def _structure(self, wanted: Sequence[str], kind: str) -> Structure:
        return structure_of(self._template.loop, wanted, kind, self._noisy)

    def _judges(self, kind: str) -> tuple[Structure, Judge]:
        """Return the structure of lanes whose links are of that kind, and who judges them."""
        if kind not in self._known:
            subject = self._template.subject
            structure = self._structure(subject.needed, kind)
            self._known[kind] = structure, Judge(structure, subject.needed, self._t, subject)
        return self._known[kind]

    def _sds(self, noises: Sequence[Noise], count: int) -> Iterator[Array]:
        """Yield the standard deviations of the noise in ``count`` lanes, for each noisy signal."""
        for place in self._places:
            sds = np.array([noise.sds[place] for noise in noises])
            yield np.repeat(sds, count) if len(sds) == 1 else sds

    def _draws(self, seeds: Sequence[int]) -> Array:
        """Return the draws of each noisy signal for lanes with these seeds; see :class:`Course`.

        Further lanes do as the last.
        """
        alike = len(set(seeds)) == 1
        lanes = seeds[:1] if alike else [*seeds, *[seeds[-1]] * (LANES - len(seeds))]
        table = np.empty((len(self._places), self._steps + 1, len(lanes)))
        for i, place in enumerate(self._places):
            for lane, seed in enumerate(lanes):
                table[i, :, lane] = _drawn(seed, place, self._steps + 1)
        return table

    def _links(self, impairments: Sequence[Impairment]) -> tuple[str, Links]:
        """Return what the links of lanes with these impairments are, and what they receive."""
        several = self.count > 1  # a case alone is as quick with links of its own
        if several and not any(each.delay or each.loss or each.jitter for each in impairments):
            return PERFECT, Links.perfect()
        if several and len(set(impairments)) == 1:
            return COMMON, Links.common(
                _received(self._signals, self._steps, self._h, impairments[0])
            )
        return SCATTERED, Links.scattered(self._signals, self._steps, self._h, impairments)


def _order(impairment: Impairment) -> tuple[int, float, float, list[str], float]:
    """Return by what cases are sorted, such that those next to each other share tables."""
    on = sorted(impairment.on or ())
    return impairment.seed, impairment.loss, impairment.jitter, on, impairment.delay


def _plain(impairment: Impairment) -> Impairment:
    """Return an impairment such that equal ones do the same: without a seed that is of no use."""
    return impairment if impairment.random or not impairment.seed else replace(impairment, seed=0)


def _of(each: Sequence[Any], places: Sequence[int]) -> Sequence[Any]:
    """Return the entries of those places, the only one where there is one for all."""
    return each if len(each) == 1 else [each[i] for i in places]


def _with(spec: BlockSpec, x: Array, params: Array) -> BlockSpec:
    return replace(spec, x0=tuple(x.tolist()), params=packed(spec, params.tolist()))


def packed(spec: BlockSpec, numbers: Sequence[float]) -> Params:
    """Return numbers as the parameters of a block, in the type that its model reads."""
    pack: Callable[..., Params] = type(spec.params)
    return pack(*numbers) if hasattr(pack, '_fields') else tuple(numbers)


@lru_cache(maxsize=64)
def _drawn(seed: int, place: int, samples: int) -> Array:
    return draws(seed, place, samples)


@lru_cache(maxsize=8)
def _received(signals: tuple[str, ...], steps: int, h: float, impairment: Impairment) -> Received:
    return received(signals, steps, h, impairment, with_used=False)
