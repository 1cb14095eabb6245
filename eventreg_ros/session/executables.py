# SPDX-License-Identifier: Apache-2.0
"""Which executable runs a node of a scenario: ours, or that of another package."""

from __future__ import annotations

import os
import sys
from importlib.metadata import PackageNotFoundError, distribution

from ..errors import ScenarioError
from ..nodes.environment import prefixes
from ..scenario import Scenario
from ..scenario.names import split

PREFIXES = 'AMENT_PREFIX_PATH'


def package_and_executable(scenario: Scenario, node: str) -> tuple[str, str]:
    """Return what ``ros2 run`` needs to start ``node``."""
    if node not in scenario.foreign:
        return 'eventreg_ros', split(node).kind
    values = scenario.nodes[node]
    return values['package'], values['executable']


def executable_of(scenario: Scenario, node: str) -> list[str]:
    """Return the command that runs ``node``, without its arguments.

    An executable of another package is looked for as ``ros2 run`` does, in lib/PACKAGE of every
    ament prefix and of this Python's, then among the commands that the package installs with pip.
    Raises ScenarioError when it is nowhere.
    """
    if node not in scenario.foreign:
        return [sys.executable, '-m', f'eventreg_ros.nodes.{split(node).kind}']
    package, name = package_and_executable(scenario, node)
    for prefix in prefixes(os.environ):
        file = prefix / 'lib' / package / name
        if os.access(file, os.X_OK) and file.is_file():
            return [str(file)]
    if command := _installed(package, name):
        return command
    raise ScenarioError(
        f'{node}: no executable {name!r} of package {package!r} in {PREFIXES} or in this Python; '
        'build and source, or pip install, the package'
    )


def _installed(package: str, name: str) -> list[str] | None:
    """Return the command that the entry point ``name`` of a distribution stands for."""
    try:
        entries = distribution(package).entry_points
    except PackageNotFoundError:
        return None
    for entry in entries.select(group='console_scripts', name=name):
        call = f'import sys; from {entry.module} import {entry.attr}; sys.exit({entry.attr}())'
        return [sys.executable, '-c', call]
    return None
