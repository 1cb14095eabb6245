"""The source of a kernel in lanes: the loop of :mod:`.kernel`, for many sets side by side.

What the loop consists of is written out, so that a compiler sees plain loops over the lanes with
constant strides and can do several lanes at once. The mathematics is that of everybody: the
functions of :func:`.block.make_advance` and :func:`.hold.line`, called lane by lane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..models import Model, first_state
from .kernel import NOBODY

LANES = 32
"""Sets side by side. A multiple of what a processor does at once, and all of it in its cache."""


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
    handed out. ``scattered`` says that every set has links of its own.
    """

    blocks: tuple[LaneBlock, ...]
    stimuli: int
    signals: int
    wanted: tuple[int, ...]
    scattered: bool


class Rows(NamedTuple):
    """Where the numbers of one block lie in the table of all sets, each a row of LANES numbers."""

    x: list[int]
    params: list[int]
    base: list[int]
    slope: list[int]
    y: int


def layout(blocks: Sequence[LaneBlock]) -> tuple[list[Rows], int, int]:
    """Return the rows of each block, the row of the alarm, and how many rows there are."""
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
        for block in blocks
    ]
    alarm = next(free)
    return rows, alarm, alarm + 1


def source_of(structure: Structure) -> str:
    """Return the source of ``advance``, which takes a run from step ``first`` to ``last``.

    See :meth:`.lanes.Lanes.advance`, which calls it, for its arguments.
    """
    return '\n'.join(
        [
            'def advance(first, last, h, work, ring, mask, open_inputs, stride, newest, previous,'
            ' steps, horizons, out):',
            '    for n in range(first, last):',
            *(f'        {line}' for line in _step(structure)),
            '',
        ]
    )


def _step(structure: Structure) -> Iterator[str]:
    rows, alarm, _ = layout(structure.blocks)
    link = 0
    for b, block in enumerate(structure.blocks):
        for i, source in enumerate(block.sources):
            if source != NOBODY:
                reach = _own_link if structure.scattered else _common_link
                at = f'{rows[b].base[i]} * L', f'{rows[b].slope[i]} * L'
                yield from reach(structure.signals, link, source, f'horizons[{b}]', *at)
                link += 1
    for b, block in enumerate(structure.blocks):
        yield from _advance(b, block, rows[b], alarm)
    yield f'after = ((n + 1) & mask) * {structure.signals * LANES}'
    for s in range(structure.stimuli):
        start = f'({s} * (steps + 1) + n + 1) * stride'
        yield from _lanes(f'ring[after + {s} * L + a] = open_inputs[{start} + a % stride]')
    for b, block in enumerate(structure.blocks):
        written = [(block.row, rows[b].y), *((s, rows[b].x[i]) for s, i in block.observed)]
        for signal, row in written:
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


def _advance(b: int, block: LaneBlock, rows: Rows, alarm: int) -> list[str]:
    """Return what takes one block a step on in all lanes."""
    params = ', '.join(f'work[{row} * L + a]' for row in rows.params)
    packed = f'({params},)' if block.pack is tuple else f'pack_{b}({params})'
    if not block.numbers:
        packed = '()'
    signs = ', '.join(map(repr, block.signs or (1.0,)))
    base = ', '.join(f'work[{row} * L + a]' for row in rows.base) or '0.0'
    slope = ', '.join(f'work[{row} * L + a]' for row in rows.slope) or '0.0'
    x = ', '.join(f'work[{row} * L + a]' for row in rows.x)
    watched = [] if block.model.output is first_state else [f'work[{alarm} * L + a] += y * 0.0']
    return _lanes(
        f'x, y = advance_{b}(({x},), ({signs},), ({base},), ({slope},), {packed}, h)',
        *(f'work[{row} * L + a] = x[{i}]' for i, row in enumerate(rows.x)),
        f'work[{rows.y} * L + a] = y',
        *watched,
    )
