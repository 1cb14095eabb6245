"""The errors that a user can fix: one line each, with where, what rule, what value, what to do."""

import reprlib


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
    return _SHORT.repr(value)


def ros_is_missing(who: str, error: ImportError) -> str:
    """Return what to tell a user who wants to run ``who`` where ROS cannot be imported."""
    return (
        f"{who} needs ROS 2 ({error}): source your ROS setup, or pip install '.[ros]' in the "
        'sources of eventreg_ros (x86_64 Linux, Python 3.10 to 3.13)'
    )
