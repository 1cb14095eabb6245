# SPDX-License-Identifier: Apache-2.0
"""Where a file that is being written lies: whether somebody deleted, moved or cut it meanwhile."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import BagError


class Place:
    """The place of one file, from now on; the writer itself would write on without a word."""

    def __init__(self, path: Path) -> None:
        """Take the file that is at ``path``. Raises OSError."""
        self.path = path
        self._size, self._file = _seen(path)

    def check(self) -> None:
        """Raise BagError when the file is not here any more, or shorter than when last checked."""
        try:
            size, file = _seen(self.path)
        except OSError:
            size, file = 0, None
        if file != self._file:
            raise BagError(
                f'bag {self.path.parent} was deleted or moved while it was written; leave it '
                'where it is until the recorder has ended'
            )
        if size < self._size:
            raise BagError(
                f'{self.path} was cut from {self._size} to {size} bytes while it was written; '
                'leave it as it is until the recorder has ended'
            )
        self._size = size


def _seen(path: Path) -> tuple[int, tuple[int, int]]:
    """Return the size of a file, and what makes it that file and no other."""
    status = os.stat(path)
    return status.st_size, (status.st_dev, status.st_ino)
