# SPDX-License-Identifier: Apache-2.0
"""SIGINT, SIGTERM and SIGHUP, from the first line of a process to its last."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from types import FrameType

SIGNALS = tuple(
    getattr(signal, name) for name in ('SIGINT', 'SIGTERM', 'SIGHUP') if hasattr(signal, name)
)

INTERRUPTED = 130
"""The exit code of a command that was interrupted."""

PATIENCE = 1.0
"""Seconds within which a further signal does not disturb what the first has begun."""

Handler = Callable[[int, FrameType | None], object] | int | signal.Handlers | None


class Interrupt:
    """A handler that raises KeyboardInterrupt once; what comes long after that ends the process."""

    _first: float | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle the signal ``number``."""
        now = time.monotonic()
        if self._first is None:
            self._first = now
            raise KeyboardInterrupt
        if now - self._first > PATIENCE:  # the exception was lost, or the end takes too long
            os._exit(INTERRUPTED)


def handle(handler: Handler) -> dict[int, Handler]:
    """Set ``handler`` for each of :data:`SIGNALS` that is not ignored; return what was there.

    Does nothing outside of the main thread, which alone has handlers.
    """
    before: dict[int, Handler] = {}
    for number in SIGNALS:
        old = signal.getsignal(number)
        if old is not signal.SIG_IGN:
            try:
                signal.signal(number, handler)
            except ValueError:
                break
            before[number] = old
    return before


def restore(before: dict[int, Handler]) -> None:
    """Set the handlers that :func:`handle` found."""
    for number, handler in before.items():
        signal.signal(number, handler)


def block() -> None:
    """Keep :data:`SIGNALS` waiting; a process that is started now begins like that."""
    if hasattr(signal, 'pthread_sigmask'):
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)


def unblock() -> None:
    """Let :data:`SIGNALS` through, those that are waiting first."""
    if hasattr(signal, 'pthread_sigmask'):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
