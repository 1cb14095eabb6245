"""Which form of the kernel to run: plain Python, or compiled once the work pays for compiling."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache
from typing import Any

from ..errors import EventregError
from .kernel import Kernel, Part, make_kernel

Parts = tuple[Part, ...]

PAYS = 1_000_000
"""Block-steps in plain Python (3 us each) that take about as long as compiling does (3 s)."""

_INNER: dict[str, Any] = {
    'error_model': 'numpy',
    'forceinline': True,
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
}

_walked: Counter[Parts] = Counter()
_compiled: dict[Parts, Kernel] = {}


def choose(parts: Parts, steps: int, compiled: bool | None) -> tuple[Kernel, bool]:
    """Return a kernel for ``parts``, and whether it is the compiled one.

    ``compiled`` True or False settles it. None takes the compiled one when this process has it
    already, or when numba is there and the steps taken so far and the ``steps`` to come would have
    paid for compiling. Raises EventregError when it is True and there is no numba.
    """
    if compiled is None:
        walked = _walked[parts] + steps * len(parts)
        compiled = parts in _compiled or (walked > PAYS and _njit() is not None)
        if not compiled:
            _walked[parts] = walked
    return (_compile(parts), True) if compiled else (_plain(parts), False)


def compiles() -> bool:
    """Say whether numba is there to compile with."""
    return _njit() is not None


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
        njit = _njit()
        if njit is None:
            raise EventregError('compiled needs numba; pip install numba, or leave compiled out')
        _compiled[parts] = njit(make_kernel(parts, njit(**_INNER)), error_model='numpy')
    return _compiled[parts]
