# SPDX-License-Identifier: Apache-2.0
"""Multipliers against eigenvalues, against a monodromy by differences, against averaging."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros import load
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.theory.averaging import learning_rate, teaching
from eventreg_ros.theory.floquet import AperiodicError, floquet
from eventreg_ros.theory.lyapunov import NoJacobianError


@pytest.mark.slow
def test_of_the_linear_motif_they_are_those_of_its_matrix():
    loop = load('linear').loop
    k_y, k_1, k_2 = loop.blocks['controller'].params
    closed = np.array([[-1 - k_y, -k_1, -k_2], [1, 0, 1], [0, -1, 0]])  # y, then the controller
    found = floquet(loop)
    assert found.period == pytest.approx(2 * np.pi, abs=1e-9)
    expected = np.sort(np.abs(np.exp(np.linalg.eigvals(closed) * 2 * np.pi)))[::-1]
    np.testing.assert_allclose(np.abs(found.multipliers), expected, rtol=1e-7)
    assert found.rate == pytest.approx(np.linalg.eigvals(closed).real.max(), abs=1e-8)


def slope(t, s):
    """The closed loop of ``exact``, written out again."""
    a, b, c, d, p, q, r, z, y, m = s
    return [
        a - a**3 / 3 - b + 2 * (-c - a), (a - b) / 12,
        c - c**3 / 3 - d + 2 * (-a - c), (c - d) / 12,
        p - p**3 / 3 - q + 2 * (y - r - p), (p - q) / 12,
        r - r**3 / 3 - z + 2 * (-p - r), (r - z) / 12,
        y - y**3 / 3 - m + (a - p - y), (y - m) / 11,
    ]  # fmt: skip


def after(s, time, **more):
    return solve_ivp(slope, (0.0, time), s, 'DOP853', rtol=1e-12, atol=1e-13, **more)


@pytest.mark.slow
def test_exact_contracts_at_the_rate_of_differences_of_trajectories():
    """One period of the flow from 12 neighbours of the periodic solution, u = w and y = 0 there."""

    def rises(t, s):
        return s[0]

    rises.direction = 1.0
    orbit = after([1, 0, -1, 0, 1, 0, -1, 0, 0, 0], 900.0, events=rises)
    period, s = np.diff(orbit.t_events[0])[-1], orbit.y_events[0][-1]
    columns = []
    for i in range(4, 10):
        each = 1e-4 * np.eye(10)[i]
        ends = [after(s + sign * each, period).y[4:, -1] for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / 2e-4)
    largest = np.abs(np.linalg.eigvals(np.array(columns))).max()
    found = floquet(load('exact').loop)
    assert found.period == pytest.approx(period, abs=1e-8)
    assert found.rate == pytest.approx(np.log(largest) / period, abs=1e-6)
    assert found.rate == pytest.approx(-0.1023, abs=1e-4), 'the averaged exponent of docs/theory.md'


@pytest.mark.slow
def test_an_adaptive_loop_learns_at_the_rate_that_averaging_predicts():
    loop = load('exact', 'controller.k:=8', 'controller.adapt:=0.01').loop
    assert -floquet(loop).rate == pytest.approx(learning_rate(1 / 12, 0.01), rel=0.01)


@pytest.mark.slow
def test_what_teaches_is_positive_and_that_of_a_filter_in_time():
    """<x_2 sigma> by integrating sigma' = x_2' - tau sigma, instead of by Fourier series."""
    tau = 1 / 12

    def driven(t, s):
        x, r, sigma = s
        dr = tau * (x - r)
        return [x - x**3 / 3 - r, dr, dr - tau * sigma]

    def rises(t, s):
        return s[0]

    rises.direction = 1.0
    options = {'method': 'DOP853', 'rtol': 1e-10, 'atol': 1e-12}
    run = solve_ivp(driven, (0.0, 700.0), [1, 0, 0], events=rises, **options)
    t = np.linspace(0.0, np.diff(run.t_events[0])[-1], 4001)
    _, r, sigma = solve_ivp(driven, (0.0, t[-1]), run.y_events[0][-1], t_eval=t, **options).y
    assert teaching(tau) == pytest.approx(np.trapezoid(r * sigma, t) / t[-1], rel=1e-5)
    assert all(teaching(each) > 0.0 for each in (0.04, 0.2, 0.9))


@pytest.mark.slow
@pytest.mark.parametrize(
    ('overrides', 'words'),
    [
        (['quiescent'], 'one exosystem'),
        (['open'], 'no stimulus'),
        (['exact', 'exosystem.model:=neuron', 'exosystem.x0:=[1.0, 0.0]'], 'at rest'),
        (['exact', 'exosystem.tau:=1.2'], 'not periodic'),  # it fades like 1 / sqrt(t)
        (['exact', 'controller.k:=0.1', 'exosystem.tau:=0.05'], 'does not respond with the period'),
    ],
)
def test_without_a_periodic_solution_there_are_none(overrides, words):
    with pytest.raises(AperiodicError, match=words):
        floquet(load(*overrides).loop)


def test_a_model_without_a_jacobian_is_named():
    loop = load('exact').loop
    plant = loop.blocks['plant']
    plain = replace(plant, model=replace(plant.model, jacobian=None))
    with pytest.raises(NoJacobianError, match="'neuron' of plant has no Jacobian"):
        floquet(Loop({**loop.blocks, 'plant': plain}))
