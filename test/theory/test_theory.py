# SPDX-License-Identifier: Apache-2.0
"""The theory against matrices, grids of states and integrations that do not use it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from eventreg_ros.models import HARMONIC, INTERNAL_MODEL, LAG, NEURON, OSCILLATOR
from eventreg_ros.theory import linear
from eventreg_ros.theory.internal_model import compare, embeds
from eventreg_ros.theory.lemmas import antiphase_oscillates, contraction, lemma_1, lemma_2, rests

GRID = [(k, tau) for k in (0.0, 0.3, 0.9, 1.0, 1.05, 1.5, 4.0) for tau in (1 / 12, 0.4, 2.5)]


def params(k, tau=1 / 12):
    return (k, tau)


def jacobian(x1, k, tau):
    """D f as the proof of Lemma 1 prints it."""
    return np.array([[1 - k - x1**2, -1.0], [tau, -tau]])


@pytest.mark.parametrize(('k', 'tau'), GRID)
def test_largest_eigenvalue_is_the_supremum_over_the_states(k, tau):
    metric = np.diag([1.0, 1.0 / tau])
    found = [
        np.linalg.eigvalsh(metric @ j + j.T @ metric).max() / 2.0
        for j in (jacobian(x1, k, tau) for x1 in np.linspace(-3.0, 3.0, 61))
    ]
    assert contraction(k, tau).largest_eigenvalue == pytest.approx(max(found), abs=1e-12)


@pytest.mark.parametrize(('k', 'tau'), GRID)
def test_rate_is_the_largest_that_the_inequality_allows(k, tau):
    """P Df + Df' P + 2 lambda P <= 0 at every state, and not for a lambda that is any larger."""
    metric, rate = np.diag([1.0, 1.0 / tau]), contraction(k, tau).rate

    def worst(lam):
        jacobians = [jacobian(x1, k, tau) for x1 in np.linspace(-3.0, 3.0, 61)]
        return max(
            np.linalg.eigvalsh(metric @ j + j.T @ metric + 2.0 * lam * metric).max()
            for j in jacobians
        )

    assert worst(rate) <= 1e-12
    assert worst(rate + 1e-6) > 0.0


@pytest.mark.parametrize(
    ('k', 'status'),
    [(0.99, 'none'), (1 - 1e-15, 'marginal'), (1.0, 'marginal'), (1 + 1e-15, 'marginal'),
     (1.001, 'pass')],
)  # fmt: skip
def test_lemma_1_needs_more_than_1(k, status):
    assert lemma_1(params(k)).status == status
    assert lemma_2(params(k / 2)).status == status


def test_the_edge_still_brings_solutions_together():
    """V' <= -dx_1^4 / 6 - 2 dx_2^2 at k = 1, from the right-hand side of the model itself."""
    rng, tau = np.random.default_rng(2), 0.2
    for _ in range(500):
        x, z, drive = 2 * rng.normal(size=2), 2 * rng.normal(size=2), rng.normal()
        d = x - z
        change = np.subtract(NEURON.rhs(x, drive, params(1.0, tau)),
                             NEURON.rhs(z, drive, params(1.0, tau)))  # fmt: skip
        slope = 2.0 * d @ np.diag([1.0, 1.0 / tau]) @ change
        assert slope <= -(d[0] ** 4) / 6.0 - 2.0 * d[1] ** 2 + 1e-9


def free_run(model, p, x0, end=600.0):
    """Return the first state over the last third of a run without a drive."""
    t = np.linspace(2 * end / 3, end, 500)
    found = solve_ivp(
        lambda _, x: model.rhs(x, 0.0, p), (0.0, end), x0, 'LSODA', t, rtol=1e-9, atol=1e-11
    )
    return found.y[0]


@pytest.mark.parametrize('tau', [1 / 12, 0.5])
def test_a_neuron_rests_exactly_from_1_minus_tau_on(tau):
    above, below = params(1 - tau + 0.03, tau), params(1 - tau - 0.03, tau)
    assert rests(above)
    assert not rests(below)
    assert np.abs(free_run(NEURON, above, (2.0, 0.0))).max() < 0.01
    assert np.abs(free_run(NEURON, below, (0.01, 0.0))).max() > 0.1


@pytest.mark.parametrize('tau', [0.9, 1.5])
def test_antiphase_oscillates_below_tau_1(tau):
    p = params(1.0, tau)
    amplitude = np.abs(free_run(OSCILLATOR, p, (1.0, 0.0, -1.0, 0.0))).max()
    assert antiphase_oscillates(p) == (amplitude > 0.5)


def test_embeds_by_tau_alone():
    w = (OSCILLATOR, params(2.0))
    assert embeds(OSCILLATOR, params(2.0), *w) == 'pass'
    assert embeds(OSCILLATOR, params(0.3), *w) == 'pass'
    assert embeds(OSCILLATOR, params(2.0, 1 / 16), *w) == 'fail'
    assert embeds(OSCILLATOR, params(0.0), *w) == 'fail', 'y does not reach it'
    assert embeds(OSCILLATOR, params(0.3, 1 / 16), *w) == 'none', 'it need not be in antiphase'
    assert embeds(OSCILLATOR, params(2.0, 1 / 16), OSCILLATOR, params(0.3)) == 'none'
    assert embeds(OSCILLATOR, params(0.3), OSCILLATOR, params(0.3)) == 'pass', 'a copy always is'
    assert embeds(OSCILLATOR, params(2.0, 0.1), OSCILLATOR, params(2.0, 1.5)) == 'none', 'w dies'
    assert embeds(INTERNAL_MODEL, params(0.0), *w) == 'none'


@pytest.mark.parametrize('k', [0.0, 0.3, 0.95, 1.0, 2.0])
def test_one_neuron_never_embeds_an_oscillator(k):
    assert embeds(NEURON, params(k), OSCILLATOR, params(2.0)) == 'fail'


def closed_loop_y(controller, plant=(1.0, 1 / 11), exosystem=(2.0, 1 / 12), end=500.0):
    """Integrate the paper's loop and return the largest |y| over the last 100."""

    def rhs(_, z):
        w, x, eta = z[:4], z[4:6], z[6:]
        return [
            *OSCILLATOR.rhs(w, 0.0, params(*exosystem)),
            *NEURON.rhs(x, w[0] - eta[0], params(*plant)),
            *OSCILLATOR.rhs(eta, x[0], params(*controller)),
        ]

    x0 = [1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.5, 0.0, -0.5, 0.0]
    t = np.linspace(end - 100.0, end, 201)
    return np.abs(solve_ivp(rhs, (0.0, end), x0, 'LSODA', t, rtol=1e-9, atol=1e-11).y[4]).max()


@pytest.mark.slow
def test_a_controller_with_another_k_and_the_same_tau_still_regulates_exactly():
    """What ``embeds`` adds to the paper, seen in the closed loop."""
    assert closed_loop_y((3.0, 1 / 12)) < 1e-7
    assert closed_loop_y((2.0, 1 / 16)) > 0.1


def test_compare():
    same = compare(OSCILLATOR, params(2.0), OSCILLATOR, params(2.0, 0.08333333333333333))
    assert same.exact
    assert (same.k, same.tau) == (0.0, 0.0)
    off = compare(OSCILLATOR, params(3.0, 1 / 16), OSCILLATOR, params(1.0))
    assert not off.exact
    assert off.k == pytest.approx(2.0)
    assert off.tau == pytest.approx(-0.25)
    assert compare(NEURON, params(2.0), OSCILLATOR, params(2.0)).exact is False
    assert compare(NEURON, params(2.0), NEURON, params(0.0)).k is None, 'relative to 0'
    assert compare(INTERNAL_MODEL, params(1.0), HARMONIC, params(2.0)).exact
    assert compare(LAG, params(1.0), LAG, params(2.0)).exact


def gains(count=300, k_y=None):
    rng = np.random.default_rng(3)
    for _ in range(count):
        k1, k2, direct = 2 * rng.normal(size=3)
        yield (direct if k_y is None else k_y, k1, k2)


def test_closed_loop_is_the_matrix_of_the_paper():
    for p in gains(10):
        k_y, k1, k2 = p
        expected = [[-k_y - 1, -k1, -k2], [1, 0, 1], [0, -1, 0]]
        np.testing.assert_allclose(linear.closed_loop(p), expected, rtol=0, atol=1e-15)


def test_routh_hurwitz_and_the_paper_agree_with_the_eigenvalues():
    stable = 0
    for p in gains():
        hurwitz = linear.spectral_abscissa(linear.closed_loop(p)) < 0.0
        assert linear.routh_hurwitz(p) == hurwitz
        assert linear.paper_condition(p) is None
        stable += hurwitz
    assert 30 < stable < 270
    for p in gains(k_y=0.0):
        hurwitz = linear.spectral_abscissa(linear.closed_loop(p)) < 0.0
        assert linear.paper_condition(p) == linear.routh_hurwitz(p) == hurwitz


def test_francis_gives_the_steady_state():
    """Against the loop itself, moved on from Pi x_W by the matrix exponential."""
    p = (0.2, 1.0, 0.3)
    a, entry, s = linear.closed_loop(p), linear.disturbance(), linear.exosystem()
    pi = linear.francis(a, entry, s)
    assert pi.shape == (3, 2)
    whole = expm(7.0 * np.block([[s, np.zeros((2, 3))], [entry, a]]))
    x_w = np.array([0.3, -1.1])
    end = whole @ np.concatenate([x_w, pi @ x_w])
    np.testing.assert_allclose(end[2:], pi @ end[:2], atol=1e-12)
    assert linear.residual(pi) < 1e-14
    np.testing.assert_allclose(p[1:] @ pi[1:], [1.0, 0.0], atol=1e-13)  # u = w


def test_francis_without_the_internal_model_leaves_y():
    """A controller that turns at 1.1 instead of 1, and the plant alone, |1 / (1 + j)|."""
    a = linear.closed_loop((0.0, 1.0, 0.0))
    a[1, 2], a[2, 1] = 1.1, -1.1
    assert linear.residual(linear.francis(a, linear.disturbance(), linear.exosystem())) > 0.05
    alone = linear.francis(np.array([[-1.0]]), np.array([[1.0, 0.0]]), linear.exosystem())
    assert linear.residual(alone) == pytest.approx(np.sqrt(0.5))


def test_francis_needs_a_gain():
    a = linear.closed_loop((0.0, 0.0, 0.0))
    assert linear.francis(a, linear.disturbance(), linear.exosystem()) is None
