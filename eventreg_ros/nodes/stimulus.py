# SPDX-License-Identifier: Apache-2.0
"""The stimulus: publishes v, the measured open input of plant and reference."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from ..scenario.parameter import ACTIVE
from ..simulation.stimulus import Stimulus
from .pace import Lines
from .ros import run_node
from .signal import SignalNode


class StimulusNode(SignalNode):
    """Publishes the waveform at the model time of each sample."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('stimulus', **kwargs)

    def verify(self, values: Mapping[str, Any]) -> None:
        """Refuse a file that cannot be read."""
        Stimulus.from_parameters(values)

    def open(self) -> None:
        """Read the waveform, so that a bad file is refused before anything starts."""
        self.waveform = Stimulus.from_parameters(self.values)
        super().open()

    def begin(self) -> None:
        """Start at model time 0."""
        self.base = (self.n + 1, 0.0) if self.values['lockstep'] else (0, 0.0)
        self.rate: float = self.values['rate']
        self.time_scale: float = self.values['time_scale']
        self.waveform = Stimulus.from_parameters(self.values)
        super().begin()

    def changed(self) -> None:
        """Take over amplitude, offset and time_scale; model time goes on without a jump."""
        if self.stage != ACTIVE:
            return
        if self.values['time_scale'] != self.time_scale:
            self.base = (max(self.n, 0), self._model_time(max(self.n, 0)))
            self.time_scale = self.values['time_scale']
        self.waveform = Stimulus.from_parameters(self.values)

    def _model_time(self, n: int) -> float:
        since, t = self.base
        return t + (n - since) * self.time_scale / self.rate

    def initial(self) -> float:
        """Return v(0)."""
        return self.waveform(0.0)

    def step(self, n: int, lines: Lines) -> float:
        """Return v at sample ``n`` + 1."""
        return self.waveform(self._model_time(n + 1))


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(StimulusNode)


if __name__ == '__main__':
    sys.exit(main())
