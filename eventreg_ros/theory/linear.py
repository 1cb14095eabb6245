# SPDX-License-Identifier: Apache-2.0
"""The linear motif's theory (the paper's section 2): closed loop, Hurwitz, Francis, steady state.

The closed loop's state is (x, x_eta1, x_eta2). With a = 1 + k_y the characteristic polynomial of
the matrix (d.linear.cl_matrix) is

    s^3 + a s^2 + (1 + K_1) s + (a - K_2),

and by Routh and Hurwitz it is stable if and only if

    a > 0,   K_2 < a,   a K_1 > -K_2.

For k_y = 0 this is the paper's K_1 > -K_2, K_2 < 1, which is therefore right, and complete: it is
necessary as well as sufficient. For k_y /= 0 the paper gives no condition.

The paper's eq. (eq.ss) reads x_cl = Pi w with a Pi of shape (2, 1). The closed loop has three
states and the exosystem two, so it is x_cl = Pi x_W with a Pi of shape (3, 2), as here: the present
value of w alone does not say where on its orbit the exosystem is.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from ..models.linear import HARMONIC, INTERNAL_MODEL, LAG
from ..models.model import Model, Params

Matrix = npt.NDArray[np.float64]


def state_space(model: Model, p: Params) -> tuple[Matrix, Matrix, Matrix, float]:
    """Return (A, B, C, D) of a linear model, shapes (n, n), (n,), (n,) and a number."""
    assert model.jacobian is not None
    n, rest = model.dimension, (0.0,) * model.dimension
    rows = np.array(model.jacobian(rest, 0.0, p))
    unit = [tuple(float(i == j) for j in range(n)) for i in range(n)]
    c = np.array([model.output(x, 0.0, p) for x in unit])
    return rows[:, :n], rows[:, n], c, model.output(rest, 1.0, p)


def closed_loop(p: Params) -> Matrix:
    """Return the closed-loop matrix (d.linear.cl_matrix), shape (3, 3), with the controller's p."""
    a, b, c, _ = state_space(LAG, p)
    phi, g, k_eta, k_y = state_space(INTERNAL_MODEL, p)
    return np.block([[a - k_y * np.outer(b, c), -np.outer(b, k_eta)], [np.outer(g, c), phi]])


def disturbance() -> Matrix:
    """Return how x_W enters the closed loop (through w, into the plant only), shape (3, 2)."""
    entry = np.outer(state_space(LAG, ())[1], state_space(HARMONIC, ())[2])
    return np.vstack([entry, np.zeros((INTERNAL_MODEL.dimension, HARMONIC.dimension))])


def exosystem() -> Matrix:
    """Return S, the matrix of the exosystem (eq. s.linear.w), shape (2, 2)."""
    return state_space(HARMONIC, ())[0]


def spectral_abscissa(a: Matrix) -> float:
    """Return the largest real part of the eigenvalues of ``a``; negative: Hurwitz."""
    return float(np.linalg.eigvals(a).real.max())


def paper_condition(p: Params) -> bool | None:
    """Return the paper's condition (s.linear.gains), or None when k_y /= 0, where it has none."""
    k_y, k_1, k_2 = p
    return None if k_y != 0.0 else k_1 > -k_2 and k_2 < 1.0


def routh_hurwitz(p: Params) -> bool:
    """Return the condition of Routh and Hurwitz for any k_y; see the head of the module."""
    k_y, k_1, k_2 = p
    a = 1.0 + k_y
    return a > 0.0 and k_2 < a and a * k_1 > -k_2


def francis(a_cl: Matrix, p_w: Matrix, s: Matrix) -> Matrix | None:
    """Return Pi of the steady state x_cl = Pi x_W: the solution of Pi S = A_cl Pi + P_w.

    Shapes: ``a_cl`` (n, n), ``p_w`` (n, q), ``s`` (q, q), Pi (n, q). None when A_cl and S share an
    eigenvalue: there is no unique solution then.
    """
    n, q = p_w.shape
    operator = np.kron(s.T, np.eye(n)) - np.kron(np.eye(q), a_cl)
    if np.linalg.matrix_rank(operator) < n * q:
        return None
    pi = np.linalg.solve(operator, p_w.flatten(order='F'))
    return cast(Matrix, pi.reshape((n, q), order='F'))


def residual(pi: Matrix) -> float:
    """Return the amplitude of y at steady state for an x_W of length 1: the norm of Pi's first row.

    0 if and only if the controller contains the exosystem (and K_eta /= 0): the internal model.
    """
    return float(np.hypot(*pi[0]))
