# SPDX-License-Identifier: Apache-2.0
"""What has arrived of one input that comes as spikes, and the signal that is made of them."""

from __future__ import annotations

import math

from ..control.spikes import Receiver
from ..runtime.stamped_input import GUARD
from ..runtime.waiting_input import WaitingInput
from ..simulation.hold import line


class SpikeInput(WaitingInput):
    """The spikes of one input, see :mod:`..control.spikes`; ``h`` is a step in model time."""

    def __init__(self, tau: float) -> None:
        super().__init__()
        self.sparse = True
        self.h = 0.0
        self._receiver = Receiver(tau)
        self._value = 0.0

    def over(
        self, start: int, period: float, timeout: float, horizon: float
    ) -> tuple[float, float] | None:
        """Return the line over a step of what is made of the spikes.

        None before the first, and when there was none for three periods.
        """
        played = start - self.lead
        events = []
        for stamp, message in self.take(played + (1.0 - GUARD) * period):
            if message == 0.0:  # the sender was switched off
                self._receiver.stop()
                continue
            before = -math.floor((stamp - played) / period + GUARD)
            ago = abs(message) - 1.0 + before * self.h
            events.append((math.copysign(1.0, message), max(ago, 0.0)))
            self.used = stamp
        previous, self._value = self._value, self._receiver(events, self.h)
        if self._receiver.silent:
            self.used = None
            return None
        return line(self._value, previous, 0.0, 1.0, horizon)
