# SPDX-License-Identifier: Apache-2.0
"""All certificates of a loop: what theory says of it, and what is measured beyond."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..control.adaptive import fixed
from ..models.linear import HARMONIC, INTERNAL_MODEL, LAG
from ..models.neuron import NEURON
from ..simulation.continuous import StiffError, simulate
from ..simulation.loop import Loop
from ..simulation.model_errors import in_words
from .adaptation import gain_and_delay, learning
from .bank import bank
from .certificates import (
    Certificate,
    Number,
    error_system,
    internal_model,
    lemma,
    reference_copy,
)
from .floquet import AperiodicError, floquet
from .lemmas import Status
from .linear_certificates import linear_loop
from .lyapunov import (
    PERTURBED,
    TIME,
    TRANSIENT,
    NoJacobianError,
    UnboundedError,
    conditional_exponent,
    need_time,
)
from .wiring import Circuit, circuits

MOVES = 1e-3
"""A signal that ranges further than this has not come to rest."""

EXPONENT = 'largest conditional Lyapunov exponent per unit of model time'


def certify(loop: Loop, time: float = TIME) -> list[Certificate]:
    """Return the certificates of a loop: theory first, then what was measured.

    ``time`` is the model time over which each Lyapunov exponent is averaged; at the default the
    shipped scenarios take two to five seconds. It is about the loop whose links are never late.
    """
    return list(one_by_one(loop, time))


def one_by_one(loop: Loop, time: float = TIME) -> Iterator[Certificate]:
    """Yield what :func:`certify` returns, each certificate as soon as it is known."""
    need_time(time)
    with in_words(loop.foreign_models):
        yield from _one_by_one(loop.without_delay(), time)


def _one_by_one(loop: Loop, time: float) -> Iterator[Certificate]:
    published = set(loop.signals)
    for name, block in loop.blocks.items():
        driven = any(signal in published for signal, _ in block.inputs)
        alone = fixed(block)
        found = lemma(name, alone.model, alone.params, driven)
        if found is not None:
            yield found
    wired = circuits(loop)
    if wired is None:
        yield _other_wiring()
    for circuit in wired or ():
        yield from _theory(circuit)
    yield from _measured(loop, time)


def _other_wiring() -> Certificate:
    text = (
        'The blocks are not wired as in the paper, so what it says of the loop does not apply; '
        'the lemmas of the single blocks and the exponents below do.'
    )
    return Certificate('loop', 'wiring', 'none', None, '', text)


def _theory(circuit: Circuit) -> list[Certificate]:
    """Return what theory says of a plant and the blocks around it, in the paper's wiring."""
    plant, reference = circuit.plant, circuit.reference
    exosystems, controllers = circuit.exosystems, circuit.controllers
    found: list[Certificate] = []
    if plant and reference:
        if plant.model is NEURON and reference.model is NEURON:
            found.append(error_system(plant, reference))
        found.append(reference_copy(plant, reference))
    if len(controllers) == 1 and len(exosystems) == 1:
        found += internal_model(controllers[0], exosystems[0])
    elif plant or controllers:
        found += bank(controllers, exosystems)
    if plant and plant.model is LAG and _is_linear_motif(circuit):
        disturbed = [exosystem.model is HARMONIC for exosystem in exosystems] == [True]
        found += linear_loop(controllers[0].params if controllers else None, disturbed)
    for controller in controllers:
        found += [learning(controller, exosystems)] if controller.model.learned else []
        rule = gain_and_delay(controller, plant, reference) if len(controllers) == 1 else None
        found += [rule] if rule is not None else []
    return found


def _is_linear_motif(circuit: Circuit) -> bool:
    one = len(circuit.controllers) <= 1 and len(circuit.exosystems) <= 1
    return one and all(block.model is INTERNAL_MODEL for block in circuit.controllers)


def _measured(loop: Loop, time: float) -> Iterator[Certificate]:
    """Yield the exponents with and without w, with and without v, and what they say together."""
    if not loop.of_role('plant', 'controller'):
        return
    quiet, v = loop.without('exosystem'), bool(loop.stimuli)
    cases: list[tuple[str, str, Loop]] = []
    if loop.of_role('exosystem'):
        cases.append(('driven', 'with w and v' if v else 'with w', loop))
    if v:
        cases.append(('driven_by_v', 'with v, w = 0', quiet))
    cases.append(('quiet', 'w = v = 0' if v else 'w = 0', quiet.at_rest()))
    found: list[Certificate] = []
    for claim, words, case in cases:
        found.append(_exponent(f'exponent_{claim}', words, case, time))
        yield found[-1]
    if len(found) > 1:
        yield _induced(found[0], found[-1])
    if len(loop.of_role('exosystem')) == 1:
        yield _multipliers('with w, v = 0' if v else 'with w', loop.at_rest())


def _multipliers(inputs: str, loop: Loop) -> Certificate:
    names = [name for role in PERTURBED for name in loop.of_role(role)]
    subject = f'{" and ".join(names)}, {inputs}'
    meaning = 'largest Floquet exponent along w per unit of model time'
    try:
        found = floquet(loop)
    except (AperiodicError, NoJacobianError, StiffError) as error:
        return Certificate(subject, 'floquet', 'none', None, meaning, f'Not measured: {error}.')
    sizes = [abs(each) for each in found.multipliers]
    status: Status = 'pass' if sizes[0] < 1.0 else 'fail'
    text = (
        f'{found.rate:.6f} along a period of w, {found.period:.5f}: the largest multipliers are '
        f'{", ".join(f"{size:.4g}" for size in sizes[:3])} in magnitude. {WORDS[status]}'
    )
    numbers: dict[str, Number] = {'period': found.period, 'multipliers': sizes}
    return Certificate(subject, 'floquet', status, found.rate, meaning, text, numbers)


def _exponent(claim: str, inputs: str, loop: Loop, time: float) -> Certificate:
    names = [name for role in PERTURBED for name in loop.of_role(role)]
    subject = f'{" and ".join(names)}, {inputs}'
    try:
        found = conditional_exponent(loop, time)
    except UnboundedError as error:
        return Certificate(subject, claim, 'fail', None, EXPONENT, f'Not measured: {error}.')
    except (NoJacobianError, StiffError) as error:
        return Certificate(subject, claim, 'none', None, EXPONENT, f'Not measured: {error}.')
    status: Status = {-1: 'pass', 0: 'none', 1: 'fail'}[found.sign]  # type: ignore[assignment]
    number = (
        f'{found.value:.4f} +/- {found.half_width:.4f}, measured over model time '
        f'{TRANSIENT:g} to {TRANSIENT + time:g}. '
    )
    numbers: dict[str, Number] = {'half_width': found.half_width, 'time': time}
    numbers['blocks'] = list(found.blocks)
    words = number + WORDS[status]
    if status == 'none' and claim == 'exponent_quiet':
        numbers['oscillates'] = _oscillates(loop)
        words += OSCILLATES if numbers['oscillates'] else RESTS
    return Certificate(subject, claim, status, found.value, EXPONENT, words, numbers)


WORDS = {
    'pass': 'Small differences fade: contracting along this solution.',
    'none': 'Indistinguishable from 0.',
    'fail': 'Small differences grow.',
}


OSCILLATES = (
    ' It oscillates by itself, and nothing corrects its phase: not contractive, a small difference '
    'along the orbit does not fade.'
)
RESTS = ' It goes to rest, so it may contract, too slowly to be seen over this time.'


def _oscillates(loop: Loop) -> bool:
    """Say whether the blocks, left to themselves, still move after the transient."""
    run = simulate(loop, 2.0 * TRANSIENT)
    late = run.t >= TRANSIENT
    return any(float(np.ptp(x[late])) > MOVES for x in run.signals.values())


def _induced(driven: Certificate, quiet: Certificate) -> Certificate:
    """Say whether the inputs make the loop contract that does not without them."""
    induced: Status = 'none'
    if driven.status != 'pass':
        text = 'It is not seen to contract with its inputs.'
    elif quiet.status == 'pass':
        text = 'It contracts with and without its inputs: nothing is induced.'
    elif quiet.status == 'fail' or quiet.numbers.get('oscillates'):
        induced, text = 'pass', 'It contracts with its inputs and not without: they induce it.'
    else:
        text = 'It contracts with its inputs; whether it does without them is not known.'
    return Certificate('loop', 'input_induced_contraction', induced, driven.value, EXPONENT, text)
