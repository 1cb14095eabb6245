# SPDX-License-Identifier: Apache-2.0
"""White noise on every sample of what the plants publish: its size, its place, its seed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from eventreg_ros.api import load, simulate
from eventreg_ros.errors import EventregError

SD = 0.01

TWO_PLANTS = """
plant: {ros__parameters: {rate: 1000.0}}
plant_b: {ros__parameters: {rate: 1000.0, output: y_b}}
"""


def simulated(name='exact', **options):
    return simulate(load(name), 60.0, **options)


def is_white(x, sd):
    """Whether mean, standard deviation and lag-1 correlation lie within 5 standard errors."""
    n, size = len(x), float(np.std(x))
    lag = float(np.corrcoef(x[:-1], x[1:])[0, 1])
    return (
        abs(float(np.mean(x))) < 5.0 * sd / math.sqrt(n)
        and abs(size - sd) < 5.0 * sd / math.sqrt(2.0 * n)
        and abs(lag) < 5.0 / math.sqrt(n)
    )


def test_a_continuous_loop_is_closed_without_it_and_seen_through_it():
    clean, noisy = simulated(), simulated(noise=SD)
    assert is_white(noisy['y'] - clean['y'], SD)
    for name in ('w', 'u'):
        np.testing.assert_array_equal(noisy[name], clean[name])
    np.testing.assert_array_equal(noisy.fine.signals['y'], noisy['y'])  # what is judged


def test_in_a_sampled_loop_it_reaches_the_controller_alone():
    clean, noisy = simulated(sampled=True), simulated(sampled=True, noise=SD)
    np.testing.assert_array_equal(noisy['w'], clean['w'])
    assert np.any(noisy['u'] != clean['u'])
    clean, noisy = (simulated('uncontrolled', sampled=True, noise=sd) for sd in (0.0, SD))
    assert is_white(noisy['y'] - clean['y'], SD)  # nobody hears it, so it cannot come back


def test_the_seed_decides_and_a_longer_run_begins_alike():
    one, same = (simulated(sampled=True, noise=SD, seed=3) for _ in range(2))
    other = simulated(sampled=True, noise=SD, seed=4)
    longer = simulate(load('exact'), 90.0, sampled=True, noise=SD, seed=3)
    np.testing.assert_array_equal(one['y'], same['y'])
    np.testing.assert_array_equal(one['y'], longer['y'][: len(one['y'])])
    assert np.any(one['y'] != other['y'])


def test_every_plant_has_noise_of_its_own(tmp_path):
    path = tmp_path / 'two.yaml'
    path.write_text(TWO_PLANTS)
    two = load(str(path))
    clean = simulate(two, 60.0, sampled=True)
    noisy = simulate(two, 60.0, sampled=True, noise=SD)
    first, second = (noisy[name] - clean[name] for name in ('y', 'y_b'))
    assert is_white(first, SD)
    assert is_white(second, SD)
    assert abs(np.corrcoef(first, second)[0, 1]) < 5.0 / math.sqrt(len(first))


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    from eventreg_ros.simulation.noise import Noise
    from eventreg_ros.simulation.sampled import SampledLoop

    sampled = SampledLoop(load('exact').loop)
    noise = Noise(SD, 1, ('y',))
    plain, fast = (sampled.run(60.0, noise=noise, compiled=c) for c in (False, True))
    for name, x in plain.signals.items():
        np.testing.assert_array_equal(x, fast.signals[name])


@pytest.mark.parametrize('noise', [-0.1, math.nan, math.inf])
def test_a_standard_deviation_is_finite_and_not_negative(noise):
    with pytest.raises(EventregError, match='noise must be >= 0'):
        simulated(noise=noise)
