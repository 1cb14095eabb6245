# SPDX-License-Identifier: Apache-2.0
"""The periodic orbit of the sampled loop, against a loop that can be solved and long simulations.

The generator is a Stuart-Landau oscillator: its limit cycle is a circle, in exact arithmetic and
under Runge-Kutta steps, which commute with rotations. A linear plant answers with a sine whose size
follows from the transfer function of one step.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from eventreg_ros import load
from eventreg_ros.models import Model
from eventreg_ros.models.model import first_state
from eventreg_ros.simulation.block import BlockSpec
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.simulation.sampled import simulate_sampled
from eventreg_ros.theory.floquet import floquet

pytest.importorskip('numba')

from eventreg_ros.theory.orbit import Orbits
from eventreg_ros.theory.waves import OrbitError

SIZE, OMEGA, DECAY = 1.3, 0.7, 0.9


def circling_rhs(x, drive, p):
    grows = p[0] - x[0] * x[0] - x[1] * x[1]
    return (grows * x[0] - p[1] * x[1], p[1] * x[0] + grows * x[1])


def decaying_rhs(x, drive, p):
    return (drive - p[0] * x[0],)


CIRCLING = Model('circling', 2, circling_rhs, first_state)
DECAYING = Model('decaying', 1, decaying_rhs, first_state)


def solvable(hold, h=0.05):
    def block(name, model, params, x0, inputs):
        return BlockSpec(name, name, model, params, x0, inputs, name[0], 10.0 / h, 10.0, hold)

    return Loop(
        {
            'exosystem': block('exosystem', CIRCLING, (SIZE**2, OMEGA), (0.3, 0.0), ()),
            'plant': block('plant', DECAYING, (DECAY,), (0.0,), (('e', 1.0),)),
        }
    )


def at(points):
    """Points are (radius squared, omega) of the generator."""
    return [points, np.full((len(points), 1), DECAY)]


def runge_kutta(f, x, h):
    a = f(x)
    b = f(x + 0.5 * h * a)
    c = f(x + 0.5 * h * b)
    return x + h * (a + 2 * b + 2 * c + f(x + h * c)) / 6


def peak(squared, omega, h, hold):
    """The largest output of the plant as its samples lie ever closer, and the turn per step."""

    def turn(r):
        return runge_kutta(lambda z: (squared - abs(z) ** 2 + 1j * omega) * z, r + 0j, h) / r

    size = brentq(lambda r: abs(turn(r)) - 1.0, 0.5 * squared**0.5, 2.0 * squared**0.5, xtol=1e-15)
    angle = np.angle(turn(size))
    a = DECAY * h
    kept = 1 - a + a**2 / 2 - a**3 / 6 + a**4 / 24
    begin = h * (1 - a + a**2 / 2 - a**3 / 4) / 6
    middle = h * (4 - 2 * a + a**2 / 2) / 6
    end = h / 6
    slope = 1 - np.exp(-1j * angle) if hold == 'linear' else 0.0
    drive = begin + middle * (1 + slope / 2) + end * (1 + slope)
    return size * abs(drive / (np.exp(1j * angle) - kept)), angle


def h_at(found, d):
    return found.h * 0.7 / (0.7 + d)


@pytest.mark.slow
@pytest.mark.parametrize('hold', ['linear', 'zero'])
def test_a_loop_that_can_be_solved(hold):
    orbits = Orbits(solvable(hold), 'exosystem', 'p', at)
    found = orbits.settled(np.array([1.3**2, 0.7]), 60.0)
    exact, angle = peak(*found.point, found.h, hold)
    assert found.peak == pytest.approx(exact, abs=1e-8)
    assert found.low == pytest.approx(-exact, rel=1e-3)
    assert found.steps * angle == pytest.approx(2 * np.pi, abs=1e-9)
    d = 1e-5  # along which the step stays T / N
    beside = peak(1.3**2 + d, 0.7, found.h, hold)[0], peak(1.3**2, 0.7 + d, h_at(found, d), hold)[0]
    np.testing.assert_allclose(found.slope, (np.array(beside) - exact) / d, atol=2e-5)
    # w's own beside the trivial one, and the plant's
    period = found.period
    expected = [np.exp(-2 * 1.3**2 * period), np.exp(-0.9 * period)]
    np.testing.assert_allclose(np.abs(found.multipliers[:2]), sorted(expected)[::-1], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('hold', ['linear', 'zero'])
def test_the_step_that_fits_the_period_costs_next_to_nothing(hold):
    """The step changes the peak by a h^n; taken at T / N, by a part h / T of that at most."""
    orbits = Orbits(solvable(hold), 'exosystem', 'p', at)
    order = 2 if hold == 'linear' else 1
    for omega in (0.613, 0.7, 0.777):
        found = orbits.settled(np.array([1.3**2, omega]), 60.0)
        exact, _ = peak(*found.point, 0.05, hold)
        continuous = 1.3 / np.hypot(0.9, omega)
        of_the_step = abs(exact - continuous)
        assert abs(found.peak - exact) < order * of_the_step * 0.05 / found.period
        assert of_the_step > 1e-5


@pytest.mark.slow
def test_it_goes_along_with_the_point():
    orbits = Orbits(solvable('linear'), 'exosystem', 'p', at)
    near = orbits.settled(np.array([1.3**2, 0.7]), 60.0)
    for omega in (0.72, 0.8, 0.95):
        near = orbits.at(np.array([1.1, omega]), near)
        while not near.exact:
            near = orbits.at(near.point, near)
        assert near.peak == pytest.approx(peak(1.1, omega, near.h, 'linear')[0], abs=1e-8)
        assert near.h == pytest.approx(0.05, rel=0.6 / near.steps)


@pytest.mark.slow
def test_of_the_neurons_it_is_where_a_long_simulation_ends():
    """The highest sample of a long run is below the peak by what samples can miss, no more."""
    loop = load('exact', 'controller.k:=0.7', 'exosystem.tau:=0.1').loop
    params = [np.array(tuple(spec.params)) for spec in loop.blocks.values()]
    orbits = Orbits(loop, 'exosystem', 'y', lambda u: [np.tile(p, (len(u), 1)) for p in params])
    found = orbits.settled(np.zeros(2), 300.0)
    y = simulate_sampled(loop, 1500.0).signals['y'][10_000:]
    top = int(np.argmax(y))
    missed = (2 * y[top] - y[top - 1] - y[top + 1]) / 8  # half a step away, on a parabola
    assert 0.0 < missed < 1e-3
    assert -1e-6 < found.peak - y[top] < missed
    assert found.low == pytest.approx(y.min(), abs=missed)
    assert np.abs(found.slope).max() < 1e-9
    continuous = floquet(loop, perturbed=('plant', 'controller'))
    assert found.period == pytest.approx(continuous.period, rel=1e-6)
    np.testing.assert_allclose(
        np.abs(found.multipliers[:2]), np.abs(continuous.multipliers[:2]), rtol=0.01
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ('scenario', 'overrides', 'words'),
    [
        ('linear', (), 'its size depends on where it starts'),
        ('exact', ('exosystem.x0:=[0, 0, 0, 0]',), 'w is at rest'),
        ('exact', ('plant.tau:=1e9',), 'the loop diverges'),
    ],
)
def test_where_there_is_none(scenario, overrides, words):
    loop = load(scenario, *overrides).loop
    params = [np.array(tuple(spec.params)) for spec in loop.blocks.values()]
    orbits = Orbits(loop, 'exosystem', 'y', lambda u: [np.tile(p, (len(u), 1)) for p in params])
    with pytest.raises(OrbitError, match=words):
        orbits.settled(np.zeros(2), 300.0)
