# SPDX-License-Identifier: Apache-2.0
"""The source of a kernel in lanes: the loop of :mod:`.kernel`, for many sets side by side.

What the loop consists of is written out, so that a compiler sees plain loops over the lanes with
constant strides and can do several lanes at once. The mathematics is that of everybody: the
functions of :func:`.block.make_advance` and :func:`.hold.line`, called lane by lane.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

from ..models import Model, first_state
from .kernel import NOBODY

LANES = 32
"""Sets side by side. A multiple of what a processor does at once, and all of it in its cache."""


PERFECT, COMMON, SCATTERED = 'perfect', 'common', 'scattered'
"""What links are to a kernel; the more general, the slower."""


class LaneBlock(NamedTuple):
    """A block as a kernel in lanes is built for it.

    ``pack`` is the type of its parameters, ``numbers`` how many they are; ``signs`` and ``sources``
    have one entry per input, see :class:`.kernel.Part`; ``observed`` are (signal, place in the
    state) of what it writes besides.
    """

    model: Model
    pack: type
    numbers: int
    signs: tuple[float, ...]
    row: int
    sources: tuple[int, ...]
    observed: tuple[tuple[int, int], ...]


class Structure(NamedTuple):
    """What all sets of a kernel have in common.

    Signals are numbered, those of the ``stimuli`` first; ``wanted`` are those whose samples are
    handed out, ``noisy`` those that blocks publish with noise. ``links`` is :data:`PERFECT` where
    every sample arrives at once, :data:`COMMON` where all sets have received the same samples,
    :data:`SCATTERED` where each has its own.
    """

    blocks: tuple[LaneBlock, ...]
    stimuli: int
    signals: int
    wanted: tuple[int, ...]
    links: str
    noisy: tuple[int, ...] = ()


class Layout(NamedTuple):
    """The rows of each block, of each signal now and a step before, of the alarm; how many.

    ``sds`` and ``draws`` are of each noisy signal: its standard deviation, and its next draw.
    """

    blocks: list[Rows]
    now: list[int]
    before: list[int]
    sds: list[int]
    draws: list[int]
    alarm: int
    rows: int


class Rows(NamedTuple):
    """Where the numbers of one block lie in the table of all sets, each a row of LANES numbers."""

    x: list[int]
    params: list[int]
    base: list[int]
    slope: list[int]
    y: int


@lru_cache(maxsize=64)
def layout(structure: Structure) -> Layout:
    """Return where the numbers of a structure lie."""
    free = iter(range(10**9))

    def take(count: int) -> list[int]:
        return [next(free) for _ in range(count)]

    rows = [
        Rows(
            take(block.model.dimension),
            take(block.numbers),
            take(len(block.sources)),
            take(len(block.sources)),
            next(free),
        )
        for block in structure.blocks
    ]
    now, before = take(structure.signals), take(structure.signals)
    sds, draws = take(len(structure.noisy)), take(len(structure.noisy))
    alarm = next(free)
    return Layout(rows, now, before, sds, draws, alarm, alarm + 1)


def source_of(structure: Structure) -> str:
    """Return the source of ``advance``, which takes a run from step ``first`` to ``last``.

    ``out`` takes the samples of the wanted signals, flat: row 0 those before, then one per step.
    ``work`` and ``ring`` are those of a block of :class:`.lanes.Lanes`; what follows is its
    ``motion``.
    """
    return '\n'.join(
        [
            'def advance(first, last, out, work, ring, h, mask, open_inputs, stride, newest,'
            ' previous, steps, horizons, noise, width):',
            '    for n in range(first, last):',
            *(f'        {line}' for line in _step(structure)),
            '',
        ]
    )


def _step(structure: Structure) -> Iterator[str]:
    lay, link = layout(structure), 0
    perfect = structure.links == PERFECT
    lines: list[str] = []
    yield from _draw(lay)
    for b, block in enumerate(structure.blocks):
        for i, source in enumerate(block.sources):
            at = f'{lay.blocks[b].base[i]} * L', f'{lay.blocks[b].slope[i]} * L'
            if source == NOBODY:
                continue
            if perfect:
                now, before = lay.now[source], lay.before[source]
                lines.append(
                    f'work[{at[0]} + a], work[{at[1]} + a] = line('
                    f'work[{now} * L + a], work[{before} * L + a], 0.0, 1.0, horizons[{b}])'
                )
            else:
                reach = _own_link if structure.links == SCATTERED else _common_link
                yield from reach(structure.signals, link, source, f'horizons[{b}]', *at)
            link += 1
    if perfect:
        lines += [f'work[{y} * L + a] = work[{x} * L + a]' for x, y in zip(*lay[1:3], strict=True)]
    for b, block in enumerate(structure.blocks):
        lines += _advance(b, block, lay.blocks[b], lay.alarm)
    lines += _add_noise(structure, lay)
    if perfect:
        lines += [
            f'work[{lay.now[s]} * L + a] = work[{row} * L + a]' for s, row in _written(structure)
        ]
    yield from _lanes(*lines)
    yield from (_keep_now(structure, lay) if perfect else _keep_in_ring(structure))


def _draw(lay: Layout) -> Iterator[str]:
    """Yield what draws the noise of the coming samples."""
    for i, row in enumerate(lay.draws):
        place = f'({i} * (steps + 1) + n + 1) * width + a % width'
        yield from _lanes(f'work[{row} * L + a] = noise[{place}]')


def _add_noise(structure: Structure, lay: Layout) -> Iterator[str]:
    """Yield what adds noise to what blocks publish, not to their states."""
    for signal, sd, draw in zip(structure.noisy, lay.sds, lay.draws, strict=True):
        for block, rows in zip(structure.blocks, lay.blocks, strict=True):
            if block.row == signal:
                yield f'work[{rows.y} * L + a] += work[{sd} * L + a] * work[{draw} * L + a]'


def _written(structure: Structure) -> Iterator[tuple[int, int]]:
    """Yield each signal that a block writes, and the row in which it is after a step."""
    for block, rows in zip(structure.blocks, layout(structure).blocks, strict=True):
        yield block.row, rows.y
        yield from ((signal, rows.x[i]) for signal, i in block.observed)


def _keep_now(structure: Structure, lay: Layout) -> Iterator[str]:
    """Yield what takes in the open inputs and hands out samples, without a ring."""
    for s in range(structure.stimuli):
        start = f'({s} * (steps + 1) + n + 1) * stride'
        yield from _lanes(f'work[{lay.now[s]} * L + a] = open_inputs[{start} + a % stride]')
    width = len(structure.wanted) * LANES
    for j, signal in enumerate(structure.wanted):
        place = f'out[(n + 1 - first) * {width} + {j} * L + a]'
        yield from _lanes(f'{place} = work[{lay.now[signal]} * L + a]')


def _keep_in_ring(structure: Structure) -> Iterator[str]:
    """Yield what puts the samples of this step into the ring, and hands out those that are."""
    yield f'after = ((n + 1) & mask) * {structure.signals * LANES}'
    for s in range(structure.stimuli):
        start = f'({s} * (steps + 1) + n + 1) * stride'
        yield from _lanes(f'ring[after + {s} * L + a] = open_inputs[{start} + a % stride]')
    for signal, row in _written(structure):
        yield from _lanes(f'ring[after + {signal} * L + a] = work[{row} * L + a]')
    width = len(structure.wanted) * LANES
    for j, signal in enumerate(structure.wanted):
        place = f'out[(n + 1 - first) * {width} + {j} * L + a]'
        yield from _lanes(f'{place} = ring[after + {signal} * L + a]')


def _lanes(*lines: str) -> list[str]:
    return ['for a in range(L):', *(f'    {line}' for line in lines)]


def _common_link(
    signals: int, link: int, source: int, horizon: str, base: str, slope: str
) -> Iterator[str]:
    """Yield what finds the line of an input where all sets have received the same samples."""
    store = f'work[{base} + a], work[{slope} + a] = line('
    yield f'i = newest[{link} * steps + n]'
    yield f'j = previous[{link} * steps + n]'
    yield f'now = (i & mask) * {signals * LANES} + {source} * L'
    yield f'before = (j & mask) * {signals * LANES} + {source} * L if j >= 0 else now'
    yield 'if i < 0:'
    yield from _inside(f'work[{base} + a] = 0.0', f'work[{slope} + a] = 0.0')
    yield 'elif i == n and j == n - 1 or i == n and j < 0:'
    yield from _inside(f'{store}ring[now + a], ring[before + a], 0.0, 1.0, {horizon})')
    yield 'else:'
    yield '    age = float(n - i)'
    yield '    gap = float(i - j) if j >= 0 else 1.0'
    yield from _inside(f'{store}ring[now + a], ring[before + a], age, gap, {horizon})')


def _inside(*lines: str) -> list[str]:
    return [f'    {line}' for line in _lanes(*lines)]


def _own_link(
    signals: int, link: int, source: int, horizon: str, base: str, slope: str
) -> Iterator[str]:
    """Yield the same where each set has received samples of its own."""
    place = f'({link} * steps + n) * L + a'
    yield from _lanes(
        f'i, j = newest[{place}], previous[{place}]',
        'back = i if j < 0 else j',
        'gap = 1.0 if j < 0 else float(i - j)',
        f'now = (i & mask) * {signals * LANES} + {source} * L + a',
        f'before = (back & mask) * {signals * LANES} + {source} * L + a',
        f'b, s = line(ring[now], ring[before], float(n - i), gap, {horizon})',
        f'work[{base} + a] = 0.0 if i < 0 else b',
        f'work[{slope} + a] = 0.0 if i < 0 else s',
    )


def _advance(b: int, block: LaneBlock, rows: Rows, alarm: int) -> Iterator[str]:
    """Yield what takes one block a step on in one lane."""
    params = ', '.join(f'work[{row} * L + a]' for row in rows.params)
    packed = f'({params},)' if block.pack is tuple else f'pack_{b}({params})'
    if not block.numbers:
        packed = '()'
    signs = ', '.join(map(repr, block.signs or (1.0,)))
    base, slope = (
        ', '.join(
            '0.0' if source == NOBODY else f'work[{row} * L + a]'
            for row, source in zip(of, block.sources, strict=True)
        )
        or '0.0'
        for of in (rows.base, rows.slope)
    )
    x = ', '.join(f'work[{row} * L + a]' for row in rows.x)
    yield f'x, y = advance_{b}(({x},), ({signs},), ({base},), ({slope},), {packed}, h)'
    yield from (f'work[{row} * L + a] = x[{i}]' for i, row in enumerate(rows.x))
    yield f'work[{rows.y} * L + a] = y'
    if block.model.output is not first_state:
        yield f'work[{alarm} * L + a] += y * 0.0'
