# SPDX-License-Identifier: Apache-2.0
"""What a person sees while a run goes on."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping

from ..session.observer import Observer


class Terminal(Observer):
    """Time and event counts: one line that is written over, or, in a file, one every 5 s."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._terminal = sys.stdout.isatty()
        self._next = 0.0
        self._open = False
        """Whether the cursor is behind counts that will be written over."""

    def began(self, line: str) -> None:
        """Print the first line."""
        print(line, flush=True)

    def warned(self, line: str) -> None:
        """Print a line on standard error, below the counts."""
        start, self._open = '\n' if self._open else '', False
        print(f'{start}eventreg: {line}', file=sys.stderr, flush=True)

    def progressed(self, elapsed: float, counts: Mapping[str, int], last: bool = False) -> None:
        """Show the counts at ``elapsed`` seconds, if it is time to."""
        if elapsed < self._next and not last:
            return
        self._next = elapsed + (0.2 if self._terminal else 5.0)
        events = '  '.join(f'{signal} {count}' for signal, count in counts.items())
        line = f'{elapsed:6.1f} of {self._duration:g} s   events: {events}'
        self._open = self._terminal and not last
        end = '' if self._open else '\n'
        print(f'\r{line}' if self._terminal else line, end=end, flush=True)


class Count:
    """How many of how many are done and when the rest will be, on standard error.

    ``unit`` is what is counted; the first ``slow`` steps say nothing of the pace, since something
    is loaded or compiled meanwhile. On a terminal one line that is written over, else a line every
    10 s.
    """

    def __init__(self, unit: str = 'sets', slow: int = 0) -> None:
        self._unit, self._slow = unit, slow
        self._terminal = sys.stderr.isatty()
        self._began = time.monotonic()
        self._marks: list[tuple[float, int]] = []
        """When how many were done, since about half of the time ago."""
        self._next = 0.0 if self._terminal else 10.0

    def show(self, done: int, count: int, doing: str = '') -> None:
        """Show that ``done`` of ``count`` are done, and what was done last or is being done.

        A count of 0 is not known.
        """
        elapsed = time.monotonic() - self._began
        left = self._left(elapsed, done, count)
        if elapsed < self._next:
            return
        self._next = elapsed + (0.2 if self._terminal else 10.0)
        words = f'{done} of {count} {self._unit}' if count else f'{done} {self._unit}'
        if left is not None:
            words += f', {_span(left)} to go'
        words += f' ({doing})' if doing else ''
        start, end = ('\r\x1b[K', '') if self._terminal else ('', '\n')
        print(f'{start}{words}', end=end, file=sys.stderr, flush=True)

    def _left(self, elapsed: float, done: int, count: int) -> float | None:
        """Return how many seconds the rest takes at the pace of the last half of the time.

        None where that is not known yet.
        """
        if self._slow > 0:
            self._slow -= 1
            return None
        self._marks.append((elapsed, done))
        while len(self._marks) > 2 and self._marks[1][0] <= elapsed / 2.0:
            del self._marks[0]
        before, had = self._marks[0]
        return (count - done) * (elapsed - before) / (done - had) if count and done > had else None

    def clear(self) -> None:
        """Leave an empty line on a terminal."""
        if self._terminal:
            print('\r\x1b[K', end='', file=sys.stderr, flush=True)


def say_if_slow(words: str) -> None:
    """Say on standard error that numba is missing, if it is, and what that means."""
    from ..simulation.jit import compiles

    if not compiles():
        print(
            f"eventreg: numba is not installed, so {words}; pip install '.[fast]' in the sources "
            'of eventreg_ros',
            file=sys.stderr,
            flush=True,
        )


def _span(seconds: float) -> str:
    """Return a duration in words: 40 s, 12 min, 3.5 h."""
    if seconds < 100.0:
        return f'{seconds:.0f} s'
    return f'{seconds / 60.0:.0f} min' if seconds < 6000.0 else f'{seconds / 3600.0:.1f} h'
