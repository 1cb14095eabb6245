# SPDX-License-Identifier: Apache-2.0
"""What is identified from bags and scenarios, and the scenarios that come of it."""

import numpy as np
import pytest

from eventreg_ros import identify, load, simulate
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.errors import EventregError
from eventreg_ros.session.identified import observe
from eventreg_ros.session.identified_scenario import with_identified

UNKNOWN = {'exosystem.tau': 0.06}


@pytest.mark.parametrize(
    ('scenario', 'overrides', 'signal'),
    [
        ('uncontrolled', UNKNOWN, 'w'),
        ('uncontrolled', UNKNOWN, 'y'),
        ('mismatch', UNKNOWN, 'y'),
        ('late', {'exosystem.k': 1, **UNKNOWN}, 'y'),
        ('open', UNKNOWN, 'y'),
        ('uncontrolled', {'plant.k': 0.7, 'plant.tau': 0.13, **UNKNOWN}, 'y'),
        ('mismatch', {'plant.output': 'z', 'controller.excitatory': ['z'], **UNKNOWN}, 'z'),
    ],
)
def test_a_scenario_is_simulated_and_its_plant_known(scenario, overrides, signal):
    found = identify(scenario, overrides, signal=signal)
    assert found.tau == pytest.approx(0.06, rel=1e-5)
    assert found.signal == signal


def bag_of(path, run, time_scale=10.0, text=None, jitter=0.0, skip=()):
    """Write a run as a bag, with jitter (seconds) of the stamps; ``skip`` leaves signals out."""
    random = np.random.default_rng(1)
    signals = {}
    for name, x in run.signals.items():
        late = jitter * random.exponential(size=len(x))
        stamps = np.sort(run.t / time_scale + late) * 1e9
        if name not in skip:
            signals[name] = (stamps.astype(np.int64).tolist(), x)
    write_bag(path, signals, run.scenario.name, text)
    return path


@pytest.fixture(scope='module')
def loop():
    return simulate('mismatch', UNKNOWN, 300.0, sampled=True)


def test_from_y_and_u_of_a_bag_with_jitter(tmp_path, loop):
    text = loop.scenario.to_yaml()
    bag = bag_of(tmp_path / 'bag', loop, text=text, jitter=2e-4, skip=('w',))
    found = identify(bag)
    assert found.signal == 'y'
    assert found.tau == pytest.approx(0.06, rel=1e-4)
    low, high = found.interval(0.99)
    assert low < 0.06 < high


def test_without_a_scenario_the_plant_is_fitted_too(tmp_path):
    run = simulate('uncontrolled', {'plant.k': 0.7, 'plant.tau': 0.13, **UNKNOWN}, 200.0)
    bag = bag_of(tmp_path / 'bag', run, skip=('w',))
    assert identify(bag).tau == pytest.approx(0.06, rel=1e-5)
    wrong = identify(bag, scenario='uncontrolled')  # its plant is another one
    low, high = wrong.interval()
    assert low < 0.06 < high
    assert wrong.residual_rms > 0.1


def test_a_part_of_a_bag(tmp_path, loop):
    bag = bag_of(tmp_path / 'bag', loop, text=loop.scenario.to_yaml())
    assert identify(bag, start=50.0, until=200.0).duration == pytest.approx(150.0)
    with pytest.raises(EventregError, match='too few periods'):
        identify(bag, until=60.0)
    with pytest.raises(EventregError, match='too few periods'):
        identify(bag, start=250.0)


def test_a_gap_of_u_is_not_bridged(tmp_path, loop):
    kept = (loop.t < 80.0) | (loop.t > 100.0)
    signals = {
        name: ((loop.t[where] * 1e8).astype(np.int64).tolist(), loop.signals[name][where])
        for name, where in (('y', slice(None)), ('u', kept))
    }
    write_bag(tmp_path / 'bag', signals, 'mismatch', loop.scenario.to_yaml())
    found = identify(tmp_path / 'bag')
    assert found.duration == pytest.approx(199.9, abs=0.2)
    assert found.tau == pytest.approx(0.06, rel=1e-5)


def test_a_foreign_topic(tmp_path, loop):
    write_bag(
        tmp_path / 'bag',
        {'motor/current': ((loop.t * 1e8).astype(np.int64).tolist(), 3.0 * loop['w'] + 1.0)},
        'none',
        None,
    )
    found = identify(tmp_path / 'bag', topics=['w:=/motor/current'], affine=True)
    assert found.tau == pytest.approx(0.06, rel=1e-6)
    assert (found.gain, found.offset) == pytest.approx((3.0, 1.0))


@pytest.mark.parametrize(
    ('source', 'options', 'reason'),
    [
        ('exact', {'signal': 'q'}, r'no sample of q; the signals are w, y, u'),
        ('linear', {'signal': 'y'}, 'model linear .* record w'),
        ('quiescent', {}, 'shows no spikes'),
        ('two_generators', {'signal': 'y'}, 'not periodic'),
        ('exact', {'topics': ['w:=/x']}, 'belong to a bag'),
        ('nothing', {}, 'neither a bag nor a scenario'),
    ],
)
def test_what_cannot_be_identified(source, options, reason):
    with pytest.raises(EventregError, match=reason):
        identify(source, **options)


@pytest.mark.parametrize(
    ('scenario', 'overrides'),
    [('uncontrolled', UNKNOWN), ('mismatch', {'controller.k': 1, 'exosystem.tau': 0.05})],
)
def test_the_scenario_that_comes_of_it_rejects(scenario, overrides):
    base = load(scenario, overrides)
    before = simulate(base)
    assert before.verdict == 'not rejected'
    made = with_identified(base, identify(base, signal='y'))
    assert simulate(made).verdict == 'rejected'
    assert made.nodes['controller']['k'] == base.nodes.get('controller', {'k': 2.0})['k']
    assert made.nodes['exosystem'] == base.nodes['exosystem']


def test_a_new_controller_fits_the_plant():
    base = load(
        'uncontrolled',
        {'/**.time_scale': 5, '/**.rate': 100, 'plant.output': 'z', **UNKNOWN},
    )
    made = with_identified(base, identify(base, signal='z'))
    assert made.time_scale == 5.0
    assert made.nodes['controller']['excitatory'] == ['z']
    assert np.abs(simulate(made)['z'][-1000:]).max() < 1e-3


def test_without_a_scenario_it_is_exact_with_this_generator():
    made = with_identified(None, identify('uncontrolled', UNKNOWN))
    assert made.nodes['controller']['tau'] == made.nodes['exosystem']['tau']
    assert made.nodes['controller']['tau'] == pytest.approx(0.06)
    assert simulate(made).verdict == 'rejected'


def test_two_generators():
    base = load('two_generators', {'controller.tau': 0.1, 'controller_2.tau': 0.04})
    found = identify(base, generators=2)
    assert [each.tau for each in found.all] == pytest.approx([1 / 19, 1 / 12], rel=1e-6)
    assert [each['tau'] for each in found.to_dict()['others']] == [found.others[0].tau]
    made = with_identified(base, found)
    taus = [made.nodes[node]['tau'] for node in ('controller', 'controller_2')]
    assert taus == pytest.approx([1 / 12, 1 / 19], rel=1e-6)
    assert simulate(made).verdict == 'rejected'
    with pytest.raises(EventregError, match='2 nodes of kind controller, and 1 generator was'):
        with_identified(base, identify('exact'))


def test_controllers_are_added_for_two_generators():
    two = load('two_generators')
    bare = {n: v for n, v in two.given.items() if not n.startswith('controller')}
    bare['plant'] = {n: v for n, v in bare['plant'].items() if n != 'inhibitory'}
    bare['spike_monitor'] = {'signals': ['w', 'y']}
    made = with_identified(type(two).of('bare', bare), identify(two, generators=2))
    assert made.nodes['plant']['inhibitory'] == ['u', 'u_2']
    assert made.criteria.settle == 600.0
    assert simulate(made).verdict == 'rejected'


def test_which_plant_must_be_clear():
    plants = {'plant_left': {}, 'plant_right': {}, 'exosystem': {}}
    base = type(load('exact')).of('two plants', plants)
    with pytest.raises(EventregError, match='2 plants'):
        with_identified(base, identify('exact'))


def test_observe_keeps_what_the_reader_found(tmp_path, loop):
    bag = bag_of(tmp_path / 'bag', loop)
    assert observe(bag).findings == ()
    assert observe(bag).scenario is None
