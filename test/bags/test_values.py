# SPDX-License-Identifier: Apache-2.0
"""Two sources in one signal, samples far off all others: found where they are, and nowhere else."""

import numpy as np
import pytest

from eventreg_ros.bags.values import lone_samples, two_sources, wild_samples

N = 20_000
T = np.arange(N)

ONE = {
    'smooth': lambda rng: np.sin(T * 0.01),
    'coarse': lambda rng: np.sin(T * rng.uniform(0.3, 2.0)),
    'spikes': lambda rng: np.maximum(np.sin(T * 0.2), 0.8) ** 9,
    'white noise': lambda rng: rng.normal(size=N),
    'blue noise': lambda rng: np.diff(rng.normal(size=N + 1)),
    'noisy': lambda rng: np.sin(T * 0.01) + rng.normal(size=N) * 10.0 ** -rng.integers(0, 5),
    'telegraph': lambda rng: (rng.random(N) < 0.5).astype(float),
    'three levels': lambda rng: rng.integers(0, 3, N).astype(float),
    'square': lambda rng: np.sign(np.sin(T * rng.uniform(0.01, 1.5) + 0.1)),
    'single pulses': lambda rng: (rng.random(N) < 0.05).astype(float),
    'quantised': lambda rng: np.round(5 * np.sin(T * 0.003) + rng.normal(size=N) * 0.3),
    'last bits': lambda rng: np.where(T % 2, 1.0, np.nextafter(1.0, 2.0)),
    'constant': lambda rng: np.ones(N),
    'gaps': lambda rng: np.where(rng.random(N) < 0.3, np.nan, np.sin(T * 0.01)),
}  # fmt: skip


@pytest.mark.parametrize('kind', ONE)
def test_one_source_is_one(kind):
    rng = np.random.default_rng(1)
    for _ in range(8):
        values = ONE[kind](rng)
        assert two_sources(values) is None
        assert lone_samples(values) == []
        assert wild_samples(values).tolist() == []


def interleaved(one, other, start=0):
    tail = np.stack([one[start:], other[start:]], 1).reshape(-1)
    return np.concatenate([one[:start], tail])


@pytest.mark.parametrize('start', [0, 200, 5000])
@pytest.mark.parametrize('other', [
    lambda x: x + 1.0, lambda x: np.roll(x, 700), lambda x: -x, lambda x: 0 * x,
])  # fmt: skip
@pytest.mark.parametrize('kind', ['smooth', 'spikes'])
def test_two_sources_that_alternate(kind, other, start):
    one = ONE[kind](np.random.default_rng(2)) + 0.3
    found = two_sources(interleaved(one, other(one), start))
    assert found is not None
    assert start - 32 <= found <= start + 2000


def test_two_sources_in_no_strict_turn():
    rng = np.random.default_rng(3)
    one, other = np.sin(T * 0.01), np.cos(T * 0.013) + 2
    which = rng.random(N) < 0.5
    assert two_sources(np.where(which, one, other)) is not None


@pytest.mark.parametrize('value', [1e300, -50.0, 2.5, np.inf])
@pytest.mark.parametrize('place', [1, 10_000, N - 2])
def test_a_lone_sample(value, place):
    values = np.sin(T * 0.01)
    values[place] = value
    assert lone_samples(values) == ([] if np.isinf(value) else [place])


def test_wild_samples_of_many():
    values = np.sin(T * 0.01)
    values[5000:5040:2] = 1e120
    assert lone_samples(values) == []
    assert wild_samples(values).tolist() == list(range(5000, 5040, 2))


@pytest.mark.parametrize('count', range(70))
def test_few_samples_are_no_trouble(count):
    values = np.random.default_rng(count).normal(size=count)
    assert two_sources(values) is None
    assert lone_samples(values) == []
    assert wild_samples(values).tolist() == []
