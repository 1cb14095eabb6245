# SPDX-License-Identifier: Apache-2.0
"""The closed loop, sample by sample: one implementation, plain Python or compiled by numba.

It is put together from the very functions that a node calls (:func:`.block.make_advance`,
:func:`.hold.line`), so it gives the same bits. It knows
nothing of delay or loss: two tables say which samples each link has at each step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..models import Model, Params
from .block import make_advance
from .code_cache import generated
from .coding import Copy, MakeCode, MakeCopy
from .hold import line
from .numbered import Make, Reader
from .step import Compile, plain

NOBODY = -1
"""The source of an input that nobody publishes."""

FLAT = 8
"""Blocks, or inputs of a block, that are taken one by one."""


class CodedOutput(NamedTuple):
    """What codes an output, see :mod:`.coding`; its states come behind ``size`` others.

    ``copies`` are the receivers behind links that lose messages.
    """

    make: MakeCode
    size: int
    make_copy: MakeCopy
    copies: tuple[Copy, ...] = ()


class Part(NamedTuple):
    """What a kernel is built for, one per block; what it is run with is a :class:`Tuning`.

    ``row`` is the signal that the block writes; ``sources`` the signals that it reads, NOBODY where
    there is none. A link is an entry of ``sources`` that is not NOBODY; links count through all
    blocks, in order. ``observed`` are (signal, place in the state) of what it writes besides.
    ``make`` makes the step of a block that reads its inputs by number; its tuning is of its own
    kind, see :mod:`.numbered`. A ``noisy`` block finds in its row what is added to what it writes.
    ``code`` is there for a block whose output is coded; its tuning is then (the block's, the
    coder's).
    """

    model: Model
    row: int
    sources: tuple[int, ...]
    observed: tuple[tuple[int, int], ...] = ()
    make: Make | None = None
    noisy: bool = False
    code: CodedOutput | None = None


class Tuning(NamedTuple):
    """What may change from run to run, one per block.

    ``sign`` is that of each input, (1.0,) for a block without any; ``horizon`` is
    in steps, see :func:`.hold.line`.
    """

    params: Params
    sign: tuple[float, ...]
    horizon: float


class Tables(NamedTuple):
    """What the kernel reads and writes, rows in a line: lists in plain Python, else arrays.

    Sample n of signal s is ``samples[s * (steps + 1) + n]``. At step n link l has, last, sample
    number ``newest[l * steps + n]``, and before it ``previous[l * steps + n]``; -1 means none. The
    last sample up to s that it ever has is ``used[l * steps + s]``. Sample s is played at step s +
    ``leads[l]``, and lines are drawn by ``drawn[l]`` of the horizon: 0 or 1. Message n on the way
    to copy c is lost where ``lost[c * (steps + 1) + n]`` is not 0. ``h`` is in model time. The
    kernel takes the steps from sample ``first`` to sample ``last``.
    """

    samples: Any
    newest: Any
    previous: Any
    used: Any
    leads: Any
    drawn: Any
    lost: Any
    steps: int
    h: float
    first: int
    last: int


Kernel = Callable[[Any, Any, Tables], Any]

_RUN = """\
def run(states, tunings, tables):
    for n in range(tables.first, tables.last):
        states = advance(n, states, tunings, tables)
    return states
"""
"""As source, since the machine code of a function that has a closure cannot be kept."""


def make_kernel(parts: Sequence[Part], compile: Compile = plain) -> Kernel:
    """Return ``run(states, tunings, tables) -> states``: fills ``tables.samples`` step by step.

    ``states`` and ``tunings`` have one entry per part, nested as :func:`nest` does it. ``compile``
    is applied to every function that ``run`` calls (numba's njit, say), not to ``run`` itself.
    """
    advances, links = [], 0
    for part in parts:
        make = _make_ordinary if part.make is None else _make_numbered
        advances.append(_make_advance(part, make(part, links, compile), compile))
        links += sum(source != NOBODY for source in part.sources)
    advance = _make_chain(advances, compile)
    return generated(_RUN, 'run', {'advance': advance})


def nest(entries: Sequence[Any]) -> Any:
    """Return ``entries`` as the kernel takes them, whatever their types: (a, (b, (c, ()))).

    More than :data:`FLAT` are halved first, so that no number of them nests too deep.
    """
    if len(entries) > FLAT:
        middle = len(entries) // 2
        return nest(entries[:middle]), nest(entries[middle:])
    return (entries[0], nest(entries[1:])) if entries else ()


def flatten(states: Any) -> list[float]:
    """Return all numbers of nested states, in order."""
    if isinstance(states, tuple):
        return [number for part in states for number in flatten(part)]
    return [states]


def _make_receive(source: int, link: int, compile: Compile) -> Any:
    """Return ``receive(n, horizon, tables) -> (base, slope)``, the line of an input over step n."""
    if source == NOBODY:

        def nothing(n: int, horizon: float, tables: Tables) -> tuple[float, float]:
            return 0.0, 0.0

        return compile(nothing)
    extend = compile(line)

    def receive(n: int, horizon: float, tables: Tables) -> tuple[float, float]:
        i = tables.newest[link * tables.steps + n]
        if i < 0:
            return 0.0, 0.0
        j = tables.previous[link * tables.steps + n]
        first = source * (tables.steps + 1)
        newest, age = tables.samples[first + i], float(n - tables.leads[link] - i)
        reach = horizon * tables.drawn[link]
        if j < 0:
            return extend(newest, newest, age, 1.0, reach)  # type: ignore[no-any-return]
        previous = tables.samples[first + j]
        return extend(newest, previous, age, float(i - j), reach)  # type: ignore[no-any-return]

    return compile(receive)


def _make_lines(receives: Sequence[Any], compile: Compile) -> Any:
    """Return one function that gives the lines of all inputs of a block: (bases, slopes)."""
    if len(receives) > FLAT:
        middle = len(receives) // 2
        left = _make_lines(receives[:middle], compile)
        right = _make_lines(receives[middle:], compile)

        def halves(n: int, horizon: float, tables: Tables) -> Any:
            bases, slopes = left(n, horizon, tables)
            more_bases, more_slopes = right(n, horizon, tables)
            return (*bases, *more_bases), (*slopes, *more_slopes)

        return compile(halves)
    head = receives[0]
    if len(receives) == 1:

        def one(n: int, horizon: float, tables: Tables) -> Any:
            base, slope = head(n, horizon, tables)
            return (base,), (slope,)

        return compile(one)
    tail = _make_lines(receives[1:], compile)

    def several(n: int, horizon: float, tables: Tables) -> Any:
        base, slope = head(n, horizon, tables)
        bases, slopes = tail(n, horizon, tables)
        return (base, *bases), (slope, *slopes)

    return compile(several)


def _numbers(part: Part, first: int) -> list[tuple[int, int]]:
    """Return (source, link) of each input of a part whose first link is ``first``."""
    found = []
    for source in part.sources:
        found.append((source, first))
        first += source != NOBODY
    return found


def _make_ordinary(part: Part, first: int, compile: Compile) -> Any:
    """Return ``step(n, x, tuning, tables) -> (x, y)``, a block from sample n to n + 1."""
    numbers = _numbers(part, first) or [(NOBODY, 0)]
    lines = _make_lines([_make_receive(*number, compile) for number in numbers], compile)
    move = make_advance(part.model, compile)

    def step(n: int, x: Any, tuning: Tuning, tables: Tables) -> Any:
        base, slope = lines(n, tuning.horizon, tables)
        return move(x, tuning.sign, base, slope, tuning.params, tables.h)

    return compile(step)


def _make_advance(part: Part, step: Any, compile: Compile) -> Any:
    """Return ``advance(n, x, tuning, tables) -> x``: the step, with what is written of it."""
    row = part.row

    def advance(n: int, x: Any, tuning: Any, tables: Tables) -> Any:
        x, y = step(n, x, tuning, tables)
        tables.samples[row * (tables.steps + 1) + n + 1] = y
        return x

    def advance_noisy(n: int, x: Any, tuning: Any, tables: Tables) -> Any:
        x, y = step(n, x, tuning, tables)
        tables.samples[row * (tables.steps + 1) + n + 1] += y
        return x

    chosen = compile(advance_noisy if part.noisy else advance)
    if part.code is not None:
        chosen = _make_coded(part, part.code, step, compile)
    return _with_observed(chosen, part.observed, compile)


def _make_coded(part: Part, coded: CodedOutput, step: Any, compile: Compile) -> Any:
    """Return the same of a block whose output is coded; noise is added before that."""
    row, code, noise = part.row, coded.make(compile), 1.0 if part.noisy else 0.0
    size, receive = coded.size, _make_copies(coded.copies, coded.make_copy(compile), compile)

    def advance(n: int, x: Any, tuning: Any, tables: Tables) -> Any:
        i = row * (tables.steps + 1) + n + 1
        z, y = step(n, x[:size], tuning[0], tables)
        tables.samples[i], c = code(y + noise * tables.samples[i], x[size:], tuning[1], tables.h)
        receive(n, c[0], c[1], tuning[1], tables)
        return z + c

    return compile(advance)


def _make_copies(copies: Sequence[Copy], copy: Any, compile: Compile) -> Any:
    """Return ``receive(n, sent, message, tuning, tables)``: the step of all receivers."""
    if not copies:

        def nobody(n: int, sent: float, message: float, tuning: Any, tables: Tables) -> None:
            return

        return compile(nobody)
    (row, place), others = copies[0], _make_copies(copies[1:], copy, compile)

    def receive(n: int, sent: float, message: float, tuning: Any, tables: Tables) -> None:
        others(n, sent, message, tuning, tables)
        stride = tables.steps + 1
        heard = sent if tables.lost[place * stride + n + 1] == 0 else 0.0
        i = row * stride + n + 1
        copy(tables.samples, i, stride, heard, message, tuning, tables.h)

    return compile(receive)


def _with_observed(advance: Any, observed: Sequence[tuple[int, int]], compile: Compile) -> Any:
    """Return ``advance`` such that it also writes some of the states at its end."""
    if not observed:
        return advance
    (row, index), inner = observed[-1], _with_observed(advance, observed[:-1], compile)

    def advance_observed(n: int, x: Any, tuning: Tuning, tables: Tables) -> Any:
        x = inner(n, x, tuning, tables)
        tables.samples[row * (tables.steps + 1) + n + 1] = x[index]
        return x

    return compile(advance_observed)


def _make_numbered(part: Part, first: int, compile: Compile) -> Any:
    """Return such a step of a block that reads its inputs by number."""
    assert part.make is not None
    own = _make_reader(part.row, 0).value
    readers = [_make_reader(*number) for number in _numbers(part, first)]
    move = part.make(part.model, readers, own, compile)

    def step(n: int, x: Any, tuning: Any, tables: Tables) -> Any:
        return move(n, x, tuning, tables.h, tables)

    return compile(step)


def _make_reader(source: int, link: int) -> Reader:
    """Return how the samples of a link are read from the tables by number."""
    if source == NOBODY:
        return Reader(lambda n, tables: -1, lambda s, tables: -1, lambda s, tables: 0.0)

    def newest(n: int, tables: Tables) -> int:
        return tables.newest[link * tables.steps + n]  # type: ignore[no-any-return]

    def last(s: int, tables: Tables) -> int:
        return tables.used[link * tables.steps + s] if s >= 0 else -1

    def value(s: int, tables: Tables) -> float:
        return tables.samples[source * (tables.steps + 1) + s]  # type: ignore[no-any-return]

    return Reader(newest, last, value)


def _make_chain(advances: Sequence[Any], compile: Compile) -> Any:
    """Return one function that advances all blocks, each from the samples up to n."""
    if not advances:

        def nobody(n: int, states: Any, tunings: Any, tables: Tables) -> Any:
            return states

        return compile(nobody)
    if len(advances) > FLAT:
        middle = len(advances) // 2
        head = _make_chain(advances[:middle], compile)
        tail = _make_chain(advances[middle:], compile)
    else:
        head, tail = advances[0], _make_chain(advances[1:], compile)

    def chain(n: int, states: Any, tunings: Any, tables: Tables) -> Any:
        return (
            head(n, states[0], tunings[0], tables),
            tail(n, states[1], tunings[1], tables),
        )

    return compile(chain)
