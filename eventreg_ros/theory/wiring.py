# SPDX-License-Identifier: Apache-2.0
"""Who is wired to whom: the circuits that a loop consists of, if they are wired as in the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..simulation.block import BlockSpec
from ..simulation.loop import Loop

Wires = set[tuple[str, float]]


@dataclass(frozen=True)
class Circuit:
    """A plant with its reference, the generators that disturb it, and its controllers."""

    plant: BlockSpec | None
    reference: BlockSpec | None
    exosystems: Sequence[BlockSpec]
    controllers: Sequence[BlockSpec]


def circuits(loop: Loop) -> list[Circuit] | None:
    """Return the circuits of a loop, one per plant; None when it is not wired as in the paper.

    In the paper's wiring a generator hears nobody; a plant adds generators and open inputs and
    subtracts controls; a reference adds the plant's open inputs; and a controller hears its plant,
    less the plant's reference where there is one. Inputs that nobody publishes do not count.
    """
    plants = loop.of_role('plant')
    if not plants:
        alone = list(loop.blocks.values())
        ok = all(not _heard(loop, block) for block in alone if block.role == 'exosystem')
        return _without_plant(loop) if ok else None
    found = [_circuit(loop, plant) for plant in plants.values()]
    complete = [circuit for circuit in found if circuit is not None]
    placed = {block.name for each in complete for block in _blocks(each)}
    return complete if len(complete) == len(found) and placed == set(loop.blocks) else None


def _without_plant(loop: Loop) -> list[Circuit] | None:
    if any(_heard(loop, block) for block in loop.of_role('controller').values()):
        return None
    exosystems = list(loop.of_role('exosystem').values())
    return [Circuit(None, None, exosystems, list(loop.of_role('controller').values()))]


def _blocks(circuit: Circuit) -> list[BlockSpec]:
    several = [*circuit.exosystems, *circuit.controllers]
    return several + [block for block in (circuit.plant, circuit.reference) if block is not None]


def _heard(loop: Loop, block: BlockSpec) -> Wires:
    published = set(loop.signals)
    return {(signal, sign) for signal, sign in block.inputs if signal in published}


def _circuit(loop: Loop, plant: BlockSpec) -> Circuit | None:
    """Return the circuit of one plant, None where it is not the paper's."""
    reference = loop.reference_of(plant.name)
    heard, open_inputs = _heard(loop, plant), {(signal, 1.0) for signal in loop.stimuli}
    exosystems = [b for b in loop.of_role('exosystem').values() if (b.output, 1.0) in heard]
    controllers = [b for b in loop.of_role('controller').values() if (b.output, -1.0) in heard]
    wanted: Wires = {(b.output, 1.0) for b in exosystems} | {(b.output, -1.0) for b in controllers}
    if heard - open_inputs != wanted or any(_heard(loop, each) for each in exosystems):
        return None
    if reference is not None and _heard(loop, reference) != heard & open_inputs:
        return None
    error: Wires = {(plant.output, 1.0)}
    if reference is not None:
        error.add((reference.output, -1.0))
    if any(_heard(loop, controller) != error for controller in controllers):
        return None
    return Circuit(plant, reference, exosystems, controllers)
