# SPDX-License-Identifier: Apache-2.0
"""The remedy for a name that nobody knows."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONG = 80
"""Characters of a name that are looked at."""


def hint(name: str, known: Iterable[str], having: str = 'it has') -> str:
    """Return the remedy for a name that is not among ``known``: the nearest, or all of them."""
    known = list(known)
    close = difflib.get_close_matches(name[:LONG], known, 1)
    return f'; did you mean {close[0]!r}?' if close else f'; {having} {", ".join(sorted(known))}'
