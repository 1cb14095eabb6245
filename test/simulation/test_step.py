# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from eventreg_ros.models import HARMONIC, INTERNAL_MODEL, LAG, NEURON, OSCILLATOR
from eventreg_ros.simulation.step import make_step

P = (2.0, 1 / 12, 0.0, 1.0, 0.0)


def orders(errors):
    """The order of convergence between step sizes that halve."""
    errors = np.array(errors)
    return np.log2(errors[:-1] / errors[1:])


def walk(model, x, drive, end, steps, p=P):
    """Step with the drive known at every instant; returns the last state."""
    step, h = make_step(model.rhs, model.dimension), end / steps
    for n in range(steps):
        t = n * end / steps
        x = step(x, drive(t), drive(t + h / 2), drive(t + h), p, h)
    return np.array(x)


def test_order_4_on_the_rotation():
    exact = np.array([math.cos(3.0), -math.sin(3.0)])
    errors = [
        np.abs(walk(HARMONIC, (1.0, 0.0), lambda t: 0.0, 3.0, n) - exact).max()
        for n in (10, 20, 40, 80)
    ]
    assert orders(errors) == pytest.approx(4.0, abs=0.1)


def test_order_4_on_a_driven_lag():
    # x' = sin t - x, x(0) = 0: x = (sin t - cos t + exp(-t)) / 2
    exact = (math.sin(2.0) - math.cos(2.0) + math.exp(-2.0)) / 2
    errors = [abs(walk(LAG, (0.0,), math.sin, 2.0, n)[0] - exact) for n in (10, 20, 40, 80)]
    assert orders(errors) == pytest.approx(4.0, abs=0.2)


def test_order_4_on_the_driven_rotation():
    # x1' = x2 + 1, x2' = -x1 from 0: x = (sin t, cos t - 1)
    exact = np.array([math.sin(2.0), math.cos(2.0) - 1.0])
    errors = [
        np.abs(walk(INTERNAL_MODEL, (0.0, 0.0), lambda t: 1.0, 2.0, n) - exact).max()
        for n in (10, 20, 40, 80)
    ]
    assert orders(errors) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ('model', 'x0'), [(NEURON, (0.3, -0.2)), (OSCILLATOR, (1.0, 0.0, -0.7, 0.1))]
)
def test_order_4_against_a_fine_reference(model, x0):
    def drive(t):
        return 1.5 * math.sin(0.7 * t)

    fine = walk(model, x0, drive, 8.0, 8192)
    errors = [np.abs(walk(model, x0, drive, 8.0, n) - fine).max() for n in (128, 256, 512)]
    assert orders(errors) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(
    ('model', 'x'), [(NEURON, (1.3, -0.4)), (OSCILLATOR, (1.1, 0.2, -0.9, 0.35))]
)
def test_the_step_is_odd_to_the_bit(model, x):
    step = make_step(model.rhs, model.dimension)
    there = step(x, 0.3, 0.5, 0.9, P, 0.05)
    back = step(tuple(-a for a in x), -0.3, -0.5, -0.9, P, 0.05)
    assert back == tuple(-a for a in there)


def test_every_function_passes_through_compile():
    seen = []
    make_step(NEURON.rhs, 2, lambda function: seen.append(function.__name__) or function)
    assert seen == ['add', 'mean', 'neuron_rhs', 'step']
