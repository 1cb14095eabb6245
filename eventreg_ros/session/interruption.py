# SPDX-License-Identifier: Apache-2.0
"""Signals while a run goes on: noted, looked at, and kept out of its end."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .. import interrupts

UNHEEDED = 2.0
"""Seconds for which a signal may wait to be looked at; then a second one breaks in at once."""


class InterruptError(Exception):
    """SIGINT, SIGTERM or SIGHUP: stop early, and judge what was recorded."""


class Interruption:
    """Notes a signal until somebody looks: an exception out of nowhere could be lost in a callback.

    If nobody has looked for a while, a further signal raises InterruptError there and then.
    """

    _noted: float | None = None

    def __call__(self, number: int, frame: object) -> None:
        """Handle a signal."""
        now = time.monotonic()
        if self._noted is None:
            self._noted = now
        elif now - self._noted > UNHEEDED:
            raise InterruptError

    def look(self) -> None:
        """Raise InterruptError when there was a signal."""
        if self._noted is not None:
            raise InterruptError


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let nothing stop the stopping."""
    with handling(signal.SIG_IGN):
        yield


@contextmanager
def handling(handler: interrupts.Handler) -> Iterator[None]:
    """Handle the signals so, where they can be: Python handles signals in the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = interrupts.handle(handler)
    try:
        yield
    finally:
        interrupts.restore(before)
