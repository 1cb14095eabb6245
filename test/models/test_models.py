# SPDX-License-Identifier: Apache-2.0
"""The models against the equations of the paper, written out again here, and their symmetry."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros.models import HARMONIC, INTERNAL_MODEL, LAG, NEURON, OSCILLATOR
from eventreg_ros.theory.lemmas import lemma_2

MODELS = [NEURON, OSCILLATOR, HARMONIC, LAG, INTERNAL_MODEL]
P, GAINS = (1.7, 0.09), (0.3, 1.2, -0.4)


def p_of(model):
    return GAINS if model is INTERNAL_MODEL else P


def cases(model, count=20):
    rng = np.random.default_rng(1)
    for _ in range(count):
        yield tuple(rng.normal(size=model.dimension).tolist()), float(rng.normal())


@pytest.mark.parametrize('model', MODELS, ids=lambda m: m.name)
def test_jacobian_is_the_derivative_of_the_rhs(model):
    """By complex steps, which have no truncation to speak of."""
    step = 1e-30j
    for x, drive in cases(model):
        jacobian = np.array(model.jacobian(x, drive, p_of(model)))
        assert jacobian.shape == (model.dimension, model.dimension + 1)
        columns = [
            np.imag(model.rhs((*x[:i], x[i] + step, *x[i + 1 :]), drive, p_of(model))) / 1e-30
            for i in range(model.dimension)
        ]
        columns.append(np.imag(model.rhs(x, drive + step, p_of(model))) / 1e-30)
        np.testing.assert_allclose(jacobian, np.transpose(columns), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize('model', MODELS, ids=lambda m: m.name)
def test_rhs_and_output_are_odd(model):
    for x, drive in cases(model):
        minus = tuple(-a for a in x)
        assert model.rhs(minus, -drive, p_of(model)) == tuple(
            -a for a in model.rhs(x, drive, p_of(model))
        )
        assert model.output(minus, -drive, p_of(model)) == -model.output(x, drive, p_of(model))


@pytest.mark.parametrize('model', MODELS, ids=lambda m: m.name)
def test_output_is_linear(model):
    """The variational equation maps perturbations through it."""
    for (x, d), (z, e) in zip(cases(model), reversed([*cases(model)]), strict=True):
        both = tuple(2.0 * a - 3.0 * b for a, b in zip(x, z, strict=True))
        expected = 2.0 * model.output(x, d, p_of(model)) - 3.0 * model.output(z, e, p_of(model))
        assert model.output(both, 2.0 * d - 3.0 * e, p_of(model)) == pytest.approx(
            expected, abs=1e-14
        )


def test_feedthrough_says_whether_the_output_depends_on_the_drive():
    for model in MODELS:
        x = (0.0,) * model.dimension
        assert model.feedthrough == (model.output(x, 1.0, p_of(model)) != 0.0)


def test_neuron_is_eq_fhn():
    k, tau = P[:2]
    for (x1, x2), z in cases(NEURON):
        expected = [x1 - x1**3 / 3 - x2 + k * (z - x1), tau * (x1 - x2)]
        assert NEURON.rhs((x1, x2), z, P) == pytest.approx(expected)
        assert NEURON.output((x1, x2), z, P) == x1


def test_oscillator_is_eq_s_i():
    """Two neurons of eq. fhn: the first has the inputs +y and -y_2, the second -y_1."""
    for (x1, x2, x3, x4), y in cases(OSCILLATOR):
        expected = [*NEURON.rhs((x1, x2), y - x3, P), *NEURON.rhs((x3, x4), -x1, P)]
        assert OSCILLATOR.rhs((x1, x2, x3, x4), y, P) == pytest.approx(expected)
        assert OSCILLATOR.output((x1, x2, x3, x4), y, P) == x1


def test_linear_motif_is_that_of_section_2():
    assert HARMONIC.rhs((2.0, 3.0), 9.0, P) == (3.0, -2.0)
    assert LAG.rhs((2.0,), 5.0, P) == (3.0,)
    assert INTERNAL_MODEL.rhs((2.0, 3.0), 5.0, GAINS) == (8.0, -2.0)
    assert INTERNAL_MODEL.output((2.0, 3.0), 5.0, GAINS) == pytest.approx(
        0.3 * 5 + 1.2 * 2 - 0.4 * 3
    )


def test_oscillator_meets_the_truth():
    """w of ``exact`` in truth/trajectories.json, at t = 0, 25, ..., 100."""
    truth = [1.0, -1.3558010233171724, 0.7351097910409327, 1.7970332099831117, -1.362574932124447]
    found = trajectory((1.0, 0.0, -1.0, 0.0), (2.0, 1 / 12), np.arange(0.0, 101.0, 25.0))
    np.testing.assert_allclose(found[0], truth, atol=1e-8)


def trajectory(x0, p, t):
    def rhs(_, x):
        return OSCILLATOR.rhs(x, 0.0, p)

    return solve_ivp(rhs, (0.0, t[-1]), x0, 'DOP853', t, rtol=1e-11, atol=1e-13).y


@pytest.mark.parametrize('k', [0.55, 1.0, 3.0])
def test_lemma_2_antiphase_at_its_rate(k):
    """The sum of the two neurons falls at least as fast as Lemma 2 has it, in the norm of P."""
    tau, t = 0.3, np.linspace(0.0, 60.0, 121)
    p = (k, tau)
    rate = lemma_2(p).rate
    assert rate == pytest.approx(min(2 * k - 1, tau))
    for x0, _ in cases(OSCILLATOR, 5):
        x1, x2, x3, x4 = trajectory([2 * a for a in x0], p, t)
        distance = np.sqrt((x1 + x3) ** 2 + (x2 + x4) ** 2 / tau)
        assert (distance <= distance[0] * np.exp(-rate * t) + 1e-9).all()
        assert np.abs(x1[-20:]).max() > 1.0, 'it goes on oscillating'


def test_without_coupling_there_is_no_antiphase():
    t = np.linspace(0.0, 200.0, 401)
    x = trajectory((1.0, 0.0, 0.5, 0.2), (0.0, 0.3), t)
    assert np.abs(x[0] + x[2])[-100:].max() > 1.0


@pytest.mark.parametrize('model', [NEURON, OSCILLATOR], ids=lambda m: m.name)
def test_jacobian_compiles(model):
    numba = pytest.importorskip('numba')
    x, drive = next(cases(model))
    assert numba.njit(model.jacobian)(x, drive, p_of(model)) == model.jacobian(
        x, drive, p_of(model)
    )
