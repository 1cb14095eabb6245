# SPDX-License-Identifier: Apache-2.0
"""Which form of the kernel to run: plain Python, or compiled once the work pays for compiling."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache
from types import CellType, FunctionType
from typing import Any

from ..errors import EventregError
from .code_cache import compile_kept, is_kept
from .kernel import Kernel, Part, make_kernel
from .same_bits import is_foreign, pipeline
from .step import Compile

Parts = tuple[Part, ...]

PAYS = 1_000_000
"""Block-steps in plain Python (3 us each) that take about as long as compiling does (3 s)."""

LOADS = 300_000
"""The same where the machine code is kept from an earlier process: it is loaded within a second."""

MOST = 32
"""Blocks, or inputs of a block, up to which numba compiles within seconds."""

_INNER: dict[str, Any] = {
    'error_model': 'numpy',
    'forceinline': True,
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
}

_walked: Counter[Parts] = Counter()
_compiled: dict[Parts, Kernel] = {}
_refused: set[Parts] = set()


class Whole:
    """Compiles a function together with the plain functions that it calls by closure or by name.

    numba knows none but compiled ones; so a model may call functions of its own, and be made of
    another model's. What is no plain Python function, compiled ones say, stays as it is. Functions
    of other packages are compiled by ``compile_as_python``; see :mod:`.same_bits`.
    """

    def __init__(self, compile: Compile, compile_as_python: Compile) -> None:
        self._compile, self._compile_as_python = compile, compile_as_python
        self._known: dict[FunctionType, Any] = {}

    def __call__(self, function: Any) -> Any:
        """Return ``function`` compiled, once however often it is called."""
        if not isinstance(function, FunctionType):
            return function
        if function not in self._known:
            self._known[function] = function  # while it is on its way: it may call itself
            whole = self.with_callees(function)
            whole.__module__ = whole.__module__ or __name__  # numba's cache asks for one
            compile = self._compile_as_python if is_foreign(function) else self._compile
            self._known[function] = compile(whole)
        return self._known[function]

    def with_callees(self, function: FunctionType) -> FunctionType:
        """Return ``function`` with the plain functions that it calls replaced by compiled ones."""
        held = [cell.cell_contents for cell in function.__closure__ or ()]
        named = {name: function.__globals__.get(name) for name in function.__code__.co_names}
        called = {name: self(f) for name, f in named.items() if isinstance(f, FunctionType)}
        if not called and not any(isinstance(each, FunctionType) for each in held):
            return function
        return FunctionType(
            function.__code__,
            {**function.__globals__, **called},
            function.__name__,
            function.__defaults__,
            tuple(CellType(self(each)) for each in held),
        )


def choose(parts: Parts, work: int, compiled: bool | None) -> tuple[Kernel, bool]:
    """Return a kernel for ``parts``, and whether it is the compiled one.

    ``compiled`` True or False settles it. None takes the compiled one when this process has it
    already, or when numba is there and the ``work`` to come (in block-steps), with what was done so
    far, would have paid for compiling, or for loading what was compiled before. Raises
    EventregError when it is True and there is no numba.
    """
    if compiled is None:
        walked = _walked[parts] + work
        compiled = parts in _compiled or _pays(parts, walked)
        if not compiled:
            _walked[parts] = walked
    return (_compile(parts), True) if compiled else (_plain(parts), False)


def _pays(parts: Parts, work: int) -> bool:
    """Say whether the compiled kernel is there sooner than so much work is done in plain Python."""
    if work <= min(LOADS, PAYS) or parts in _refused or not _fits(parts) or not compiles():
        return False
    return work > PAYS or is_kept(_entry(parts))


def give_up(parts: Parts) -> None:
    """Note that numba cannot compile ``parts``: a model of theirs is not written for it."""
    _refused.add(parts)
    _compiled.pop(parts, None)


def _fits(parts: Parts) -> bool:
    """Say whether numba is up to a loop of this size; it unrolls all of it."""
    return len(parts) <= MOST and all(len(part.sources) <= MOST for part in parts)


def compiles() -> bool:
    """Say whether numba is there to compile with."""
    return _njit() is not None


def inliner() -> Whole:
    """Return what compiles functions that other compiled ones call. Raises EventregError."""
    return _whole(_INNER)


def _whole(options: dict[str, Any]) -> Whole:
    njit = _need_njit()

    def as_python(function: Any) -> Any:
        return njit(**options, pipeline_class=pipeline())(function)

    return Whole(njit(**options), as_python)


@lru_cache(maxsize=16)
def compile_callee(function: Any) -> Any:
    """Return a function that compiled ones call, compiled once for all of them.

    It may have no closure, and call none but compiled ones and others of this kind.
    """
    quiet = {name: value for name, value in _INNER.items() if name != 'forceinline'}
    return _whole(quiet)(function)


def compile_entry(function: Any) -> Any:
    """Return a function that Python calls, compiled; it lets other threads run meanwhile.

    What it calls must be compiled already, except its own plain helpers. It may have no closure;
    its machine code is kept for the next process. Raises EventregError when there is no numba.
    """
    return _compile_entry(inliner().with_callees(function))


def _compile_entry(function: FunctionType) -> Any:
    return compile_kept(_need_njit(), function, error_model='numpy', nogil=True)


def _need_njit() -> Any:
    njit = _njit()
    if njit is None:
        raise EventregError('compiled needs numba; pip install numba, or leave compiled out')
    return njit


def _njit() -> Any:
    """Return numba's njit, or None where numba is missing or does not fit the other packages."""
    try:
        from numba import njit
    except ImportError:
        return None
    return njit


@lru_cache(maxsize=64)
def _plain(parts: Parts) -> Kernel:
    return make_kernel(parts)


def _compile(parts: Parts) -> Kernel:
    """Return the kernel compiled by numba, which happens at its first call and takes seconds.

    Nothing here permits numba to reorder or fuse arithmetic, so the bits are those of plain Python.
    Inlining everything makes it four times as fast; doing without wrappers that only Python would
    call halves the time of compiling.
    """
    if parts not in _compiled:
        _compiled[parts] = _compile_entry(_entry(parts))
    return _compiled[parts]


@lru_cache(maxsize=64)
def _entry(parts: Parts) -> FunctionType:
    compile = inliner()
    kernel: Any = make_kernel(parts, compile)
    return compile.with_callees(kernel)
