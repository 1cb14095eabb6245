# SPDX-License-Identifier: Apache-2.0
"""Where scenarios are found, the shipped ones by name, others by path; and what they refer to."""

from __future__ import annotations

import difflib
import os
from pathlib import Path

from ..errors import ScenarioError
from ..files import UnreadableError, read_text
from .hint import LONG
from .names import kind_of


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
        like = f', or take the shipped {path.stem!r}' if path.stem in shipped() else ''
        raise ScenarioError(f'scenario file {scenario!r} does not exist; check the path{like}')
    if scenario not in shipped():
        close = difflib.get_close_matches(scenario[:LONG], shipped(), 1)
        known = f'did you mean {close[0]!r}' if close else f'shipped are {", ".join(shipped())}'
        raise ScenarioError(f'no scenario {scenario!r}; {known}, or give the path of a .yaml file')
    return config_directory() / f'{scenario}.yaml'


def text_of(path: Path) -> str:
    """Return the text of a scenario's file. Raises ScenarioError."""
    try:
        return read_text(path)
    except UnreadableError as error:
        raise ScenarioError(f'scenario {path} must be a readable text file: {error}') from None


def names_file(node: str, parameter: str) -> bool:
    """Say whether a parameter is the path of a file to read; ``node`` may hold wildcards."""
    return parameter == 'file' and ('*' in node.rpartition('/')[2] or kind_of(node) == 'stimulus')


def from_file(path: str, base: Path) -> str:
    """Return in full a path that a file in the directory ``base`` names; '' stays."""
    return str(base.absolute() / path) if path else path
