from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import scenario
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.errors import EventregError
from eventreg_ros.models import INTERNAL_MODEL
from eventreg_ros.simulation import jit
from eventreg_ros.simulation.block import Block
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.hold import line
from eventreg_ros.simulation.impairment import received
from eventreg_ros.simulation.sampled import Network, simulate_sampled

IMPAIRED = {'delay': 0.15, 'loss': 0.2, 'jitter': 0.2, 'seed': 5}


def load(name, hold, *overrides):
    setup = scenario.load(name, overrides)
    blocks = {key: replace(spec, hold=hold) for key, spec in setup.blocks.items()}
    return blocks, setup.stimulus


def at_rate(blocks, h):
    return {name: replace(spec, rate=spec.time_scale / h) for name, spec in blocks.items()}


def by_hand(blocks, stimulus, steps, *, delay=0.0, loss=0.0, jitter=0.0, seed=0):
    """What the nodes do: everybody reads the samples up to n, then everybody writes n + 1."""
    spec = next(iter(blocks.values()))
    network = Network(blocks, stimulus)
    have = received(
        len(network.links),
        steps,
        delay=round(delay / spec.h),
        loss=loss,
        jitter=jitter / spec.h,
        seed=seed,
    )
    nodes = {name: Block(spec) for name, spec in blocks.items()}
    sent = {node.spec.output: [node.y] for node in nodes.values()}
    if stimulus is not None:
        sent['v'] = [stimulus(n * spec.time_scale / spec.rate) for n in range(steps + 1)]
    for n in range(steps):
        outputs = {}
        for name, node in nodes.items():
            lines = []
            for signal, _ in node.spec.inputs:
                if (name, signal) not in network.links:
                    lines.append((0.0, 0.0))
                    continue
                link = network.links.index((name, signal))
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
        for signal, value in outputs.items():
            sent[signal].append(value)
    return sent


def assert_same_bits(a, b):
    assert list(a) == list(b)
    for name in a:
        np.testing.assert_array_equal(np.asarray(a[name]).view(np.int64), b[name].view(np.int64))


@pytest.mark.parametrize('impairments', [{}, IMPAIRED], ids=['clean', 'impaired'])
@pytest.mark.parametrize('hold', ['zero', 'linear'])
@pytest.mark.parametrize('name', scenario.shipped())
def test_the_bits_of_stepping_blocks_by_hand(name, hold, impairments):
    lively = {'open': ['stimulus.onsets:=[1.0, 4.1]'], 'linear': ['controller.k_y:=0.4']}
    blocks, stimulus = load(name, hold, *lively.get(name, []))
    steps = 300
    expected = by_hand(blocks, stimulus, steps, **impairments)
    found = simulate_sampled(blocks, stimulus, steps * 0.05, compiled=False, **impairments).signals
    assert_same_bits({name: np.array(expected[name]) for name in found}, found)


def test_compiled_has_the_bits_of_plain():
    pytest.importorskip('numba')
    # every kind of part in one network: 4, 2 and 1 states, feedthrough, no, one and more inputs
    blocks, stimulus = load('open', 'linear', 'controller.gain:=[0.6, 0.2]', 'controller.k_y:=0.3')
    blocks['controller'] = replace(blocks['controller'], model=INTERNAL_MODEL, x0=(0.5, 0.0))
    linear, _ = load('linear', 'linear')
    blocks['reference'] = replace(linear['plant'], output='y_r', inputs=(('v', 1.0),))
    network = Network(blocks, stimulus)
    for impairments in ({}, IMPAIRED):
        plain = network.run(300.0, compiled=False, **impairments)
        fast = network.run(300.0, compiled=True, **impairments)
        assert_same_bits(plain.signals, fast.signals)
    zero = Network({name: replace(spec, hold='zero') for name, spec in blocks.items()}, stimulus)
    plain, fast = (zero.run(300.0, compiled=c, loss=0.4, seed=2) for c in (False, True))
    assert_same_bits(plain.signals, fast.signals)


@pytest.mark.parametrize(('hold', 'slope'), [('zero', 1.0), ('linear', 2.0)])
@pytest.mark.parametrize('name', ['exact', 'mismatch', 'linear'])
def test_the_error_falls_with_the_step(name, hold, slope):
    blocks, _ = load(name, hold)
    errors = []
    for h in (0.05, 0.025, 0.0125):
        blocks = at_rate(blocks, h)
        truth, found = simulate(blocks, None, 30.0), simulate_sampled(blocks, None, 30.0)
        errors.append([np.abs(truth.signals[s] - found.signals[s]).max() for s in ('y', 'u')])
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(slope, abs=0.08)


@pytest.mark.parametrize('hold', ['zero', 'linear'])
def test_exact_still_vanishes(hold):
    blocks, _ = load('exact', hold)
    found = simulate_sampled(at_rate(blocks, 0.02), None, 400.0)
    assert np.abs(found.signals['y'][found.t >= 399.0]).max() < 1e-9


@pytest.mark.parametrize(('name', 'low', 'high'), [('exact', 0.3, 0.45), ('mismatch', 0.2, 0.35)])
def test_the_verdict_flips_with_the_delay(name, low, high):
    blocks, _ = load(name, 'zero')
    network = Network(at_rate(blocks, 0.01))

    def verdict(delay):
        found = network.run(260.0, delay=delay)
        signals = {s: (found.t, x) for s, x in found.signals.items()}
        return judge(signals, scenario=name, time_scale=10.0)['verdict']

    assert (verdict(low), verdict(high)) == ('rejected', 'not rejected')


def test_a_delayed_link_delays_the_answer_and_nothing_else():
    blocks, _ = load('uncontrolled', 'zero')
    prompt = simulate_sampled(blocks, None, 60.0).signals
    late = simulate_sampled(blocks, None, 60.0, delay=0.35).signals
    np.testing.assert_array_equal(late['w'], prompt['w'])
    np.testing.assert_array_equal(late['y'][7:], prompt['y'][:-7])
    assert not late['y'][:8].any()


def test_everything_lost_is_nobody_there():
    blocks, _ = load('exact', 'linear')
    deaf = simulate_sampled(blocks, None, 20.0, loss=1.0).signals
    alone = {name: simulate_sampled({name: spec}, None, 20.0) for name, spec in blocks.items()}
    for name, spec in blocks.items():
        np.testing.assert_array_equal(deaf[spec.output], alone[name].signals[spec.output])


def test_the_seed_decides():
    blocks, _ = load('exact', 'zero')
    a, b, c = (
        simulate_sampled(blocks, None, 20.0, loss=0.3, jitter=0.2, seed=seed).signals['y']
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_v_is_sampled_at_n_h():
    blocks, stimulus = load('open', 'zero', '/**.rate:=70', 'stimulus.waveform:=sine')
    found = simulate_sampled(blocks, stimulus, 20.0, stimulus_output='v')
    assert found.signals['v'].tolist() == [stimulus(n * 10.0 / 70.0) for n in range(141)]


@pytest.mark.parametrize('name', ['linear', 'exact'])
def test_a_state_that_explodes_is_an_error(name):
    blocks, _ = load(name, 'zero', *(['controller.gain:=[-5, 0]'] if name == 'linear' else []))
    if name == 'exact':
        blocks['controller'] = replace(blocks['controller'], x0=(1e200, 0.0, 0.0, 0.0))
    with pytest.raises(EventregError, match=r'stops being finite at t = [0-9.]+ \(model time\)'):
        simulate_sampled(blocks, None, 1000.0)


@pytest.mark.parametrize(
    'bad', [{'loss': 1.5}, {'loss': float('nan')}, {'delay': -0.1}, {'jitter': -1.0}, {'seed': -1}]
)
def test_bad_impairments_are_errors(bad):
    blocks, _ = load('exact', 'zero')
    with pytest.raises(EventregError, match=f'{next(iter(bad))} must be'):
        simulate_sampled(blocks, None, 1.0, **bad)


def test_compiling_is_chosen_when_it_pays(monkeypatch):
    made = []
    monkeypatch.setattr(jit, '_walked', type(jit._walked)())
    monkeypatch.setattr(jit, '_compiled', {})
    monkeypatch.setattr(jit, '_compile', made.append)
    monkeypatch.setattr(jit, '_njit', lambda: object())
    parts = Network(load('exact', 'zero')[0])._parts
    few = jit.PAYS // 3 // 4
    assert [jit.choose(parts, few, None)[1] for _ in range(5)] == [False] * 4 + [True]
    assert made == [parts]
    monkeypatch.setattr(jit, '_njit', lambda: None)
    assert not jit.choose(parts, 10 * few, None)[1]


def test_compiling_without_numba_says_what_to_install(monkeypatch):
    monkeypatch.setattr(jit, '_compiled', {})
    monkeypatch.setitem(__import__('sys').modules, 'numba', None)
    with pytest.raises(EventregError, match=r"pip install 'eventreg_ros\[fast\]'"):
        simulate_sampled(load('exact', 'zero')[0], None, 1.0, compiled=True)
