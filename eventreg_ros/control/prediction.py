# SPDX-License-Identifier: Apache-2.0
"""What turns a controller into a predicting one: its settings, at any rate."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from ..models import NEURON, Params, State
from ..simulation.block import BlockSpec
from ..simulation.model_time import steps_of
from ..simulation.numbered import Make
from .predictor import Foresight, at_start, make_foresee, make_predictor

COARSE = 0.2
"""Length of a step of the prediction in model time, unless the loop's is longer."""

PATIENCE = 20.0
"""Model time beyond the lead after which y is skipped at the latest."""


@dataclass(frozen=True)
class Prediction:
    """What makes a controller a predicting one; see :class:`..simulation.numbered.Numbered`.

    Its first input is the plant's output, the others the measured inputs that excite the plant.
    ``plant`` are the parameters of the plant as it takes it to be. What of y is older than the lead
    and ``patience`` (model time, :data:`PATIENCE` at most) and has not come is skipped.
    """

    plant: Params
    patience: float

    @property
    def make(self) -> Make:
        """What makes the step."""
        return make_predictor

    def begin(self, spec: BlockSpec, n: int = 0) -> tuple[State, float]:
        """Return the state of a block that begins at step ``n``, and sample n of u."""
        x, foresight = at_start(spec.x0, n), self.tuning(spec)
        return x, make_foresee(spec.model)(x, foresight.lead, foresight, spec.h)

    def tuning(self, spec: BlockSpec) -> Foresight:
        """Return the numbers of the predictor at the spec's rate."""
        return Foresight(
            spec.params,
            self.plant,
            spec.lead_steps,
            steps_of(min(self.patience, PATIENCE), spec.h),
            max(int(COARSE / spec.h + 1e-9), 1),
            0.0 if spec.coding is not None and spec.coding.held else spec.horizon,
            tuple(spec.horizon * drawn for drawn in spec.drawn[1:]),
            1.0 - spec.drawn[0],
        )

    def effort(self, spec: BlockSpec) -> float:
        """Return about how many steps of an ordinary block one of its steps is worth."""
        foresight = self.tuning(spec)
        return 5.0 + foresight.lead / foresight.coarse

    def without_delay(self, spec: BlockSpec, published: Collection[str]) -> list[BlockSpec]:
        """Return the controller of the paper, and the replica as its reference if v moves it.

        With u played as it is made the copy's output and u are the same, so that v alone drives the
        replica.
        """
        (y, sign), *opens = spec.inputs
        heard = tuple(each for each in opens if each[0] in published)
        if not heard:
            return [replace(spec, inputs=((y, sign),), numbered=None)]
        replica = replace(
            spec, name=f'{spec.name}/replica', role='reference', model=NEURON, params=self.plant,
            x0=(0.0,) * NEURON.dimension, inputs=heard, output=f'{spec.output}/replica',
            numbered=None,
        )  # fmt: skip
        inputs = ((y, sign), (replica.output, -1.0))
        return [replace(spec, inputs=inputs, numbered=None), replica]
