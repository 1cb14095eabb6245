# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import scenario
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.errors import EventregError
from eventreg_ros.models import INTERNAL_MODEL
from eventreg_ros.models.linear import Gains
from eventreg_ros.simulation import jit
from eventreg_ros.simulation.block import Block
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.hold import line
from eventreg_ros.simulation.impairment import Impairment, received
from eventreg_ros.simulation.loop import Loop
from eventreg_ros.simulation.sampled import SampledLoop, simulate_sampled

PERFECT, IMPAIRED = Impairment(), Impairment(delay=0.15, loss=0.2, jitter=0.2, seed=5)


def load(name, hold, *overrides):
    loop = scenario.load(name, overrides).loop
    return loop.sampled_at(loop.grid[1], hold)


def changed(loop, name, **changes):
    """The loop with one block changed."""
    block = replace(loop.blocks[name], **changes)
    return Loop({**loop.blocks, name: block}, loop.stimuli)


def at_step(loop, h):
    return loop.sampled_at(loop.grid[0] / h)


def by_hand(loop, steps, impairment):
    """What the nodes do: everybody reads the samples up to n, then everybody writes n + 1."""
    spec = next(iter(loop.blocks.values()))
    have = received([signal for _, signal in loop.links], steps, spec.h, impairment)
    nodes = {name: Block(spec) for name, spec in loop.blocks.items()}
    sent = {node.spec.output: [node.y] for node in nodes.values()}
    observed = [
        (signal, node, i) for node in nodes.values() for signal, i in node.spec.observed.items()
    ]
    sent |= {signal: [node.x[i]] for signal, node, i in observed}
    for signal, stimulus in loop.stimuli.items():
        sent[signal] = [stimulus(n * spec.time_scale / spec.rate) for n in range(steps + 1)]
    for n in range(steps):
        outputs = {}
        for name, node in nodes.items():
            lines = []
            for signal, _ in node.spec.inputs:
                if (name, signal) not in loop.links:
                    lines.append((0.0, 0.0))
                    continue
                link = loop.links.index((name, signal))
                i, j = int(have.newest[link, n]), int(have.previous[link, n])
                horizon = node.spec.horizon
                if i < 0:
                    lines.append((0.0, 0.0))
                elif j < 0:
                    lines.append(line(sent[signal][i], sent[signal][i], n - i, 1.0, horizon))
                else:
                    lines.append(line(sent[signal][i], sent[signal][j], n - i, i - j, horizon))
            outputs[node.spec.output] = node.advance(
                *zip(*lines, strict=True) if lines else ((), ())
            )
        outputs |= {signal: node.x[i] for signal, node, i in observed}
        for signal, value in outputs.items():
            sent[signal].append(value)
    return sent


def assert_same_bits(a, b):
    assert list(a) == list(b)
    for name in a:
        np.testing.assert_array_equal(np.asarray(a[name]).view(np.int64), b[name].view(np.int64))


@pytest.mark.parametrize('impairment', [PERFECT, IMPAIRED], ids=['clean', 'impaired'])
@pytest.mark.parametrize('hold', ['zero', 'linear'])
@pytest.mark.parametrize('name', sorted({*scenario.shipped()} - {'late'}))
def test_the_bits_of_stepping_blocks_by_hand(name, hold, impairment):
    lively = {'open': ['stimulus.onsets:=[1.0, 4.1]'], 'linear': ['controller.k_y:=0.4']}
    loop = load(name, hold, *lively.get(name, []))
    steps = 300
    expected = by_hand(loop, steps, impairment)
    duration = steps * loop.grid[0] / loop.grid[1]
    found = simulate_sampled(loop, duration, impairment, compiled=False).signals
    assert_same_bits({name: np.array(expected[name]) for name in found}, found)


@pytest.mark.slow
def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    # every kind of part in one network: 4, 2 and 1 states, feedthrough, no, one and more inputs
    loop = load('open', 'linear')
    gains = Gains(0.3, 0.6, 0.2)
    loop = changed(loop, 'controller', model=INTERNAL_MODEL, params=gains, x0=(0.5, 0.0))
    lag = load('linear', 'linear').blocks['plant']
    loop = changed(loop, 'reference', model=lag.model, params=lag.params, x0=lag.x0)
    sampled = SampledLoop(loop)
    for impairment in (PERFECT, IMPAIRED):
        plain = sampled.run(300.0, impairment, compiled=False)
        fast = sampled.run(300.0, impairment, compiled=True)
        assert_same_bits(plain.signals, fast.signals)
    zero = SampledLoop(loop.sampled_at(loop.grid[1], 'zero'))
    lossy = Impairment(loss=0.4, seed=2)
    plain, fast = (zero.run(300.0, lossy, compiled=c) for c in (False, True))
    assert_same_bits(plain.signals, fast.signals)


@pytest.mark.parametrize(('hold', 'slope'), [('zero', 1.0), ('linear', 2.0)])
@pytest.mark.parametrize('name', ['exact', 'mismatch', 'linear'])
def test_the_error_falls_with_the_step(name, hold, slope):
    loop = load(name, hold)
    errors = []
    for h in (0.05, 0.025, 0.0125):
        loop = at_step(loop, h)
        truth, found = simulate(loop, 30.0), simulate_sampled(loop, 30.0)
        errors.append([np.abs(truth.signals[s] - found.signals[s]).max() for s in ('y', 'u')])
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(slope, abs=0.08)


@pytest.mark.parametrize('hold', ['zero', 'linear'])
def test_exact_still_vanishes(hold):
    found = simulate_sampled(at_step(load('exact', hold), 0.02), 400.0)
    assert np.abs(found.signals['y'][found.t >= 399.0]).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(('name', 'low', 'high'), [('exact', 0.3, 0.45), ('mismatch', 0.2, 0.35)])
def test_the_verdict_flips_with_the_delay(name, low, high):
    loop = SampledLoop(at_step(load(name, 'zero'), 0.01))

    def verdict(delay):
        found = loop.run(260.0, Impairment(delay=delay))
        signals = {s: (found.t, x) for s, x in found.signals.items()}
        return judge(signals, subject_by_name(signals)).verdict

    assert (verdict(low), verdict(high)) == ('rejected', 'not rejected')


def test_a_delayed_link_delays_the_answer_and_nothing_else():
    loop = load('uncontrolled', 'zero')
    prompt = simulate_sampled(loop, 60.0).signals
    late = simulate_sampled(loop, 60.0, Impairment(delay=0.35)).signals
    np.testing.assert_array_equal(late['w'], prompt['w'])
    np.testing.assert_array_equal(late['y'][7:], prompt['y'][:-7])
    assert not late['y'][:8].any()


def test_everything_lost_is_nobody_there():
    loop = load('exact', 'linear')
    deaf = simulate_sampled(loop, 20.0, Impairment(loss=1.0)).signals
    alone = {n: simulate_sampled(Loop({n: spec}), 20.0) for n, spec in loop.blocks.items()}
    for name, spec in loop.blocks.items():
        np.testing.assert_array_equal(deaf[spec.output], alone[name].signals[spec.output])


def test_the_seed_decides():
    loop = load('exact', 'zero')
    a, b, c = (
        simulate_sampled(loop, 20.0, Impairment(loss=0.3, jitter=0.2, seed=seed)).signals['y']
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_v_is_sampled_at_n_h():
    loop = load('open', 'zero', '/**.rate:=70', 'stimulus.waveform:=sine')
    found = simulate_sampled(loop, 20.0)
    assert found.signals['v'].tolist() == [loop.stimuli['v'](n * 10.0 / 70.0) for n in range(141)]


@pytest.mark.parametrize('name', ['linear', 'exact'])
def test_a_state_that_explodes_is_an_error(name):
    loop = load(name, 'zero', *(['controller.gain:=[-5, 0]'] if name == 'linear' else []))
    if name == 'exact':
        loop = changed(loop, 'controller', x0=(1e200, 0.0, 0.0, 0.0))
    with pytest.raises(EventregError, match=r'stops being finite at t = [0-9.]+ \(model time\)'):
        simulate_sampled(loop, 1000.0)


@pytest.mark.parametrize(
    'bad', [{'loss': 1.5}, {'loss': float('nan')}, {'delay': -0.1}, {'jitter': -1.0}, {'seed': -1}]
)
def test_bad_impairments_are_errors(bad):
    with pytest.raises(EventregError, match=f'{next(iter(bad))} must be'):
        Impairment(**bad)


def test_compiling_is_chosen_when_it_pays(monkeypatch):
    made = []
    monkeypatch.setattr(jit, '_walked', type(jit._walked)())
    monkeypatch.setattr(jit, '_compiled', {})
    monkeypatch.setattr(jit, '_compile', made.append)
    monkeypatch.setattr(jit, '_njit', lambda: object())
    monkeypatch.setattr(jit, '_entry', lambda parts: None)
    monkeypatch.setattr(jit, 'is_kept', lambda entry: False)
    parts = SampledLoop(load('exact', 'zero')).parts
    few = jit.PAYS // 4
    assert [jit.choose(parts, few, None)[1] for _ in range(5)] == [False] * 4 + [True]
    assert made == [parts]
    jit._walked.clear()
    monkeypatch.setattr(jit, 'is_kept', lambda entry: True)
    assert [jit.choose(parts, jit.LOADS // 2, None)[1] for _ in range(3)] == [False, False, True]
    monkeypatch.setattr(jit, '_njit', lambda: None)
    assert not jit.choose(parts, 10 * few, None)[1]


def test_compiling_without_numba_says_what_to_install(monkeypatch):
    monkeypatch.setattr(jit, '_compiled', {})
    monkeypatch.setitem(__import__('sys').modules, 'numba', None)
    with pytest.raises(EventregError, match='pip install numba'):
        simulate_sampled(load('exact', 'zero'), 1.0, compiled=True)


def test_links_that_are_not_meant_stay_perfect():
    loop = load('exact', 'zero')
    steps, h = 50, 0.05
    signals = [signal for _, signal in loop.links]
    have = received(signals, steps, h, Impairment(delay=0.2, loss=0.3, on=frozenset({'u'})))
    everywhere = received(signals, steps, h, Impairment(delay=0.2, loss=0.3))
    for link, signal in enumerate(signals):
        expected = everywhere.newest[link] if signal == 'u' else np.arange(steps)
        np.testing.assert_array_equal(have.newest[link], expected)
