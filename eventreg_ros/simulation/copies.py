# SPDX-License-Identifier: Apache-2.0
"""What a receiver makes of a coded signal when messages are lost on the way to it.

The table of samples holds a coded signal as it is known without loss, which is what the sender
believes. A link that loses messages has rows of its own behind the signals: the first is the
signal as its receiver knows it, the others are what the receiver remembers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .block import BlockSpec
from .coding import Copy
from .impairment import Impairment, Received, received


class Copies(NamedTuple):
    """The copies of a run: ``of`` by link, each with the signal that it is of.

    They take so many ``rows`` behind the signals. ``lost``, shape (copies, samples), is 1 where a
    message is lost.
    """

    rows: int
    of: Mapping[int, tuple[str, Copy]]
    lost: npt.NDArray[np.int64]

    def row_of(self, link: int, row: int) -> int:
        """Return the row that a link reads, ``row`` where it has no copy."""
        return self.of[link][1].row if link in self.of else row

    def to(self, signal: str) -> tuple[Copy, ...]:
        """Return the copies of a signal."""
        return tuple(copy for name, copy in self.of.values() if name == signal)

    def received(
        self, have: Received, signals: Sequence[str], steps: int, h: float, impairment: Impairment,
        leads: Sequence[int],
    ) -> Received:  # fmt: skip
        """Return ``have`` such that links with copies lose no sample: what is lost are messages."""
        if self.of:
            whole = received(signals, steps, h, replace(impairment, loss=0.0), leads)
            for link in self.of:
                for table, found in zip(have, whole, strict=True):
                    table[link] = found[link]
        return have


NO_COPIES = Copies(0, {}, np.zeros((1, 1), np.int64))


def copies_of(
    blocks: Sequence[BlockSpec], signals: Sequence[str], impairment: Impairment, first: int,
    steps: int,
) -> Copies:  # fmt: skip
    """Return the copies for links of ``signals``, whose rows begin at ``first``."""
    coded = {spec.output: spec.coding for spec in blocks if spec.coding is not None}
    on = impairment.on
    links = [
        link
        for link, signal in enumerate(signals)
        if impairment.loss > 0.0 and signal in coded and (on is None or signal in on)
    ]
    if not links:
        return NO_COPIES
    of, row, lost = {}, first, np.zeros((len(links), steps + 1), np.int64)
    for i, link in enumerate(links):
        coding = coded[signals[link]]
        assert coding is not None
        draws = np.random.default_rng((impairment.seed, link, 0)).random(steps + 1)
        of[link], lost[i] = (signals[link], Copy(row, i)), draws < impairment.loss
        row += len(coding.unheard)
    return Copies(row - first, of, lost)
