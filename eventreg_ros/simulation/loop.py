# SPDX-License-Identifier: Apache-2.0
"""The closed loop: blocks by name, the open inputs by signal, and who publishes what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..errors import EventregError
from ..models import Model
from .block import BlockSpec
from .numbered import ordinary
from .stimulus import Stimulus


@dataclass(frozen=True)
class Loop:
    """What is simulated: any number of blocks, and a stimulus for each open input.

    ``blocks`` are keyed by the name of their node, ``stimuli`` by the signal that they publish.
    Raises EventregError when two publish the same signal.
    """

    blocks: Mapping[str, BlockSpec]
    stimuli: Mapping[str, Stimulus] = field(default_factory=dict)

    def __post_init__(self) -> None:
        owner = dict.fromkeys(self.stimuli, 'the stimulus')
        for name, spec in self.blocks.items():
            for signal in spec.signals:
                if signal in owner:
                    raise EventregError(
                        f'{owner[signal]} and {name} both publish {signal!r}; '
                        f'set {name}.output to another signal'
                    )
                owner[signal] = name

    @property
    def signals(self) -> list[str]:
        """All signals: the stimuli's, each block's output, and last what blocks publish beside."""
        blocks = self.blocks.values()
        outputs = [spec.output for spec in blocks]
        return [*self.stimuli, *outputs, *(name for spec in blocks for name in spec.observed)]

    @property
    def models(self) -> list[Model]:
        """The models of all blocks."""
        return [spec.model for spec in self.blocks.values()]

    @property
    def foreign_models(self) -> list[Model]:
        """Those whose code belongs to other packages."""
        return [model for model in self.models if not model.is_ours]

    @property
    def links(self) -> list[tuple[str, str]]:
        """All links, (receiving block, signal); an input that nobody publishes is none."""
        published = set(self.signals)
        return [
            (name, signal)
            for name, spec in self.blocks.items()
            for signal, _ in spec.inputs
            if signal in published
        ]

    @property
    def grid(self) -> tuple[float, float]:
        """The (time_scale, rate) of all blocks; a step is time_scale / rate of model time.

        Raises EventregError when there is no block or the blocks disagree.
        """
        if not self.blocks:
            raise EventregError('nothing to simulate: name at least one block, the plant say')
        found = {name: (spec.time_scale, spec.rate) for name, spec in self.blocks.items()}
        if len(set(found.values())) > 1:
            raise EventregError(
                'all blocks must have the same time_scale and rate, got '
                + ', '.join(f'{n} {scale:g} and {rate:g}' for n, (scale, rate) in found.items())
                + '; set them once with -p /**.time_scale:=VALUE -p /**.rate:=VALUE'
            )
        return next(iter(found.values()))

    def reference_of(self, plant: str) -> BlockSpec | None:
        """Return the reference that ``plant`` is judged against: plant_left has reference_left."""
        namespace, slash, name = plant.rpartition('/')
        suffix = name.removeprefix('plant')
        return self.blocks.get(f'{namespace}{slash}reference{suffix}')

    def of_role(self, *roles: str) -> dict[str, BlockSpec]:
        """Return the blocks that play one of ``roles``, in order."""
        return {name: spec for name, spec in self.blocks.items() if spec.role in roles}

    def without(self, *roles: str) -> Loop:
        """Return the loop without the blocks that play one of ``roles``."""
        blocks = {name: spec for name, spec in self.blocks.items() if spec.role not in roles}
        return Loop(blocks, self.stimuli)

    def without_delay(self) -> Loop:
        """Return the loop in the limit of links that are never late: every block an ordinary one.

        What such a block is made of besides comes last, as blocks of their own.
        """
        published, blocks, others = set(self.signals), dict(self.blocks), []
        for name, spec in self.blocks.items():
            blocks[name], *more = ordinary(spec, published)
            others += more
        return Loop({**blocks, **{spec.name: spec for spec in others}}, self.stimuli)

    def at_rest(self) -> Loop:
        """Return the loop without its stimuli: every open input is 0."""
        return Loop(self.blocks)

    @property
    def predicts(self) -> bool:
        """Whether a block predicts, so that what it sends is played after a lead."""
        return any(spec.numbered is not None for spec in self.blocks.values())

    def led_by(self, lead: float) -> Loop:
        """Return the loop with a lead of at least so much model time."""
        blocks = {n: replace(b, lead=max(b.lead, lead)) for n, b in self.blocks.items()}
        return Loop(blocks, self.stimuli)

    def sampled_at(self, rate: float, hold: str | None = None) -> Loop:
        """Return the loop with another ``rate`` (steps per second), and another hold if given."""
        blocks = {
            name: replace(spec, rate=rate, hold=hold or spec.hold)
            for name, spec in self.blocks.items()
        }
        return Loop(blocks, self.stimuli)
