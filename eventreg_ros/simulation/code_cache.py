# SPDX-License-Identifier: Apache-2.0
"""Machine code that is kept between processes: numba's cache, with the right key.

numba looks up a function by the file that it stands in, and does not notice when a function that it
calls has changed. What is compiled here is generated, and calls what models bring along; so each
function gets a file of its own in the user's cache directory, named by a fingerprint of itself and
of everything that it calls. Where that directory cannot be written, nothing is kept.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from threading import Lock
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

RULES = 4
"""How functions are compiled; another number when the same functions make other machine code."""


def directory() -> Path:
    """Return where the machine code is kept: numba's own directory if set, else the user's."""
    if given := os.environ.get('NUMBA_CACHE_DIR'):
        return Path(given) / 'eventreg_ros'
    if sys.platform == 'win32':
        home = os.environ.get('LOCALAPPDATA') or str(Path.home() / 'AppData' / 'Local')
    elif sys.platform == 'darwin':
        home = str(Path.home() / 'Library' / 'Caches')
    else:
        home = os.environ.get('XDG_CACHE_HOME') or str(Path.home() / '.cache')
    return Path(home) / 'eventreg_ros'


class _Digest:
    """A digest of code that grows by what is put in."""

    def __init__(self) -> None:
        self._digest, self._seen = hashlib.sha256(), set[int]()

    def add(self, thing: Any) -> None:
        """Put in a function with all that it calls, a plain value, or several of them."""
        thing = getattr(thing, 'py_func', thing)  # of what numba compiled
        if isinstance(thing, FunctionType):
            self._function(thing)
        elif isinstance(thing, CodeType):
            self._digest.update(thing.co_code)
            self.add((thing.co_varnames, thing.co_names, thing.co_freevars, thing.co_consts))
        elif isinstance(thing, tuple):
            self._digest.update(f'{len(thing)}'.encode())
            for each in thing:
                self.add(each)
        elif isinstance(thing, int | float | complex | str | bytes | None):
            self._digest.update(f'{type(thing).__name__}{thing!r}'.encode())
        elif isinstance(thing, np.ndarray | np.generic):  # constants to numba
            self.add((str(thing.dtype), thing.shape, thing.tobytes()))
        else:  # a class or a module
            name = getattr(thing, '__qualname__', getattr(thing, '__name__', ''))
            self.add((type(thing).__qualname__, name, getattr(thing, '_fields', ())))

    def _function(self, function: FunctionType) -> None:
        if id(function) in self._seen:
            return
        self._seen.add(id(function))
        self.add((function.__code__, function.__defaults__))
        for cell in function.__closure__ or ():
            self.add(cell.cell_contents)
            self._of_module(cell.cell_contents, function.__code__)
        for name in _names(function.__code__):
            self.add(function.__globals__.get(name))
            self._of_module(function.__globals__.get(name), function.__code__)

    def _of_module(self, module: Any, code: CodeType) -> None:
        """Put in what code may read of a module, and of the modules in it."""
        if not isinstance(module, ModuleType) or id(module) in self._seen:
            return
        self._seen.add(id(module))
        for name in _names(code):
            self.add(vars(module).get(name))
            self._of_module(vars(module).get(name), code)
        self._seen.discard(id(module))

    @property
    def text(self) -> str:
        """The digest so far."""
        return self._digest.hexdigest()[:32]


def _names(code: CodeType) -> Iterator[str]:
    """Yield the names of globals and attributes in code, also in its comprehensions."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def fingerprint(function: FunctionType) -> str:
    """Return a digest of a function, of all that it calls, and of the constants that it uses."""
    digest = _Digest()
    digest.add(RULES)
    digest.add(function)
    return digest.text


def generated(source: str, name: str, names: Mapping[str, Any]) -> FunctionType:
    """Return the function ``name`` that ``source`` defines, with ``names`` as its globals."""
    home = {'__name__': __name__, **names}
    exec(compile(source, f'<generated {name}>', 'exec'), home)
    function = home[name]
    assert isinstance(function, FunctionType)
    return function


class Kept:
    """A compiled function whose machine code comes from the cache, or goes there.

    Where that fails, for whatever reason, it is compiled as if there were no cache. It is called
    with arguments of the same types always.
    """

    def __init__(self, kept: Any, fresh: Callable[[], Any]) -> None:
        self.function, self._fresh = kept, fresh
        self._lock, self._ready = Lock(), False

    def __call__(self, *arguments: Any) -> Any:
        """Call the function; the first call compiles it, or takes it from the cache."""
        if not self._ready:
            with self._lock:
                self._prepare(arguments)
        return self.function(*arguments)

    def _prepare(self, arguments: tuple[Any, ...]) -> None:
        from numba import typeof

        if self._ready:
            return
        try:
            self.function.compile(tuple(map(typeof, arguments)))
        except Exception:  # numba's, pickle's, the file system's, those of imports
            self.function = self._fresh()
        self._ready = True


def is_kept(function: FunctionType) -> bool:
    """Say whether :func:`compile_kept` compiled such a function before, so that it is loaded."""
    return (directory() / _name(function)).is_file()


def _name(function: FunctionType) -> str:
    return f'{function.__name__}_{fingerprint(function)}.py'


def compile_kept(njit: Any, function: FunctionType, **options: Any) -> Any:
    """Return ``function`` compiled by ``njit``, its machine code kept where that is possible.

    It may have no closure. ``options`` are numba's.
    """
    name = _name(function)
    path = _written(name, f'# {name}\n')
    if path is None:
        return njit(**options)(function)
    code = function.__code__.replace(co_filename=path)
    placed = FunctionType(code, function.__globals__, function.__name__, function.__defaults__)
    try:
        kept = njit(cache=True, **options)(placed)
    except (RuntimeError, OSError):  # numba found no place to write
        return njit(**options)(function)
    return Kept(kept, lambda: njit(**options)(function))


def _written(name: str, source: str) -> str | None:
    """Return the path of a file of that name and content, None where it cannot be written."""
    path = directory() / name
    try:
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            draft = path.with_suffix(f'.{os.getpid()}')
            draft.write_text(source, encoding='utf-8')
            draft.replace(path)
    except (OSError, RuntimeError):  # RuntimeError: no home directory
        return None
    return str(path)
