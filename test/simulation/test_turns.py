# SPDX-License-Identifier: Apache-2.0
"""What is done to a loop while it runs: to the same bits by hand, and as one continuous system."""

from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import scenario, simulate
from eventreg_ros.errors import EventregError
from eventreg_ros.scenario.interventions import read_all, turns
from eventreg_ros.simulation.block import Block
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import SampledLoop

AT = (
    '4:controller:deactivate',
    '9:controller:activate',
    '12:plant.k:=1.5',
    '15:exosystem.tau:=0.1',
)


def by_hand(steps):
    """The loop `exact` with the zero hold, stepped by hand, with what AT says."""
    loop = scenario.load('exact', ['/**.hold:=zero']).loop
    nodes = {name: Block(spec) for name, spec in loop.blocks.items()}
    off, sent = set(), {b.spec.output: [b.y] for b in nodes.values()}
    for n in range(steps):
        starting = set()
        if n == 80:
            off.add('controller')
        if n == 180:
            off.clear()
            starting.add('controller')
            nodes['controller'] = Block(loop.blocks['controller'])
        if n == 240:
            nodes['plant'].retune(replace(loop.blocks['plant'], params=(1.5, 1 / 11)))
        if n == 300:
            nodes['exosystem'].retune(replace(loop.blocks['exosystem'], params=(2.0, 0.1)))
        made = {}
        for name, block in nodes.items():
            values = [sent[s][n] if s in sent else 0.0 for s, _ in block.spec.inputs]
            if name in off:
                made[block.spec.output] = 0.0
            elif name in starting:
                made[block.spec.output] = block.y
            else:
                made[block.spec.output] = block.advance(values, [0.0] * len(values))
        for signal, value in made.items():
            sent[signal].append(value)
    return sent


def test_sampled_it_has_the_bits_of_stepping_by_hand():
    found = simulate(scenario.load('exact', ['/**.hold:=zero']), 20.0, sampled=True, at=AT)
    for signal, values in by_hand(400).items():
        np.testing.assert_array_equal(found[signal].view(np.int64), np.array(values).view(np.int64))


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    case = scenario.load('unknown') if 'unknown' in scenario.shipped() else scenario.load('exact')
    done = turns(read_all(['5:controller:deactivate', '9:controller:activate'], case), case)
    loop, impaired = SampledLoop(case.loop), Impairment(delay=0.1, loss=0.1, seed=2)
    plain, fast = (loop.run(14.0, impaired, done, compiled=c).signals for c in (False, True))
    for name in plain:
        np.testing.assert_array_equal(plain[name].view(np.int64), fast[name].view(np.int64))


def test_the_continuous_system_is_the_limit_of_the_samples():
    errors = []
    for rate in (200, 400, 800):
        case = scenario.load('exact', [f'/**.rate:={rate}'])
        sampled, smooth = (simulate(case, 20.0, sampled=s, at=AT)['y'] for s in (True, False))
        late = slice(round(13.0 * rate / 10), None)  # the jumps themselves are of first order
        errors.append(np.abs(sampled - smooth)[late].max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 0.8).all()


@pytest.mark.slow
def test_while_it_is_off_u_is_0_and_y_spikes():
    run = simulate('exact', 400.0, at=['150:controller:deactivate', '280:controller:activate'])
    off = (run.t >= 150.0) & (run.t < 280.0)
    assert not run['u'][off].any()
    spikes = np.array(run.events['y'])
    assert ((spikes > 150.0) & (spikes < 290.0)).sum() >= 3
    assert not (spikes > 330.0).any()


def test_a_stimulus_may_be_set():
    run = simulate('open', 130.0, sampled=True, at=['100:stimulus.amplitude:=3'])
    assert set(run['v'][(run.t > 60.0) & (run.t < 70.0)]) == {1.5}
    assert set(run['v'][(run.t > 110.0) & (run.t < 120.0)]) == {3.0}


@pytest.mark.parametrize(
    ('at', 'words'),
    [
        ('controller:deactivate', 'must be T:NODE'),
        ('x:controller:deactivate', 'the time must be a number >= 0'),
        ('-1:controller:deactivate', 'the time must be a number >= 0'),
        ('nan:controller:deactivate', 'the time must be a number >= 0'),
        ('5:contoller:deactivate', "did you mean 'controller'"),
        ('5:controller.kk:=1', "has no parameter 'kk'"),
        ('5:controller.k:=-1', 'controller.k must be a finite number >= 0'),
        ('5:controller.x0:=[1, 0, 0, 0]', 'cannot be set while the node runs; these can: k, tau'),
        ('5:controller.time_scale:=5', 'has one time_scale'),
        ('5:controller.adapt:=0.04', 'u/tau would begin in the midst of a simulation'),
        ('5:spike_monitor:deactivate', 'use eventreg run'),
        ('10:controller:deactivate', '10 is not before the end, the duration is 10 of model time'),
        ('10.5:controller.k:=3', '10.5 is not before the end'),
    ],
)
def test_what_is_wrong_is_one_line(at, words):
    with pytest.raises(EventregError) as error:
        simulate('exact', 10.0, at=[at])
    assert words in str(error.value)
    assert '\n' not in str(error.value)
