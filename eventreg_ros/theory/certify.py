"""All certificates of a scenario: what theory says of it, and what is measured beyond."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..models.linear import HARMONIC, INTERNAL_MODEL, LAG
from ..models.neuron import NEURON
from ..models.roles import ROLES
from ..scenario import Scenario
from ..simulation.block import BlockSpec
from ..simulation.continuous import simulate
from ..simulation.stimulus import Stimulus
from .certificates import Certificate, Number, error_system, internal_model, lemma, reference_copy
from .lemmas import Status
from .linear_certificates import linear_loop
from .lyapunov import PERTURBED, TIME, TRANSIENT, UnboundedError, conditional_exponent

MOVES = 1e-3
"""A signal that ranges further than this has not come to rest."""

EXPONENT = 'largest conditional Lyapunov exponent per unit of model time'


def certify(scenario: Scenario, time: float = TIME) -> list[Certificate]:
    """Return the certificates of a scenario: theory first, then what was measured.

    ``time`` is the model time over which each Lyapunov exponent is averaged; at the default the
    shipped scenarios take one to four seconds. Raises EventregError for a scenario that cannot be
    read.
    """
    blocks = scenario.loop.blocks
    found = [lemma(b.name, b.model, b.params, _driven(b, scenario)) for b in blocks.values()]
    certificates = [certificate for certificate in found if certificate is not None]
    if _paper_wiring(scenario):
        certificates += _loop(blocks)
    else:
        certificates.append(_other_wiring())
    return certificates + _measured(scenario, time)


def _driven(block: BlockSpec, scenario: Scenario) -> bool:
    return any(signal in scenario.publishers for signal, _ in block.inputs)


def _paper_wiring(scenario: Scenario) -> bool:
    """Say whether the signals that are published go where the paper's figures have them go."""
    published = set(scenario.publishers)

    def wiring(inputs: set[tuple[str, float]], output: str) -> tuple[set[tuple[str, float]], str]:
        return {(signal, sign) for signal, sign in inputs if signal in published}, output

    return all(
        wiring(set(block.inputs), block.output) == wiring(_signs(role), ROLES[role].output)
        for role, block in scenario.blocks.items()
    )


def _signs(role: str) -> set[tuple[str, float]]:
    spec = ROLES[role]
    return {(s, 1.0) for s in spec.excitatory} | {(s, -1.0) for s in spec.inhibitory}


def _other_wiring() -> Certificate:
    text = (
        'The blocks are not wired as in the paper, so what it says of the loop does not apply; '
        'the lemmas of the single blocks and the exponents below do.'
    )
    return Certificate('loop', 'wiring', 'none', None, '', text)


def _loop(blocks: Mapping[str, BlockSpec]) -> list[Certificate]:
    """Return what theory says of blocks in the paper's wiring."""
    part = {role: (block.model, block.params) for role, block in blocks.items()}
    plant, reference = part.get('plant'), part.get('reference')
    controller, exosystem = part.get('controller'), part.get('exosystem')
    found: list[Certificate] = []
    if plant and reference:
        if plant[0] is NEURON and reference[0] is NEURON:
            found.append(error_system(plant[1], reference[1]))
        found.append(reference_copy(plant, reference))
    if controller and exosystem:
        found += internal_model(controller, exosystem)
    if plant and plant[0] is LAG and (controller is None or controller[0] is INTERNAL_MODEL):
        disturbed = exosystem is not None and exosystem[0] is HARMONIC
        found += linear_loop(controller[1] if controller else None, disturbed)
    return found


def _measured(scenario: Scenario, time: float) -> list[Certificate]:
    """Return the exponents with and without w, with and without v, and what they say together."""
    blocks, v, output = scenario.loop
    if not {'plant', 'controller'}.intersection(blocks):
        return []
    quiet = {name: block for name, block in blocks.items() if name != 'exosystem'}
    cases: list[tuple[str, str, Mapping[str, BlockSpec], Stimulus | None]] = []
    if 'exosystem' in blocks:
        cases.append(('driven', 'with w and v' if v else 'with w', blocks, v))
    if v:
        cases.append(('driven_by_v', 'with v, w = 0', quiet, v))
    cases.append(('quiet', 'w = v = 0' if v else 'w = 0', quiet, None))
    found = [
        _exponent(f'exponent_{claim}', words, case, stimulus, output, time)
        for claim, words, case, stimulus in cases
    ]
    return found + ([_induced(found[0], found[-1])] if len(found) > 1 else [])


def _exponent(
    claim: str,
    inputs: str,
    blocks: Mapping[str, BlockSpec],
    stimulus: Stimulus | None,
    output: str,
    time: float,
) -> Certificate:
    subject = f'{" and ".join(name for name in PERTURBED if name in blocks)}, {inputs}'
    try:
        found = conditional_exponent(blocks, stimulus, time, stimulus_output=output)
    except UnboundedError as error:
        return Certificate(subject, claim, 'fail', None, EXPONENT, f'Not measured: {error}.')
    status: Status = {-1: 'pass', 0: 'none', 1: 'fail'}[found.sign]  # type: ignore[assignment]
    number = (
        f'{found.value:.4f} +/- {found.half_width:.4f}, measured over model time '
        f'{TRANSIENT:g} to {TRANSIENT + time:g}. '
    )
    numbers: dict[str, Number] = {'half_width': found.half_width, 'time': time}
    numbers['blocks'] = list(found.blocks)
    words = number + WORDS[status]
    if status == 'none' and claim == 'exponent_quiet':
        numbers['oscillates'] = _oscillates(blocks)
        words += OSCILLATES if numbers['oscillates'] else RESTS
    return Certificate(subject, claim, status, found.value, EXPONENT, words, numbers)


WORDS = {
    'pass': 'Small differences fade: contracting along this solution.',
    'none': 'Not told from 0.',
    'fail': 'Small differences grow.',
}


OSCILLATES = (
    ' It oscillates by itself, and nothing corrects its phase: not contractive, a small difference '
    'along the orbit does not fade.'
)
RESTS = ' It goes to rest, so it may contract, too slowly to be told over this time.'


def _oscillates(blocks: Mapping[str, BlockSpec]) -> bool:
    """Say whether the blocks, left to themselves, still move after the transient."""
    run = simulate(blocks, None, 2.0 * TRANSIENT)
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
        text = 'It contracts with its inputs; whether it does without them is not told.'
    return Certificate('loop', 'input_induced_contraction', induced, driven.value, EXPONENT, text)
