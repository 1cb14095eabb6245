"""The one node that runs a block; exosystem, plant, controller and reference are its four names."""

from __future__ import annotations

import math

from ..scenario import block_spec
from ..simulation.block import Block
from .pace import Lines
from .signal import SignalNode


class BlockNode(SignalNode):
    """Steps its block on the grid, with the samples of its inputs."""

    block: Block | None = None

    def begin(self) -> None:
        """Start from x0."""
        self.block = Block(block_spec(self.label, self.values))
        super().begin()

    def changed(self) -> None:
        """Take over what may be set while running, from the next step on."""
        super().changed()
        if self.block is not None and self.stage == 'active':
            self.block.retune(block_spec(self.label, self.values))

    def initial(self) -> float:
        """Return the output of the initial state."""
        assert self.block is not None
        return self.block.y

    def step(self, n: int, lines: Lines) -> float:
        """Take one step of the block."""
        assert self.block is not None
        y = self.block.advance(lines.base, lines.slope)
        return y if math.isfinite(sum(self.block.x)) else math.nan
