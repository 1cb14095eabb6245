# SPDX-License-Identifier: Apache-2.0
"""Neuromorphic disturbance rejection for ROS 2: events are rejected, not trajectories."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import Border as Border
    from .api import Certificate as Certificate
    from .api import Comparison as Comparison
    from .api import Identification as Identification
    from .api import Recorded as Recorded
    from .api import Run as Run
    from .api import Scenario as Scenario
    from .api import Sweep as Sweep
    from .api import analyze as analyze
    from .api import border as border
    from .api import certificates as certificates
    from .api import compare as compare
    from .api import events as events
    from .api import identify as identify
    from .api import judge as judge
    from .api import load as load
    from .api import margins as margins
    from .api import open_run as open_run
    from .api import read_bag as read_bag
    from .api import run as run
    from .api import scenarios as scenarios
    from .api import simulate as simulate
    from .api import sweep as sweep

__version__ = '0.1.0'

__all__ = [
    'Border',
    'Certificate',
    'Comparison',
    'Identification',
    'Recorded',
    'Run',
    'Scenario',
    'Sweep',
    'analyze',
    'border',
    'certificates',
    'compare',
    'events',
    'identify',
    'judge',
    'load',
    'margins',
    'open_run',
    'read_bag',
    'run',
    'scenarios',
    'simulate',
    'sweep',
]


def __getattr__(name: str) -> Any:
    """Import the library (:mod:`.api`) when the first of its names is asked for."""
    if name not in __all__:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    from . import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
