"""The executables of setup.py, one per node: the first thing that runs, so it says if ROS lacks."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from functools import partial

from ..errors import ros_is_missing
from ..scenario.names import KINDS


def run(node: str) -> int:
    """Run ``node`` until SIGINT or SIGTERM; 2 and one line where there is no ROS."""
    try:
        module = importlib.import_module(f'.{node}', __package__)
    except ImportError as error:
        print(f'eventreg_ros: {ros_is_missing(node, error)}', file=sys.stderr)
        return 2
    return int(module.main())


def __getattr__(name: str) -> Callable[[], int]:
    if name in KINDS:
        return partial(run, name)
    raise AttributeError(name)
