# SPDX-License-Identifier: Apache-2.0
"""The scenario that a node is given as a file."""

from __future__ import annotations

from ..errors import ScenarioError
from ..files import UnreadableError, read_text


def scenario_text(node: str, path: str) -> str | None:
    """Return the text of the parameter file at ``path``, None where none is given.

    Raises ScenarioError that names ``node``.
    """
    if not path:
        return None
    try:
        return read_text(path)
    except UnreadableError as error:
        raise ScenarioError(
            f'{node}.scenario must be a readable file, got {path!r}: {error}; give another'
        ) from None
