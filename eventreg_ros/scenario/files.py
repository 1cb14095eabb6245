# SPDX-License-Identifier: Apache-2.0
"""Where scenarios are found: the shipped ones by name, others by path."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import ScenarioError
from ..files import UnreadableError, read_text


def config_directory() -> Path:
    """Return the directory of the shipped scenarios, in a source tree or in an installation.

    Raises ScenarioError when the package was installed without them.
    """
    package = Path(__file__).resolve().parent
    for root in package.parents:
        for found in (root / 'config', root / 'share' / 'eventreg_ros' / 'config'):
            if (found / 'exact.yaml').is_file():
                return found
    raise ScenarioError(
        f'the shipped scenarios are missing beside {package}; install the package again'
    )


def shipped() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(path.stem for path in config_directory().glob('*.yaml'))


def summary(name: str) -> str:
    """Return what a shipped scenario is, in a sentence: the first line of its file."""
    with open(config_directory() / f'{name}.yaml', encoding='utf-8') as file:
        return file.readline().removeprefix('#').strip()


def find(scenario: str) -> Path:
    """Return the file of a scenario given by name or path. Raises ScenarioError."""
    path = Path(scenario)
    if path.suffix in ('.yaml', '.yml') or '/' in scenario:
        if os.path.lexists(path):
            return path
        raise ScenarioError(f'scenario file {scenario!r} does not exist; check the path')
    if scenario not in shipped():
        raise ScenarioError(
            f'no scenario {scenario!r}; shipped are {", ".join(shipped())}, '
            f'or give the path of a .yaml file'
        )
    return config_directory() / f'{scenario}.yaml'


def text_of(path: Path) -> str:
    """Return the text of a scenario's file. Raises ScenarioError."""
    try:
        return read_text(path)
    except UnreadableError as error:
        raise ScenarioError(f'scenario {path} must be a readable text file: {error}') from None
