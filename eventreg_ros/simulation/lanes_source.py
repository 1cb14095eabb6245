# SPDX-License-Identifier: Apache-2.0
"""The source of a kernel in lanes: the loop of :mod:`.kernel`, for many sets side by side.

What the loop consists of is written out, so that a compiler sees plain loops over the lanes with
constant strides and can do several lanes at once. The mathematics is that of everybody: the
functions of :func:`.block.make_advance` and :func:`.hold.line`, called lane by lane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
        )
        for block in structure.blocks
    ]
    now, before = take(structure.signals), take(structure.signals)
    sds, draws = take(len(structure.noisy)), take(len(structure.noisy))
    alarm = next(free)
    return Layout(rows, now, before, sds, draws, alarm, alarm + 1)


def source_of(structure: Structure) -> str:
    """Return the source of ``advance``, which takes a run from step ``first`` to ``last``.

    ``out`` takes the samples of the wanted signals: row 0 those before, then one per step.
    ``work`` to ``lags`` are those of a block of :class:`.lanes.Lanes`; what follows is its
    ``motion``: see :attr:`.lanes.Lanes.parts`.
    """
    return '\n'.join(
        [
            'def advance(first, last, out, work, ring, tables, lags, h, mask, open_inputs, stride,'
            ' newest, previous, span, steps, horizons, noise, width):',
            '    for n in range(first, last):',
            *(f'        {line}' for line in _step(structure)),
            '',
        ]
    )


def _step(structure: Structure) -> Iterator[str]:
    yield from _draw(layout(structure))
    yield from (_at_once if structure.links == PERFECT else _from_ring)(structure)


def _at_once(structure: Structure) -> Iterator[str]:
    """Yield a step in which every sample arrives at once; ``work`` holds it and the one before."""
    lay = layout(structure)
    now, before = ([f'work[{row} * L + a]' for row in rows] for rows in (lay.now, lay.before))
    lines: list[str] = []
    for b, block in enumerate(structure.blocks):
        for i, source in _connected(block):
            pair = f'{now[source]}, {before[source]}'
            lines.append(f'base_{b}_{i}, slope_{b}_{i} = line({pair}, 0.0, 1.0, horizons[{b}])')
    lines += [f'{old} = {new}' for old, new in zip(before, now, strict=True)]
    for b, block in enumerate(structure.blocks):
        inputs = range(len(block.sources))
        lines += _advance(b, block, lay, [(f'base_{b}_{i}', f'slope_{b}_{i}') for i in inputs])
    yield from _publish(structure, lines)


def _from_ring(structure: Structure) -> Iterator[str]:
    """Yield a step in which each input has what arrived of it; ``ring`` holds the last samples."""
    lay, link = layout(structure), 0
    reach = _own_link if structure.links == SCATTERED else _common_link
    lines: list[str] = []
    for b, block in enumerate(structure.blocks):
        rows = zip(lay.blocks[b].base, lay.blocks[b].slope, strict=True)
        drawn = [(f'work[{base} * L + a]', f'work[{slope} * L + a]') for base, slope in rows]
        for i, source in _connected(block):
            yield from reach(structure.signals, link, source, f'horizons[{b}]', *drawn[i])
            link += 1
        lines += _advance(b, block, lay, drawn)
    yield from _publish(structure, lines)
    yield f'after = ((n + 1) & mask) * {structure.signals * LANES}'
    for signal, row in enumerate(lay.now):
        yield from _lanes(f'ring[after + {signal} * L + a] = work[{row} * L + a]')


def _connected(block: LaneBlock) -> Iterator[tuple[int, int]]:
    """Yield the inputs of a block that are there: (place, signal)."""
    return ((i, source) for i, source in enumerate(block.sources) if source != NOBODY)


def _draw(lay: Layout) -> Iterator[str]:
    """Yield what draws the noise of the coming samples."""
    for i, row in enumerate(lay.draws):
        place = f'({i} * (steps + 1) + n + 1) * width + a % width'
        yield from _lanes(f'work[{row} * L + a] = noise[{place}]')


def _publish(structure: Structure, advance: list[str]) -> Iterator[str]:
    """Yield ``advance``, what puts all new samples into ``work``, and what hands out the wanted.

    A compiler does several lanes at once only of loops with little more in them than these.
    """
    now = [f'work[{row} * L + a]' for row in layout(structure).now]
    written = (f'{now[signal]} = {value}' for signal, value in _written(structure))
    yield from _lanes(*advance, *_add_noise(structure), *written)
    for s in range(structure.stimuli):
        start = f'({s} * (steps + 1) + n + 1) * stride'
        yield from _lanes(f'{now[s]} = open_inputs[{start} + a % stride]')
    for j, signal in enumerate(structure.wanted):
        yield from _lanes(f'out[n + 1 - first, {j}, a] = {now[signal]}')


def _add_noise(structure: Structure) -> Iterator[str]:
    """Yield what adds noise to what blocks publish, not to their states."""
    lay = layout(structure)
    for signal, sd, draw in zip(structure.noisy, lay.sds, lay.draws, strict=True):
        for b, block in enumerate(structure.blocks):
            if block.row == signal:
                yield f'y_{b} += work[{sd} * L + a] * work[{draw} * L + a]'


def _written(structure: Structure) -> Iterator[tuple[int, str]]:
    """Yield each signal that a block writes, and its value after a step."""
    lay = layout(structure)
    for b, block in enumerate(structure.blocks):
        yield block.row, f'y_{b}'
        for signal, i in block.observed:
            yield signal, f'work[{lay.blocks[b].x[i]} * L + a]'


def _lanes(*lines: str) -> list[str]:
    return ['for a in range(L):', *(f'    {line}' for line in lines)]


def _common_link(
    signals: int, link: int, source: int, horizon: str, base: str, slope: str
) -> Iterator[str]:
    """Yield what finds the line of an input where all sets have received the same samples."""
    store = f'{base}, {slope} = line('
    yield f'i = newest[{link} * steps + n]'
    yield f'j = previous[{link} * steps + n]'
    yield f'now = (i & mask) * {signals * LANES} + {source} * L'
    yield f'before = (j & mask) * {signals * LANES} + {source} * L if j >= 0 else now'
    yield 'if i < 0:'
    yield from _inside(f'{base} = 0.0', f'{slope} = 0.0')
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
    late = f'm = n - lags[{link} * L + a]'
    found = (
        f'now = (i & mask) * {signals * LANES} + {source} * L + a',
        f'before = (back & mask) * {signals * LANES} + {source} * L + a',
        f'b, s = line(ring[now], ring[before], float(n - i), gap, {horizon})',
        f'{base} = 0.0 if i < 0 else b',
        f'{slope} = 0.0 if i < 0 else s',
    )
    yield 'if span == 1:'  # nothing is lost, and all comes in order
    yield from _inside(late, 'i = m', 'back = i - 1 if i > 0 else i', 'gap = 1.0', *found)
    yield 'else:'
    yield from _inside(
        late,
        f'place = tables[a] + {link} * span + max(m, 0)',
        'i = m - newest[place]',
        'j = i - previous[place]',
        'back = i if j < 0 else j',
        'gap = 1.0 if j < 0 else float(i - j)',
        *found,
    )


def _advance(
    b: int, block: LaneBlock, lay: Layout, lines: Sequence[tuple[str, str]]
) -> Iterator[str]:
    """Yield what takes one block a step on in one lane, its inputs on ``lines`` (base, slope)."""
    rows = lay.blocks[b]
    params = ', '.join(f'work[{row} * L + a]' for row in rows.params)
    packed = f'({params},)' if block.pack is tuple else f'pack_{b}({params})'
    if not block.numbers:
        packed = '()'
    there = [i for i, _ in _connected(block)]
    signs = ', '.join(repr(block.signs[i]) for i in there) or '1.0'
    base, slope = (', '.join(lines[i][k] for i in there) or '0.0' for k in range(2))
    x = ', '.join(f'work[{row} * L + a]' for row in rows.x)
    yield f'x, y_{b} = advance_{b}(({x},), ({signs},), ({base},), ({slope},), {packed}, h)'
    yield from (f'work[{row} * L + a] = x[{i}]' for i, row in enumerate(rows.x))
    if block.model.output is not first_state:
        yield f'work[{lay.alarm} * L + a] += y_{b} * 0.0'
