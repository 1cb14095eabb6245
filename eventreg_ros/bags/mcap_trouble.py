# SPDX-License-Identifier: Apache-2.0
"""What goes wrong while an MCAP file is read, gathered into a few sentences."""

from __future__ import annotations

from typing import NamedTuple

from .channel import Account


class _Hole(NamedTuple):
    """A place that could not be read; ``stamp`` is a log time close to it."""

    size: int
    stamp: int | None


class Trouble:
    """Places that cannot be read, chunks that fail their checksum, and what else there is."""

    def __init__(self, name: str, account: Account) -> None:
        self.name = name
        self.account = account
        self.unchecked = False
        """Whether there are messages that no checksum covers."""
        self.holes: list[_Hole] = []
        self._failed: list[int] = []

    def hole(self, size: int, stamp: int | None) -> None:
        """Note that ``size`` bytes could not be read."""
        self.holes.append(_Hole(size, stamp))

    def failed(self, stamp: int) -> None:
        """Note that the chunk that begins at ``stamp`` fails its checksum."""
        self._failed.append(stamp)

    def left_out(self, why: str, stamp: int) -> None:
        """Note that a chunk was not read at all."""
        self.account.note('damaged', f'a chunk of {self.name} {why}; it is left out', stamp=stamp)

    def data_checksum_differs(self) -> None:
        """Note that the checksum of all data is wrong, where nothing else explains it."""
        if self.holes or self._failed:
            return
        if self.unchecked:
            self.account.note('checksum', f'{self.name} fails the checksum of its data')
            return
        self.account.note(
            'summary-disagrees',
            f'{self.name} fails the checksum of its data though every chunk passes its own: an '
            'index is damaged, no sample',
        )

    def conclude(self) -> None:
        """Put what was gathered into the account."""
        note, name = self.account.note, self.name
        if self._failed:
            n = len(self._failed)
            what = '1 chunk fails its' if n == 1 else f'{n} chunks fail their'
            text = f'{what} checksum in {name}: samples in there may be wrong'
            note('checksum', text, stamp=min(self._failed))
        if self.holes:
            size = sum(hole.size for hole in self.holes)
            places = '' if len(self.holes) == 1 else f' at {len(self.holes)} places'
            text = f'{size} bytes of {name} cannot be read{places}'
            note('damaged', text, stamp=self.holes[0].stamp)
