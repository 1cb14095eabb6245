# SPDX-License-Identifier: Apache-2.0
"""The internal model principle for oscillators: whether the controller at y = 0 can produce w.

The paper asks for a copy, (k_eta, tau_eta) = (k_w, tau_w), and shows that one neuron is too few.
Both can be sharpened, since the exosystem in antiphase moves as an uncoupled neuron (k = 0):

- Of two oscillators only tau must agree. In antiphase the coupling cancels, so w does not depend
  on k_w, nor u (at y = 0) on k_eta. If tau differs it is impossible: u = w fixes the recovery x_2,
  and x_2' = tau (x_1 - x_2) then fixes tau.
- One neuron cannot do it for any k > 0. Where it rests (:func:`.theory.rests`, which includes the
  paper's k > 1) its output is 0. Elsewhere let (x_1, x_2) be its orbit at y = 0 and x_1 = w. Then
  the exosystem's recovery is x_2 + k x_1, and the derivative of that equation reads

      k x_1^3 / 3 + c x_1 = (tau_w - tau - k) x_2    with a constant c,

  which puts the orbit on the graph of a function of x_1 or on lines of constant x_1; no closed
  orbit lies there. With k = 0 no input reaches the neuron, and y cannot correct its phase.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..models.linear import HARMONIC, INTERNAL_MODEL, LAG
from ..models.model import Model, Params
from ..models.neuron import NEURON, OSCILLATOR
from .lemmas import Status, antiphase_oscillates, lemma_2


@dataclass(frozen=True)
class Copy:
    """How a block differs from the one that it should copy.

    ``k`` and ``tau`` are the differences relative to the original, (copy - original) / original;
    None where the models have no such parameter, differ, or the original's is 0.
    """

    exact: bool
    k: float | None = None
    tau: float | None = None


def compare(model: Model, p: Params, original: Model, q: Params) -> Copy:
    """Compare a block (``model``, ``p``) with the one that it should copy (``original``, ``q``).

    The linear models have no k and no tau; the linear controller contains the harmonic oscillator
    (Phi = S), so it counts as its copy.
    """
    if original in (HARMONIC, LAG):
        return Copy(model in ((HARMONIC, INTERNAL_MODEL) if original is HARMONIC else (LAG,)))
    if model != original:
        return Copy(False)
    if model not in (NEURON, OSCILLATOR):
        return Copy(all(math.isclose(a, b, rel_tol=1e-9) for a, b in zip(p, q, strict=True)))
    same = math.isclose(p[0], q[0], rel_tol=1e-9) and same_tau(p, q)
    return Copy(same, _relative(p[0], q[0]), _relative(p[1], q[1]))


def same_tau(p: Params, q: Params) -> bool:
    """Say whether two time constants are the same up to the rounding of 1/12 in a file."""
    return math.isclose(p[1], q[1], rel_tol=1e-9)


def _relative(value: float, original: float) -> float | None:
    return (value - original) / original if original else None


def embeds(model: Model, p: Params, exosystem: Model, q: Params) -> Status:
    """Say whether the controller (``model``, ``p``) at y = 0 has the steady w as its output.

    pass: it has, so that y = 0 is possible (whether it is reached is a matter of contraction);
    fail: it has not, or is cut off from the loop, so that y cannot vanish; none: the arguments of
    this module do not apply. They need an exosystem that ends in antiphase (Lemma 2) and oscillates
    there, which from almost every initial state it does.
    """
    if exosystem is HARMONIC and model is INTERNAL_MODEL:
        return 'pass' if any(p[1:]) else 'fail'
    if model not in (OSCILLATOR, NEURON):
        return 'pass' if compare(model, p, exosystem, q).exact else 'none'
    if p[0] > 0.0 and compare(model, p, exosystem, q).exact:
        return 'pass'
    sure = exosystem is OSCILLATOR and lemma_2(q).status != 'none' and antiphase_oscillates(q)
    if not sure:
        return 'none'
    if model is NEURON or p[0] == 0.0:
        return 'fail'
    if same_tau(p, q):
        return 'pass'
    return 'none' if lemma_2(p).status == 'none' else 'fail'
