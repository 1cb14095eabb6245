# SPDX-License-Identifier: Apache-2.0
"""The predicting controller as a node runs it: the bits of the sampled loop."""

from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.control.predicting_block import Heard, PredictingBlock
from eventreg_ros.simulation.block import Block
from eventreg_ros.simulation.hold import line
from eventreg_ros.simulation.impairment import Impairment, received
from eventreg_ros.simulation.sampled import SampledLoop


def scenario(name, *overrides):
    return load(name, 'controller.predict:=true', 'controller.adapt:=0.04', *overrides)


def by_hand(loop, steps, impairment):
    """The loop with the controller fed sample by sample as each comes, others by their lines."""
    h = next(iter(loop.blocks.values())).h
    sampled = SampledLoop(loop)
    leads = [0] * len(sampled.links)
    leads[sampled.links.index(('plant', 'u'))] = loop.blocks['plant'].lead_steps
    signals = [signal for _, signal in sampled.links]
    have = received(signals, steps, h, impairment, leads)
    controller = PredictingBlock(loop.blocks['controller'])
    nodes = {name: Block(spec) for name, spec in loop.blocks.items() if name != 'controller'}
    sent = {block.spec.output: [block.y] for block in (*nodes.values(), controller)}
    for signal, stimulus in loop.stimuli.items():
        sent[signal] = [stimulus(n * h) for n in range(steps + 1)]
    seen = dict.fromkeys(range(len(signals)), -1)
    for n in range(steps):
        heard = []
        for i, (signal, _) in enumerate(controller.spec.inputs):
            if ('controller', signal) not in sampled.links:
                continue
            link = sampled.links.index(('controller', signal))
            new = range(seen[link] + 1, have.newest[link, n] + 1)
            heard += [Heard(i, s, sent[signal][s]) for s in new if have.used[link, s] == s]
            seen[link] = max(seen[link], int(have.newest[link, n]))
        made = {'u': controller.advance(n, heard[::-1])}
        for name, block in nodes.items():
            lines = [(0.0, 0.0)] * len(block.spec.inputs)
            for k, (signal, _) in enumerate(block.spec.inputs):
                if (name, signal) not in sampled.links:
                    continue
                link = sampled.links.index((name, signal))
                i, j, age = have.newest[link, n], have.previous[link, n], n - leads[link]
                if i >= 0:
                    before, gap = (sent[signal][j], i - j) if j >= 0 else (sent[signal][i], 1)
                    lines[k] = line(sent[signal][i], before, age - i, gap, block.spec.horizon)
            made[block.spec.output] = block.advance(
                *zip(*lines, strict=True) if lines else ((), ())
            )
        for signal, value in made.items():
            sent[signal].append(value)
    return sent


@pytest.mark.slow
@pytest.mark.parametrize(
    'impairment',
    [
        Impairment(),
        Impairment(delay=1.5, on=frozenset('yu')),
        Impairment(delay=0.7, jitter=1.2, loss=0.3, seed=4, on=frozenset('yuv')),
    ],
    ids=['clean', 'late', 'impaired'],
)
@pytest.mark.parametrize(
    ('name', 'overrides'),
    [('mismatch', ['/**.lead:=1.5']), ('open', ['/**.lead:=1.5', '/**.input_timeout:=0.05'])],
)
def test_it_has_the_bits_of_the_sampled_loop(name, overrides, impairment):
    onsets = ['stimulus.onsets:=[1.0, 4.1, 22.0]'] if name == 'open' else []
    loop = scenario(name, *overrides, *onsets).loop
    steps = 800  # several times around what it remembers
    found = SampledLoop(loop).run(steps * 0.05, impairment, compiled=False).signals
    expected = by_hand(loop, steps, impairment)
    for signal in ('y', 'u'):
        assert np.array(expected[signal]).tobytes() == found[signal].tobytes(), signal


def fed(block, first, last):
    return [block.advance(n, [Heard(0, n, 0.1 * np.sin(n))]) for n in range(first, last)]


def test_a_restart_forgets_all_but_what_was_learned():
    block = PredictingBlock(scenario('mismatch', '/**.lead:=0.5').loop.blocks['controller'])
    fed(block, 0, 400)
    tau = block.learned['tau']
    assert tau != 1 / 16
    block.restart(400)
    fresh = PredictingBlock(replace(block.spec, x0=(*block.spec.x0[:4], tau)))
    fresh.start(401)
    assert fed(block, 400, 450) == fed(fresh, 400, 450)
    assert block.learned['tau'] != tau


def test_other_parameters_go_on_and_another_step_begins_anew():
    spec = scenario('mismatch', '/**.lead:=0.5').loop.blocks['controller']
    block, other = PredictingBlock(spec), PredictingBlock(spec)
    assert fed(block, 0, 100) == fed(other, 0, 100)
    learned = block.learned['tau']
    again = replace(spec, x0=(*spec.x0[:4], learned))
    block.retune(again)
    assert fed(block, 100, 110) == fed(other, 100, 110)
    block.retune(replace(again, params=(2.0, *spec.params[1:])))
    assert fed(block, 110, 120) != fed(other, 110, 120)
    block.retune(replace(again, time_scale=5.0))
    assert block.x[-1] == 121.0, 'it begins anew'
    assert block.newest == [-1, -1]


def test_samples_of_before_the_start_and_twice_the_same_change_nothing():
    spec = scenario('mismatch').loop.blocks['controller']
    block, clean = PredictingBlock(spec), PredictingBlock(spec)
    for n in range(50):
        sample = Heard(0, n, 0.1)
        old = [Heard(0, -3, 9.0), sample, Heard(0, n - 20, 9.0), sample]
        if n > 20:
            old[2] = Heard(0, -1, 9.0)
        assert block.advance(n, old) == clean.advance(n, [sample])
