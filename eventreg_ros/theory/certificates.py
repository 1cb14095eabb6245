# SPDX-License-Identifier: Apache-2.0
"""What theory says of given parameters, in words: one certificate per claim of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..control.adaptive import fixed
from ..models.model import Model, Params
from ..models.neuron import NEURON, OSCILLATOR
from ..simulation.block import BlockSpec
from .internal_model import Copy, compare, embeds
from .lemmas import Contraction, Status, antiphase_oscillates, lemma_1, lemma_2, rests

Number = float | bool | str | list[float] | list[list[float]] | None


@dataclass(frozen=True, repr=False)
class Certificate:
    """One claim about one subject.

    ``claim`` is a fixed word for machines, ``value`` the number behind the status (None: there is
    none), ``meaning`` says what that number is, ``text`` gives the lemma and the reasons in words,
    ``numbers`` all further figures. ``status`` is explained at :data:`.theory.Status`.
    """

    subject: str
    claim: str
    status: Status
    value: float | None
    meaning: str
    text: str
    numbers: Mapping[str, Number] = field(default_factory=dict)

    def __repr__(self) -> str:
        value = '' if self.value is None else f' {self.value:.4g}'
        return f'<Certificate {self.claim} of {self.subject}: {self.status}{value}>'

    def __str__(self) -> str:
        """Return it as one line."""
        return f'{self.status}: {self.subject}, {self.claim}: {self.text}'


RATE = 'contraction rate per unit of model time, in the norm of P = diag(1, 1/tau)'
EDGE_NOTE = (
    'Solutions under the same input still approach each other '
    "(V' <= -dx_1^4/6 - 2 dx_2^2 for V = dx_1^2 + dx_2^2/tau), but no exponential rate follows."
)


def lemma(name: str, model: Model, p: Params, driven: bool) -> Certificate | None:
    """Return Lemma 1 for a neuron, Lemma 2 for an oscillator, None for a linear model.

    ``driven`` says that the block has inputs that somebody publishes.
    """
    if model is NEURON:
        return _lemma_1(name, p)
    return _lemma_2(name, p, driven) if model is OSCILLATOR else None


def _numbers(found: Contraction, p: Params) -> dict[str, Number]:
    return {'k': p[0], 'tau': p[1], 'largest_eigenvalue': found.largest_eigenvalue}


def _lemma_1(name: str, p: Params) -> Certificate:
    found, k = lemma_1(p), p[0]
    words = {
        'pass': f'k = {k:.6g} > 1: it contracts, whatever its input, at rate min(k - 1, tau).',
        'marginal': f'k = {k:.6g} only just misses Lemma 1, which needs k > 1. {EDGE_NOTE}',
        'none': f'k = {k:.6g} < 1: Lemma 1 says nothing. '
        + (
            'Without input every solution still goes to 0 (k >= 1 - tau).'
            if rests(p)
            else 'Without input it oscillates by itself (k < 1 - tau), so it is not convergent.'
        ),
    }[found.status]
    text = f'{words} {_eigenvalue(found)}'
    value = _zero(found.rate) if found.status != 'none' else None
    return Certificate(
        name, 'lemma_1', found.status, value, RATE, text, {**_numbers(found, p), 'rests': rests(p)}
    )


def _lemma_2(name: str, p: Params, driven: bool) -> Certificate:
    found, (k, tau) = lemma_2(p), p[:2]
    words = {
        'pass': f'k = {k:.6g} > 1/2: its neurons go into antiphase at rate min(2 k - 1, tau).',
        'marginal': f'k = {k:.6g} only just misses Lemma 2, which needs k > 1/2. {EDGE_NOTE}',
        'none': f'k = {k:.6g} < 1/2: Lemma 2 says nothing.',
    }[found.status]
    if driven:
        words += ' Holds while the input is 0, as it is at the steady state that is wanted.'
    words += (
        f' In antiphase it oscillates, since tau = {tau:.6g} < 1.'
        if antiphase_oscillates(p)
        else f' In antiphase it dies out, since tau = {tau:.6g} >= 1.'
    )
    words += f' {_eigenvalue(found)}'
    value = _zero(found.rate) if found.status != 'none' else None
    numbers = {**_numbers(found, p), 'oscillates': antiphase_oscillates(p)}
    return Certificate(name, 'lemma_2', found.status, value, RATE, words, numbers)


def _eigenvalue(found: Contraction) -> str:
    return (
        f'Largest eigenvalue of the symmetric part of P Df: {_zero(found.largest_eigenvalue):.4g}.'
    )


def _zero(rate: float) -> float:
    return 0.0 if abs(rate) < 1e-12 else rate


def error_system(plant: BlockSpec, reference: BlockSpec) -> Certificate:
    """Return Lemma 1 for a plant and a reference neuron in parallel: the weaker of the two."""
    both = [lemma_1(plant.params), lemma_1(reference.params)]
    weaker = min(both, key=lambda found: found.rate)
    value = _zero(weaker.rate) if weaker.status != 'none' else None
    text = (
        'The error y - y_r comes from plant and reference in parallel, which contract together if '
        'each does. The paper concludes it from Lemma 1 for the reference; with k_p = k_r that '
        f'covers the plant. Here k_p = {plant.params[0]:.6g} and k_r = {reference.params[0]:.6g}: '
        'the weaker decides.'
    )
    subject = f'{plant.name} and {reference.name}'
    return Certificate(subject, 'error_system', weaker.status, value, RATE, text)


DIFFERENCE = 'largest relative difference of k and tau'


def _differences(copy: Copy) -> tuple[float | None, str]:
    parts = {'k': copy.k, 'tau': copy.tau}
    known = {name: value for name, value in parts.items() if value is not None}
    if not known:
        return (0.0 if copy.exact else None), ''
    words = ', '.join(f'{name} by {100 * x:+.3g} %' for name, x in known.items() if x)
    return max(abs(value) for value in known.values()), words


def reference_copy(plant: BlockSpec, reference: BlockSpec) -> Certificate:
    """Say whether the reference is a copy of the plant, as (k_r, tau_r) = (k_p, tau_p) asks."""
    copy = compare(reference.model, reference.params, plant.model, plant.params)
    value, words = _differences(copy)
    text = (
        'The reference is a copy of the plant: y_r is what the undisturbed plant would do.'
        if copy.exact
        else f'The reference is not a copy of the plant ({words or "another model"}): '
        'y - y_r does not vanish while v is active.'
    )
    numbers: dict[str, Number] = {'k': copy.k, 'tau': copy.tau}
    status: Status = 'pass' if copy.exact else 'fail'
    return Certificate(reference.name, 'reference_copy', status, value, DIFFERENCE, text, numbers)


def internal_model(controller: BlockSpec, exosystem: BlockSpec) -> list[Certificate]:
    """Say whether the controller can produce w at y = 0, and how far it is from a copy.

    With one neuron as the controller the argument why that fails is a certificate of its own.
    """
    alone = fixed(controller)
    both = (alone.model, alone.params, exosystem.model, exosystem.params)
    copy, status = compare(*both), embeds(*both)
    value, words = _differences(copy)
    numbers: dict[str, Number] = {'exact_copy': copy.exact, 'k': copy.k, 'tau': copy.tau}
    text = _internal_model_words(copy, status, words)
    if controller.model.learned and alone.model is exosystem.model and status == 'fail':
        status = 'pass'
        text = (
            f'The controller is not a copy of the exosystem yet ({words}), but it learns '
            f'{controller.model.learned[0]}: once it has, y = 0 is a steady state.'
        )
    found = [
        Certificate(controller.name, 'internal_model', status, value, DIFFERENCE, text, numbers),
    ]
    if controller.model is NEURON and exosystem.model is OSCILLATOR:
        found.append(single_neuron(controller, status))
    return found


def _internal_model_words(copy: Copy, status: Status, differences: str) -> str:
    if copy.exact:
        return (
            'The controller contains a copy of the exosystem: y = 0 is a steady state.'
            if status == 'pass'
            else 'The controller contains a copy of the exosystem, but with gain 0 it is cut off.'
        )
    return (
        f'The controller is not a copy of the exosystem ({differences or "another model"}). '
        + {
            'pass': 'But tau agrees, and in antiphase k cancels: y = 0 is a steady state.',
            'marginal': '',
            'none': 'Whether it can produce w at y = 0 does not follow from the lemmas here.',
            'fail': 'At y = 0 it cannot produce w, so y does not vanish; its events still may.',
        }[status]
    )


def single_neuron(controller: BlockSpec, status: Status) -> Certificate:
    """Return the paper's argument why one neuron as the controller fails, and what it covers."""
    p = controller.params
    k, tau = p[:2]
    if k > 1.0:
        text = (
            f'k = {k:.6g} > 1: at y = 0 the neuron is contractive (Lemma 1) and 0 is a solution, '
            'so u goes to 0 and is not w: one neuron is too few (the argument of the paper).'
        )
    elif rests(p):
        text = (
            f'k = {k:.6g} is not above 1, so the argument by Lemma 1 does not apply, but with '
            f'k >= 1 - tau = {1 - tau:.6g} every solution at y = 0 still goes to 0: u is not w.'
        )
    elif k > 0.0:
        text = (
            f'k = {k:.6g} < 1 - tau: at y = 0 the neuron oscillates by itself, so the argument of '
            'the paper does not apply; but for k > 0 its orbit is never that of w.'
        )
    else:
        text = 'k = 0: the neuron oscillates by itself, but y does not reach it.'
    numbers: dict[str, Number] = {'k': k, 'tau': tau, 'rests': rests(p)}
    meaning = 'conductance k of the neuron'
    return Certificate(controller.name, 'single_neuron', status, k, meaning, text, numbers)
