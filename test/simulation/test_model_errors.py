# SPDX-License-Identifier: Apache-2.0
"""A model whose arithmetic fails on the way: an error in words, sampled and continuous."""

import math
import sys
from dataclasses import replace

import pytest

from eventreg_ros import scenario
from eventreg_ros.errors import EventregError
from eventreg_ros.models import Model, first_state
from eventreg_ros.simulation import continuous
from eventreg_ros.simulation.sampled import SampledLoop

GROWING = Model('growing', 1, lambda x, drive, p: (math.exp(10.0 * x[0]),), first_state)


def loop_of(model):
    exact = scenario.load('exact').loop
    plant = replace(exact.blocks['plant'], model=model, params=(), x0=(1.0,))
    return replace(exact, blocks={**exact.blocks, 'plant': plant})


@pytest.fixture
def loop():
    return loop_of(GROWING)


def test_sampled_and_continuous_say_what_failed(loop):
    for simulate in (
        lambda: SampledLoop(loop).run(10.0, compiled=False),
        lambda: continuous.simulate(loop, 10.0),
    ):
        with pytest.raises(EventregError, match='cannot be evaluated: OverflowError: math range'):
            simulate()


@pytest.mark.parametrize(
    ('slope', 'words'),
    [
        (lambda: {}['a'], "KeyError: 'a'"),
        (lambda: sys.exit(0), 'SystemExit: 0'),
        (lambda: None, 'TypeError'),
        (lambda: (1j,), 'TypeError'),
    ],
)
def test_code_of_other_packages_may_raise_or_return_anything(slope, words):
    def rhs(x, drive, p):
        return slope() if x[0] > 1.5 else (1.0,)

    strange = loop_of(Model('strange', 1, rhs, first_state))
    for simulate in (
        lambda: SampledLoop(strange).run(10.0, compiled=False),
        lambda: continuous.simulate(strange, 10.0),
    ):
        with pytest.raises(EventregError, match=f"model 'strange' cannot be evaluated: {words}"):
            simulate()


def test_a_fault_of_ours_is_not_blamed_on_a_model_of_ours(monkeypatch):
    loop = scenario.load('exact').loop
    assert loop.foreign_models == []
    monkeypatch.setattr(SampledLoop, '_advance', lambda *_: {}['a'])
    with pytest.raises(KeyError):
        SampledLoop(loop).run(10.0)


def test_models_that_learn_or_are_limited_are_ours():
    assert scenario.load('unknown').loop.foreign_models == []
    assert scenario.load('exact', ['plant.output_limit:=1.5']).loop.foreign_models == []
