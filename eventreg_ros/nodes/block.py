# SPDX-License-Identifier: Apache-2.0
"""The one node that runs a block; exosystem, plant, controller and reference are its four names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rclpy.parameter import Parameter

from ..control.adaptive import GAIN, LARGEST, paused
from ..control.predicting_block import PredictingBlock
from ..runtime.cdr import packed
from ..runtime.figures import LEARNING
from ..scenario import block_spec
from ..scenario.parameter import ACTIVE, UNCONFIGURED
from ..simulation.block import Block, BlockSpec
from ..simulation.model_errors import ANYTHING, failed
from .arrivals import SequencedArrivals, StampedArrivals
from .managed import OK, WARN, FaultError, Status
from .pace import Inputs, Lines, Tick
from .signal import SignalNode
from .topics import signal_topic

RESTARTED = 'a pause, or a clock set anew: observer and prediction begin anew'


class BlockNode(SignalNode):
    """Steps its block on the grid, with the samples of its inputs.

    What the block has learned is written back to its ROS parameter whenever a parameter is set, and
    when the node stops: so it goes on from there, and starts from there when it is activated again.
    """

    block: Block | PredictingBlock | None = None
    _origin = 0
    """The instant of the grid at which the block's step 0 was."""

    def __init__(self, kind: str, **kwargs: Any) -> None:
        super().__init__(kind, **kwargs)
        self.observed: dict[str, Any] = {}
        """The publishers of what goes out beside the output, by name: tau on <output>/tau."""
        self.add_pre_set_parameters_callback(self._learned_beside)

    @property
    def spec(self) -> BlockSpec:
        """The block that the parameters describe."""
        return block_spec(self.label, self.values)

    def open(self) -> None:
        """Create publishers and subscriptions."""
        super().open()
        self.stack.callback(self.observed.clear)
        self._open_observed()

    def _open_observed(self) -> None:
        topic = signal_topic(self.values['lockstep'])
        for name, _ in self.spec.model.observed:
            if name not in self.observed:
                signal = f'{self.values["output"]}/{name}'
                lockstep = self.values['lockstep']
                self.observed[name] = self.advertise(topic, signal, always=lockstep)
                if self.stage == ACTIVE and not lockstep:
                    self.observed[name].on_activate(None)

    def _make_inputs(self) -> Inputs:
        if self.spec.numbered is None:
            return super()._make_inputs()
        schedules = self._schedules()
        if self.values['lockstep']:
            return SequencedArrivals(schedules)
        return StampedArrivals(schedules, self)

    def begin(self) -> None:
        """Start from x0."""
        spec = self.spec
        self._tune(Block(spec) if spec.numbered is None else PredictingBlock(spec))
        self.stack.callback(self._keep_learned)
        super().begin()

    def changed(self) -> None:
        """Take over what may be set while running, from the next step on."""
        super().changed()
        if self.stage != UNCONFIGURED:
            with self.until_cleanup():
                self._open_observed()
        if self.block is not None and self.stage == ACTIVE:
            self.block.retune(self.spec)
            self._tune(self.block)

    def _tune(self, block: Block | PredictingBlock) -> None:
        self.block, spec = block, block.spec
        self._moving, self._paused = spec.params, paused(spec.model, spec.params)

    def initial(self) -> float:
        """Return the output of the initial state."""
        assert self.block is not None
        if isinstance(self.block, PredictingBlock) and self.n >= 0:
            self.block.start(self.n + 1)  # switched on again in lockstep: numbers go on
        return self.block.y

    def step(self, n: int, lines: Lines) -> float:
        """Take one step of the block; while an input is silent it learns nothing."""
        assert isinstance(self.block, Block)
        self.block.params = self._paused if self.inputs.quiet else self._moving
        y = self.block.advance(lines.base, lines.slope)
        return y if math.isfinite(sum(self.block.x)) else math.nan

    def _next(self, tick: Tick) -> float:
        try:
            return self._stepped(tick)
        except ANYTHING as error:
            words = failed(error, [self.spec.model])
            if words is None:
                raise
            raise FaultError(f'{self.label} failed at step {tick.n}: {words}') from error

    def _stepped(self, tick: Tick) -> float:
        block = self.block
        if not isinstance(block, PredictingBlock):
            return super()._next(tick)
        assert isinstance(self.inputs, StampedArrivals | SequencedArrivals)
        origin = round(tick.start / tick.period) - tick.n
        if origin != self._origin and tick.n > 0:
            block.restart(tick.n)
            self.get_logger().warning(RESTARTED)
        self._origin = origin
        heard = self.inputs.heard(tick)
        block.params = self._paused if self.inputs.quiet else self._moving
        y = block.advance(tick.n, heard)
        return y if math.isfinite(sum(block.x)) else math.nan

    def _published(self, n: int, value: float) -> None:
        if isinstance(self.block, PredictingBlock):
            self.block.keep(n, value)

    def put(self, value: float) -> bool:
        """Publish the output, and then what goes with it, numbered alike."""
        if not super().put(value):
            return False
        for name, publisher in self.observed.items():
            self.send(publisher, packed(self._observed(name)))
        return True

    def _observed(self, name: str) -> float:
        """Return the present value; where adapt has been set to 0, that of the parameter."""
        assert self.block is not None
        states = dict(self.block.spec.model.observed)
        return self.block.x[states[name]] if name in states else float(self.values[name])

    # What it learns

    @property
    def learned(self) -> dict[str, float]:
        """What the running block has learned so far, by parameter."""
        return self.block.learned if self.block is not None and self.stage == ACTIVE else {}

    def _learned_beside(self, changes: Sequence[Parameter]) -> list[Parameter]:
        """Return what is to be set beside ``changes``: what was learned and they do not set."""
        names = {change.name for change in changes}
        if not names & self.table.keys():
            return []
        return [Parameter(n, value=v) for n, v in self.learned.items() if n not in names]

    def _keep_learned(self) -> None:
        learned = [Parameter(n, value=v) for n, v in self.learned.items() if math.isfinite(v)]
        with self.until_the_end():
            if learned:
                self.set_parameters(learned)

    def report(self) -> Status:
        """Return the figures of pace and inputs, and what was learned."""
        level, message, values = super().report()
        if not self.learned:
            return Status(level, message, values)
        learning = 'paused' if self.inputs.quiet else 'on'
        values = {**values, LEARNING: learning, **self.learned}
        if level == OK and self.values[GAIN] > LARGEST:
            words = f'{GAIN} {self.values[GAIN]:g} is above {LARGEST:g}: it need not converge'
            return Status(WARN, words, values)
        return Status(level, message, values)
