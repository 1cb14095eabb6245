# SPDX-License-Identifier: Apache-2.0
"""Certificates of a controller's gains: how fast it learns tau, and what its k costs and buys."""

from __future__ import annotations

from collections.abc import Sequence

from ..control.adaptive import GAIN, LARGEST, fixed
from ..models.neuron import NEURON, OSCILLATOR
from ..simulation.block import BlockSpec
from .averaging import delay_margin, learning_rate
from .certificates import Certificate, Number
from .lemmas import Status

PREDICTED = 'rate at which a small ln(tau / tau_w) is predicted to fade, per unit of model time'
DELAY = 'delay per link that averaging predicts for the exact tau and the zero hold, model time'

HIGH = 1.5
"""The k from which on a wrong tau has cost no event, for 1/tau_w from 1.2 to 200."""


def learning(controller: BlockSpec, exosystems: Sequence[BlockSpec]) -> Certificate:
    """Say whether an adaptive controller is able to learn its generator, and how fast."""
    names = [parameter.name for parameter in controller.model.parameters]
    p = dict(zip(names, controller.params, strict=True))
    parameter, gain = controller.model.learned[0], p[GAIN]
    low, high = p[f'{parameter}_min'], p[f'{parameter}_max']
    numbers: dict[str, Number] = {GAIN: gain, 'largest': LARGEST, 'low': low, 'high': high}
    head = f'{GAIN} = {gain:.6g}: it learns {parameter}, from {controller.x0[-1]:.6g}.'
    tail = f' {_without_w(parameter, high)}'
    alike = [e for e in exosystems if e.model is controller.model.base]
    if not alike:
        text = f'{head} No generator of its kind is there to learn from.{tail}'
        return Certificate(controller.name, 'learning', 'none', None, PREDICTED, text, numbers)
    at = [each.name for each in alike[0].model.parameters].index(parameter)
    out = [e for e in alike if not low <= e.params[at] <= high]
    rates = [learning_rate(e.params[at], gain) for e in alike if e.model is OSCILLATOR]
    slowest = min(rates, default=None)
    status: Status = 'fail' if out else 'none' if gain > LARGEST else 'pass'
    text = head + _rate_words(slowest) + _limit_words(gain, out, parameter, low, high)
    return Certificate(
        controller.name, 'learning', status, slowest, PREDICTED, text + tail, numbers
    )


def _rate_words(rate: float | None) -> str:
    if rate is None:
        return ''
    return (
        f' Averaging predicts that a small error fades at rate {rate:.4f} (for large k; the '
        'multipliers are exact).'
    )


def _limit_words(
    gain: float, out: Sequence[BlockSpec], parameter: str, low: float, high: float
) -> str:
    words = ''
    if out:
        names = ', '.join(each.name for each in out)
        words += f' That of {names} is outside of {low:g}..{high:g}: widen the bounds.'
    if gain > LARGEST:
        words += f' Above {LARGEST:g} it need not converge; 0.16 fails for slow generators.'
    return words


def _without_w(parameter: str, high: float) -> str:
    end = 'where the oscillator dies out and u with it' if high >= 1.0 else 'and stays there'
    return (
        f'Without w nothing teaches it: {parameter} goes to its upper bound {high:g}, {end}; it '
        'learns again when w comes back.'
    )


def gain_and_delay(
    controller: BlockSpec, plant: BlockSpec | None, reference: BlockSpec | None
) -> Certificate | None:
    """Say what the gain k of a controller buys and costs; None for models it is not known of."""
    alone = fixed(controller)
    if alone.model is not OSCILLATOR or plant is None or plant.model is not NEURON:
        return None
    (k, tau), (k_p, tau_p) = alone.params[:2], plant.params[:2]
    if not (k > 0.0 and tau < 1.0):
        return None
    value = delay_margin(k, tau, k_p, tau_p)
    text = (
        f'k = {k:.6g}: averaging predicts that a delay of {value:.2g} per link is tolerated; the '
        'loop does 0.8 to 1 times that, about 0.8/k (eventreg margin measures it).'
    )
    if controller.model.learned:
        text += ' It learns tau, so that a small k is enough: half the k, twice the delay.'
    elif k >= HIGH:
        text += (
            ' With a wrong tau y does not vanish, but without v no event passes: y is '
            '2 (x_2 - r_w)/k, with r_w the recovery of the generator.'
        )
        text += ' With v a few may.' if reference else ''
    else:
        text += (
            f' Below k = {HIGH:g} a wrong tau lets events pass: at k = 1 where tau_w/tau is not in '
            f'0.8..1.8, at k = 0.7 not in 0.9..1.3. Raise k, or let it learn: {GAIN} 0.04.'
        )
    return Certificate(controller.name, 'gain_and_delay', 'none', value, DELAY, text, {'k': k})
