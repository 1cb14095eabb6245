# SPDX-License-Identifier: Apache-2.0
"""Morris-Lecar neurons against their equations, written out again in absolute voltages."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from eventreg_ros import load, simulate
from eventreg_ros.models import MORRIS_LECAR, MORRIS_LECAR_OSCILLATOR
from eventreg_ros.models.catalogue import model_of
from eventreg_ros.models.morris_lecar import CONSTANTS, rest
from eventreg_ros.simulation.sampled import simulate_sampled

USUAL = tuple(parameter.default for parameter in CONSTANTS)
P = {
    'morris_lecar': MORRIS_LECAR.pack(1.3, 0.7, 65.0, *USUAL),
    'morris_lecar_oscillator': MORRIS_LECAR_OSCILLATOR.pack(1.3, 0.7, 110.0, 65.0, *USUAL),
}


def current(v, n, applied):
    """The membrane of the textbooks: class 2 constants, uA/cm2."""
    m = 0.5 * (1 + np.tanh((v + 1.2) / 18))
    return applied - 4.4 * m * (v - 120) - 8 * n * (v + 84) - 2 * (v + 60)


def gate(v, n):
    return 0.04 * np.cosh((v - 2) / 60) * (0.5 * (1 + np.tanh((v - 2) / 30)) - n)


def settled(v, applied):
    return current(v, 0.5 * (1 + np.tanh((v - 2) / 30)), applied)


def test_the_rest_is_the_equilibrium():
    for applied in (0.0, 30.0, 60.0, 90.0):
        v = rest(applied, USUAL)
        assert v == pytest.approx(
            brentq(settled, -80.0, 0.0, args=(applied,), xtol=1e-13), abs=1e-11
        )
        p = MORRIS_LECAR.pack(1.0, 1.0, applied, *USUAL)
        n = 0.5 * (1 + np.tanh((v - 2) / 30))
        assert np.abs(MORRIS_LECAR.rhs((0.0, n), 0.0, p)).max() < 1e-13
    assert rest(60.0, USUAL) == pytest.approx(-36.7547, abs=1e-4)


def test_of_several_equilibria_the_rest_is_the_lowest():
    """Class 1 constants at a small current: a rest, a saddle and an unstable focus."""
    class_1 = dict(zip([p.name for p in CONSTANTS], USUAL, strict=True))
    class_1 |= {'phi': 0.0667, 'v_3': 12.0, 'v_4': 17.4, 'g_ca': 4.0}

    def balance(v):
        m, n = (0.5 * (1 + np.tanh((v - a) / b)) for a, b in ((-1.2, 18), (12, 17.4)))
        return 30.0 - 4 * m * (v - 120) - 8 * n * (v + 84) - 2 * (v + 60)

    grid = np.linspace(-80.0, 40.0, 2401)
    assert (np.diff(np.sign(balance(grid))) != 0).sum() == 3
    lowest = grid[np.flatnonzero(np.diff(np.sign(balance(grid))))[0]]
    assert rest(30.0, tuple(class_1.values())) == pytest.approx(
        brentq(balance, lowest, lowest + 0.1)
    )


def test_the_loop_is_that_of_equations_written_out_again():
    """k 2 throughout, 60 and 100 uA/cm2, the initial states of the scenario."""
    v0 = brentq(settled, -60.0, -20.0, args=(60.0,), xtol=1e-13)

    def slope(t, s):
        a, n_a, b, n_b, c, n_c, d, n_d, e, n_e = s
        w, w2, u, u2, y = (v - v0 for v in (a, b, c, d, e))
        return [
            (current(a, n_a, 100) + 2 * (-w2 - w)) / 20, gate(a, n_a),
            (current(b, n_b, 100) + 2 * (-w - w2)) / 20, gate(b, n_b),
            (current(c, n_c, 100) + 2 * (y - u2 - u)) / 20, gate(c, n_c),
            (current(d, n_d, 100) + 2 * (-u - u2)) / 20, gate(d, n_d),
            (current(e, n_e, 60) + 2 * (w - u - y)) / 20, gate(e, n_e),
        ]  # fmt: skip

    run = simulate('morris_lecar', 200.0)
    start = [20, 0.1, -10, 0.1, 10, 0.1, -10, 0.1, 0, 0.07]
    start[0:10:2] = [z + v0 for z in start[0:10:2]]
    truth = solve_ivp(slope, (0.0, 200.0), start, 'DOP853', run.t, rtol=1e-11, atol=1e-11).y
    for signal, i in (('w', 0), ('u', 4), ('y', 8)):
        np.testing.assert_allclose(run[signal], truth[i] - v0, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize('model', [MORRIS_LECAR, MORRIS_LECAR_OSCILLATOR], ids=lambda m: m.name)
def test_the_jacobian_is_the_derivative(model):
    rng, p, d = np.random.default_rng(2), P[model.name], model.dimension
    for _ in range(20):
        z = rng.uniform([-40, 0] * (d // 2) + [-40], [60, 1] * (d // 2) + [40])

        def rhs(z):
            return np.array(model.rhs(tuple(z[:d]), z[d], p))

        expected = [(rhs(z + e) - rhs(z - e)) / 2e-4 for e in 1e-4 * np.eye(d + 1)]
        found = np.array(model.jacobian(tuple(z[:d]), z[d], p))
        np.testing.assert_allclose(found, np.transpose(expected), rtol=1e-6, atol=1e-7)


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    loop = load('morris_lecar').loop
    plain, fast = (simulate_sampled(loop, 300.0, compiled=c).signals for c in (False, True))
    for name, x in plain.items():
        np.testing.assert_array_equal(x.view(np.int64), fast[name].view(np.int64))


@pytest.mark.parametrize('k', [1.0, 2.0])
@pytest.mark.parametrize(
    'x0', [(10.0, 0.1, -10.0, 0.1), (0.0, 0.2, 5.0, 0.3), (30.0, 0.0, -5.0, 0.4)], ids=str
)
@pytest.mark.slow
def test_its_spikes_are_rejected(k, x0):
    run = simulate(load('morris_lecar', f'/**.k:={k}', f'controller.x0:={list(x0)}'), 1300.0)
    assert run.verdict == 'rejected'
    assert len([t for t in run.events['w'] if t > 100.0]) >= 12
    assert np.abs(run['y'][run.t > 1200.0]).max() < {1.0: 0.15, 2.0: 1e-6}[k]


def test_without_control_they_pass():
    run = simulate(load('morris_lecar', 'plant.inhibitory:=[]'), 400.0)
    assert run.verdict == 'not rejected'
    late = [sum(t > 100.0 for t in run.events[signal]) for signal in 'yw']
    assert late == [3, 3]
    assert 60.0 < run['w'].max() < 70.0, '25 to 30 mV in absolute terms'


def test_what_explodes_is_an_error_and_not_an_overflow():
    p = P['morris_lecar']
    assert np.isfinite(MORRIS_LECAR.rhs((1e6, 0.5), 0.0, p)).all()
    assert np.isnan(MORRIS_LECAR.rhs((np.nan, 0.5), 0.0, p)[0])


def test_they_are_in_the_catalogue_in_every_role():
    for role in ('exosystem', 'plant', 'controller', 'reference'):
        assert model_of(role, 'morris_lecar') is MORRIS_LECAR
        assert model_of(role, 'morris_lecar_oscillator') is MORRIS_LECAR_OSCILLATOR
    scenario = load('morris_lecar')
    assert 'i_rest' not in scenario.nodes['plant']
    assert scenario.nodes['controller']['drive_gain'] == 1.0
