# SPDX-License-Identifier: Apache-2.0
"""A model whose arithmetic fails on the way: an error in words, sampled and continuous."""

import math
from dataclasses import replace

import pytest

from eventreg_ros import scenario
from eventreg_ros.errors import EventregError
from eventreg_ros.models import Model, first_state
from eventreg_ros.simulation import continuous
from eventreg_ros.simulation.sampled import SampledLoop

GROWING = Model('growing', 1, lambda x, drive, p: (math.exp(10.0 * x[0]),), first_state)


@pytest.fixture
def loop():
    exact = scenario.load('exact').loop
    plant = replace(exact.blocks['plant'], model=GROWING, params=(), x0=(1.0,))
    return replace(exact, blocks={**exact.blocks, 'plant': plant})


def test_sampled_and_continuous_say_what_failed(loop):
    for simulate in (
        lambda: SampledLoop(loop).run(10.0, compiled=False),
        lambda: continuous.simulate(loop, 10.0),
    ):
        with pytest.raises(EventregError, match='cannot be evaluated: OverflowError: math range'):
            simulate()
