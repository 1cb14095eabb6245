# SPDX-License-Identifier: Apache-2.0
"""The errors that a user can fix: one line each, with where, what rule, what value, what to do."""

import contextlib
import os
import reprlib
import sys
import traceback

BAD_INPUT, CRASHED = 2, 70
"""Exit codes that are no verdict; 70 is sysexits' EX_SOFTWARE."""

DEBUG = 'EVENTREG_DEBUG'
"""Environment variable that shows the traceback of a fault of our own."""

LONGEST = 300
"""Characters of an error, the name of the command included."""

CUT = ' [...] '


class EventregError(Exception):
    """Bad input. The message is one line and ends with the remedy; commands exit with 2."""


class ParameterError(EventregError, ValueError):
    """A parameter has the wrong type or breaks its rule."""


class ScenarioError(EventregError, ValueError):
    """A scenario file cannot be found, read, or understood."""


class ModelError(EventregError, LookupError):
    """A model is not there, or the package that offers it is broken."""


class BagError(EventregError, ValueError):
    """A bag cannot be read, or does not hold what the question needs."""


_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 2, 80, 80


def shown(value: object) -> str:
    """Return ``value`` as an error shows it: its repr, cut to a few entries and characters."""
    long = isinstance(value, list) and len(value) > _SHORT.maxlist
    return _SHORT.repr(value) + (f' ({len(value)} entries)' if long else '')  # type: ignore[arg-type]


def described(error: BaseException) -> str:
    """Return type and words of an error, whose words may themselves fail."""
    try:
        return f'{type(error).__name__}: {error}'
    except Exception:  # of whatever package it comes
        return type(error).__name__


def one_line(message: object) -> str:
    """Return ``message`` as one printable line of at most :data:`LONGEST` characters.

    A longer one loses its middle: where it was stands at the beginning, the remedy at the end.
    """
    words = ' '.join(str(message).split())
    line = ''.join(c if c.isprintable() else ascii(c)[1:-1] for c in words)
    if len(line) <= LONGEST:
        return line
    end = (LONGEST - len(CUT)) * 2 // 5
    return line[: LONGEST - len(CUT) - end] + CUT + line[-end:]


def complain(who: str, message: object) -> int:
    """Print ``message`` of the command ``who`` as one line; return the exit code of bad input."""
    with contextlib.suppress(OSError):  # nobody reads it
        print(one_line(f'{who}: {message}'), file=sys.stderr, flush=True)
    return BAD_INPUT


def confess(who: str, error: BaseException) -> int:
    """Print a fault of our own as one line, at length if so asked for; return its exit code."""
    complain(
        who,
        f'fault of its own, please report it: {described(error)}; '
        f'{DEBUG}=1 in the environment shows the traceback',
    )
    if os.environ.get(DEBUG):
        traceback.print_exception(error)
    return CRASHED


def ros_is_missing(who: str, error: ImportError) -> str:
    """Return what to say to a user who wants to run ``who`` where ROS cannot be imported."""
    return (
        f"{who} needs ROS 2 ({error}): source your ROS setup, or pip install '.[ros]' in the "
        'sources of eventreg_ros (x86_64 Linux, Python 3.10 to 3.13)'
    )
