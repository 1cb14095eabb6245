# SPDX-License-Identifier: Apache-2.0
"""What the linear motif's theory says of given gains, in words."""

from __future__ import annotations

import numpy as np

from ..models.linear import HARMONIC, LAG
from ..models.model import Params
from . import linear as theory
from .certificates import Certificate, Number
from .lemmas import EDGE, Status

LOOP = 'linear loop'


def linear_loop(controller: Params | None, disturbed: bool) -> list[Certificate]:
    """Return Hurwitz and, when the harmonic exosystem is there (``disturbed``), the steady state.

    ``controller`` is None for the plant alone.
    """
    if controller is None:
        a, b, _, _ = theory.state_space(LAG, ())
        entry = np.outer(b, theory.state_space(HARMONIC, ())[2])
    else:
        a, entry = theory.closed_loop(controller), theory.disturbance()
    found = [hurwitz(a, controller)]
    if disturbed:
        found.append(francis(a, entry, found[0].status == 'pass'))
    return found


def hurwitz(a: theory.Matrix, controller: Params | None) -> Certificate:
    """Say whether the closed-loop matrix (d.linear.cl_matrix) is Hurwitz, in three ways."""
    abscissa = theory.spectral_abscissa(a)
    status: Status = 'pass' if abscissa < -EDGE else 'marginal' if abscissa <= EDGE else 'fail'
    numbers: dict[str, Number] = {'matrix': a.tolist()}
    text = 'The plant alone is stable.'
    if controller is not None:
        k_y, k_1, k_2 = controller
        paper, routh = theory.paper_condition(controller), theory.routh_hurwitz(controller)
        numbers |= {'paper_condition': paper, 'routh_hurwitz': routh}
        text = (
            f'K_eta = ({k_1:.6g}, {k_2:.6g}), k_y = {k_y:.6g}. '
            f'Paper (K_1 > -K_2, K_2 < 1): {_words(paper)}. '
            f'Routh-Hurwitz (1 + k_y > 0, K_2 < 1 + k_y, (1 + k_y) K_1 > -K_2): {_words(routh)}.'
        )
    if status == 'pass':
        text += ' All solutions approach one another, with or without w.'
    return Certificate(
        LOOP, 'hurwitz', status, abscissa, 'largest real part of the eigenvalues', text, numbers
    )


def _words(condition: bool | None) -> str:
    return {True: 'met', False: 'not met', None: 'covers k_y = 0 only'}[condition]


def francis(a: theory.Matrix, entry: theory.Matrix, stable: bool) -> Certificate:
    """Solve Francis' equation and say what is left of y at steady state."""
    meaning = 'amplitude of y at steady state per unit amplitude of w'
    pi = theory.francis(a, entry, theory.exosystem())
    if pi is None:
        text = "Francis' equation has no unique solution: the loop has the eigenvalues of w itself."
        return Certificate(LOOP, 'francis', 'fail', None, meaning, text)
    left = theory.residual(pi)
    zero = left <= 1e-9
    text = (
        f'x_cl = Pi x_W with Pi of shape {pi.shape}; its first row, which gives y, is '
        + ('0. ' if zero else 'not 0. ')
        + ('Every solution goes there.' if stable else 'The loop does not go there.')
    )
    status: Status = 'pass' if zero and stable else 'fail'
    return Certificate(LOOP, 'francis', status, left, meaning, text, {'Pi': pi.tolist()})
