# SPDX-License-Identifier: Apache-2.0
"""The loop as a map, against the simulation whose steps it takes."""

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.simulation.sampled import simulate_sampled

pytest.importorskip('numba')

from eventreg_ros.simulation.lane_flow import LaneFlow

STEPS = 400


@pytest.mark.slow
@pytest.mark.parametrize('hold', ['linear', 'zero'])
@pytest.mark.parametrize('scenario', ['mismatch', 'linear'])
def test_the_map_is_the_simulation_to_the_bit_wherever_it_is_cut(scenario, hold):
    loop = load(scenario, f'/**.hold:={hold}').loop
    run = simulate_sampled(loop, STEPS * 0.05, compiled=False)
    flow = LaneFlow(loop, ['y', 'w', 'u'])
    states = np.tile(flow.start, (40, 1))
    params = [np.tile(np.array(tuple(s.params)), (40, 1)) for s in loop.blocks.values()]
    first = flow.take(states, params, 0.05, 150)
    second = flow.take(first.ends, params, 0.05, STEPS - 150)
    for i, signal in enumerate(['y', 'w', 'u']):
        whole = np.concatenate([first.samples[39, i], second.samples[39, i, 1:]])
        assert np.array_equal(whole, run.signals[signal])
        assert second.ends[0, flow.sample_of(signal)] == run.signals[signal][-1]


@pytest.mark.slow
def test_lanes_have_states_and_parameters_of_their_own():
    loop = load('exact').loop
    flow = LaneFlow(loop, ['y'])
    own = flow.places_of('controller')
    states = np.tile(flow.start, (2, 1))
    states[1, own[0]] += 0.1
    params = [np.tile(np.array(tuple(s.params)), (2, 1)) for s in loop.blocks.values()]
    params[list(loop.blocks).index('exosystem')][1, 1] = 0.1
    ends = flow.take(states, params, 0.05, 100).ends
    w = flow.places_of('exosystem')
    assert not np.isclose(ends[0, w], ends[1, w]).any()
    alone = flow.take(states[1:], [each[1:] for each in params], 0.05, 100).ends
    assert np.array_equal(alone[0], ends[1])
    assert len(own) == 4 + 2  # states, the sample of u now and a step before
