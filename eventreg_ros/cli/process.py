# SPDX-License-Identifier: Apache-2.0
"""What the process of a command needs before and after its work: streams, signals, exit codes."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext

from .. import interrupts
from ..errors import EventregError, complain, confess
from ..files import reason_of

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)

PIPE_CLOSED = 141
"""The exit code when nobody reads on: the shell's, for SIGPIPE."""


def fail(message: object) -> int:
    """Print ``message`` as one line on standard error and return the exit code of bad input."""
    return complain('eventreg', message)


def guarded(work: Callable[[], int], interruptible: bool = True) -> int:
    """Return the exit code of ``work``; whatever it raises becomes one line and a code.

    2 for bad input, 141 when nobody reads on, 70 for a fault of our own, and, unless it is not
    ``interruptible`` but sees to signals itself, 130 after SIGINT, SIGTERM or SIGHUP.
    """
    _open_streams()
    try:
        with _interruptible() if interruptible else nullcontext():
            try:
                return work()
            finally:
                sys.stdout.flush()
    except EventregError as error:
        return fail(error)
    except KeyboardInterrupt:
        return interrupts.INTERRUPTED
    except BrokenPipeError:
        return PIPE_CLOSED
    except OSError as error:
        full = error.filename is None and error.errno in _FULL
        return fail(f'output: {reason_of(error)}; send it elsewhere' if full else error)
    except MemoryError:
        return fail('out of memory; take a shorter duration, fewer steps or a smaller file')
    except Exception as error:
        return confess('eventreg', error)
    finally:
        _flush_or_drop()


def _open_streams() -> None:
    """Open what was closed (``>&-``) on the null device: no file of ours must get its number.

    What a stream's encoding does not have is printed escaped.
    """
    for number, name in enumerate(('stdin', 'stdout', 'stderr')):
        stream = getattr(sys, name)
        if stream is None:
            while (null := os.open(os.devnull, os.O_RDWR)) < number:
                pass
            if null > number:
                os.dup2(null, number)
                os.close(null)
            setattr(sys, name, os.fdopen(number, 'w' if number else 'r', encoding='utf-8'))
        elif name == 'stdout' and hasattr(stream, 'reconfigure'):
            stream.reconfigure(errors='backslashreplace')


def _flush_or_drop() -> None:
    """Leave nothing in the streams that Python would fail to write at its end."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            _drop(stream)


def _drop(stream: object) -> None:
    """Let what ``stream`` still holds go nowhere."""
    try:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())  # type: ignore[attr-defined]
        os.close(null)
    except (OSError, ValueError, AttributeError):
        pass


@contextmanager
def _interruptible() -> Iterator[None]:
    """Raise KeyboardInterrupt for SIGINT, SIGTERM and SIGHUP, once."""
    before = interrupts.handle(interrupts.Interrupt())
    try:
        yield
    finally:
        interrupts.restore(before)
