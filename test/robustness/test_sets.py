# SPDX-License-Identifier: Apache-2.0
"""Sets of a plan: the quick way and the slow one, and both against simulate."""

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.api import judge
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.outcome import VERDICTS
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets
from eventreg_ros.robustness.yields import scenario_text
from eventreg_ros.scenario import parse

QUICK = {'duration': 250.0, 'settle': 60.0}


def sets_of(name, *parameters, count=16, **more):
    plan = Plan.of(load(name), [*parameters, '/**.rate:=50'], sets=count, **QUICK, **more)
    return Sets(plan), plan.design.columns(0, count)


@pytest.mark.parametrize(
    ('name', 'parameters'),
    [
        ('exact', ['controller.k:=0.3..4', 'controller.tau:=0.08~30%', 'plant.x0[1]:=-1..1']),
        ('exact', ['/**.k:=0.3..4', 'plant.k:=1..2', 'links.delay:={0,0.2}', 'links.loss:=0..0.4']),
        ('unknown', ['controller.k:=0.5..3', 'exosystem.tau:=1/14..1/9', 'plant.k:=0.8..1.4']),
        ('linear', ['controller.gain[1]:=-2..2', 'controller.k_y:=-1..3', 'exosystem.x0[0]:=0..2']),
    ],
)
def test_the_quick_way_gives_the_bits_of_the_slow_one(name, parameters):
    pytest.importorskip('numba')
    sets, columns = sets_of(name, *parameters)
    assert sets._places is not None
    quick = sets.run(columns)
    sets._places = None
    slow = sets.run(columns)
    assert quick.rows.tobytes() == slow.rows.tobytes()
    assert quick.reasons == slow.reasons == {}


@pytest.mark.parametrize('quick', [True, False])
def test_what_is_fixed_after_a_wildcard_counts(quick):
    sets, columns = sets_of('exact', '/**.k:=0.3..0.6', 'controller.k:=3', count=2)
    if not quick:
        sets._places = None
    rows = sets.run(columns).rows
    for k, size in zip(columns[0], rows['residual_max_abs'], strict=True):
        scenario = load('exact', '/**.rate:=50', f'/**.k:={k}', 'controller.k:=3')
        run = simulate(scenario, 250.0, sampled=True)
        assert judge(run, 60.0).residual.max_abs == size


def test_a_fixed_entry_of_a_list_is_no_axis():
    plan = Plan.of(load('exact'), ['plant.x0[1]:=0.3', 'plant.k:={1,2}'])
    assert [axis.name for axis in plan.axes] == ['plant.k']
    assert plan.scenario.nodes['plant']['x0'] == [0.0, 0.3]


def test_a_row_is_what_simulate_says():
    sets, columns = sets_of(
        'mismatch', 'controller.k:=0.5..3', 'links.delay:=0..0.6', 'links.seed:={3,4}',
        'links.loss:=0..0.3', 'plant.hold:={zero,linear}', count=6, on=('u',),
    )  # fmt: skip
    rows = sets.run(columns).rows
    for i, (k, delay, seed, loss, hold) in enumerate(zip(*columns, strict=True)):
        scenario = load('mismatch', '/**.rate:=50', f'controller.k:={k}', f'plant.hold:={hold}')
        run = simulate(
            scenario, 250.0, sampled=True, delay=delay, loss=loss, seed=int(seed), on=['u']
        )
        report = judge(run, 60.0)
        assert VERDICTS[rows['verdict'][i]] == report.verdict
        assert rows['residual_rms'][i] == report.residual.rms
        assert rows['residual_max_abs'][i] == report.residual.max_abs
        assert rows['spurious'][i] == report.rejection.spurious


@pytest.mark.parametrize(
    ('parameters', 'settle'),
    [
        (['/**.rate:={1.5,4,50}', 'controller.k:={0.7,3}'], None),
        (['exosystem.tau:={0.1,0.5}', 'exosystem.k:={8,20}', '/**.rate:=12'], 60.0),
        (
            [
                'exosystem.x0[0]:={0,0.5,3}',
                'exosystem.x0[2]:={0,2}',
                'exosystem.k:=0',
                '/**.rate:=50',
            ],
            60.0,
        ),
        (['spike_monitor.refractory:={0,40}', 'controller.k:={0.5,2}', '/**.rate:=50'], 60.0),
    ],
)
def test_what_is_sampled_too_thinly_is_undecided_as_in_simulate(parameters, settle):
    scenario = load('mismatch')
    plan = Plan.of(scenario, parameters, duration=250.0, settle=settle)
    sets, columns = Sets(plan), plan.design.columns(0, plan.design.count)
    found = sets.run(columns)
    for i, values in enumerate(zip(*columns, strict=True)):
        if i in found.reasons:
            with pytest.raises(EventregError):
                simulate(sets.scenario(values), 250.0, sampled=True)
            continue
        report = judge(simulate(sets.scenario(values), 250.0, sampled=True), settle)
        assert VERDICTS[found.rows['verdict'][i]] == report.verdict, values


TWO_PLANTS = """
/**: {ros__parameters: {rate: 50.0}}
exosystem: {ros__parameters: {}}
plant: {ros__parameters: {inhibitory: [u]}}
plant_b: {ros__parameters: {excitatory: [w], output: y_b}}
controller: {ros__parameters: {k: 1.5, excitatory: [y]}}
"""


@pytest.mark.parametrize('links', [(), ('links.delay:=0.2',), ('links.loss:=0..0.3',)])
@pytest.mark.parametrize('seeds', [(), ('links.seed:={0,3}',)])
def test_noise_is_that_of_simulate(links, seeds):
    asked = ['noise.y:=0..0.3', 'controller.k:=0.5..3', *links, *seeds]
    sets, columns = sets_of('mismatch', *asked, count=6)
    rows = sets.run(columns).rows
    for i, values in enumerate(zip(*columns, strict=True)):
        of = dict(zip([axis.name for axis in sets.axes], values, strict=True))
        run = simulate(
            load('mismatch', '/**.rate:=50', {'controller.k': of['controller.k']}), 250.0,
            sampled=True, noise=of['noise.y'], seed=int(of.get('links.seed', 0)),
            delay=0.2 if 'links.delay:=0.2' in links else 0.0, loss=of.get('links.loss', 0.0),
        )  # fmt: skip
        report = judge(run, 60.0)
        assert VERDICTS[rows['verdict'][i]] == report.verdict
        assert rows['spurious'][i] == report.rejection.spurious
        assert (rows['residual_max_abs'][i], rows['residual_rms'][i]) == report.residual


def test_every_plant_has_noise_of_its_own_as_in_simulate():
    scenario = parse(TWO_PLANTS, 'two')
    plan = Plan.of(scenario, ['noise.y:={0,0.1}', 'noise.y_b:={0.1}', 'links.seed:=5'], **QUICK)
    rows = Sets(plan).run(plan.design.columns(0, 2)).rows
    reports = [judge(simulate(scenario, 250.0, sampled=True, noise=0.1, seed=5), 60.0)]
    assert rows['residual_rms'][1] == reports[0].residual.rms
    assert rows['residual_rms'][0] != rows['residual_rms'][1]


@pytest.mark.parametrize(
    ('parameter', 'words'),
    [
        ('noise.w:=0..1/2', "'w' is none; it has y"),
        ('noise.y:=-1', 'noise must be >= 0 and finite, got -1'),
        ('noise.y:=loud', "noise.y is a number, got 'loud'"),
        ('links.loss:={0,few}', 'links.loss is a number'),
        ('links.delay[0]:=1', r'leave out \[0\]'),
    ],
)
def test_noise_and_links_that_cannot_be(parameter, words):
    with pytest.raises(EventregError, match=words):
        Plan.of(load('exact'), [parameter], **QUICK)


@pytest.mark.parametrize('slow', [False, True])
def test_bad_sets_are_rows_with_their_reason(slow):
    pytest.importorskip('numba')
    plan = Plan.of(
        load('exact'), ['controller.k:={-1,2,60}', 'links.loss:={0.5,2}', '/**.rate:=50'], **QUICK
    )
    sets = Sets(plan)
    if slow:
        sets._places = None
    found = sets.run(plan.design.columns(0, 6))
    assert found.reasons[0] == 'controller.k must be a finite number >= 0, got -1.0'
    assert found.reasons[3] == 'loss must be >= 0 and <= 1, got 2.0'
    assert 'stops being finite at t = ' in found.reasons[4]
    assert set(found.reasons) == {0, 1, 3, 4, 5}
    assert (found.rows['verdict'] > 0).tolist() == [False, False, True, False, False, False]


def test_bad_noise_is_a_row_with_its_reason():
    plan = Plan.of(load('exact'), ['noise.y:={-1,0.1}', '/**.rate:=50'], **QUICK)
    found = Sets(plan).run(plan.design.columns(0, 2))
    assert found.reasons == {0: 'noise must be >= 0 and finite, got -1.0'}
    assert (found.rows['verdict'] > 0).tolist() == [False, True]


def test_a_set_with_noise_as_a_scenario_says_how_it_is_simulated():
    plan = Plan.of(load('exact'), ['noise.y:={0.1}', 'links.seed:=4'], **QUICK)
    first = scenario_text(plan, [0.1]).splitlines()[0]
    assert first.endswith('--settle 60.0 --seed 4 --noise 0.1')


@pytest.mark.parametrize(
    ('ranges', 'on', 'command'),
    [
        (['controller.k:={2}'], None, '--duration 25.0 --lockstep --settle 60.0'),
        (
            ['links.delay:={0.29}'], ('u', 'y'),
            '--duration 25.0 --lockstep --link u:delay=0.03 --link y:delay=0.03 --settle 60.0',
        ),
        (
            ['links.jitter:={0.2}', 'links.loss:=0.1', 'links.seed:=3'], ('u',),
            '--duration 25.0 --link u:loss=0.1,jitter=0.02,seed=3 --settle 60.0',
        ),
    ],
)  # fmt: skip
def test_a_set_as_a_scenario_says_how_it_is_run_as_nodes(ranges, on, command):
    plan = Plan.of(load('exact', {'/**.rate': 100}), ranges, on=on, **QUICK)
    values = [axis.values[0] for axis in plan.axes]
    second = scenario_text(plan, values).splitlines()[1]
    assert second == f'# eventreg run THIS.yaml {command}'


def test_a_set_as_a_scenario_is_the_same_set():
    sets, columns = sets_of('exact', 'controller.k:=0.3..1', 'exosystem.x0[2]:=-2..0', count=3)
    text = scenario_text(sets.plan, [column[1] for column in columns])
    assert text.startswith('# eventreg simulate THIS.yaml --sampled --duration 250.0 --settle 60')
    again = Sets(Plan.of(parse(text, 'exact'), ['links.seed:=0'], **QUICK)).run([])
    assert again.rows[0].tobytes() == sets.run(columns).rows[1].tobytes()


@pytest.mark.parametrize('quick', [True, False])
@pytest.mark.parametrize(
    'parameters',
    [
        ['plant.tau:={-1,1}', 'plant.k:={-2,1}', 'exosystem.tau:={-1,1}', 'links.seed:={0.5,1}'],
        ['/**.k:={-1,1}', 'exosystem.k:={1,2}', 'links.loss:={2,0}'],
        ['controller.tau:={-1,1}', 'links.delay:={-1,0}', 'plant.x0[1]:={0,1}'],
    ],
)
def test_a_set_with_several_faults_has_the_reason_of_simulate(parameters, quick):
    plan = Plan.of(load('exact'), parameters, **QUICK)
    sets = Sets(plan)
    if not quick:
        sets._places = None
    columns = plan.design.columns(0, 2)
    values = [column[0] for column in columns]
    with pytest.raises(EventregError) as expected:
        load('exact', {
            axis.name: value
            for axis, value in zip(plan.axes, values, strict=True)
            if not axis.of_run and axis.index is None
        })  # fmt: skip
    assert sets.run([column[:1] for column in columns]).reasons == {0: str(expected.value)}


def test_sets_that_cannot_be():
    plan = Plan.of(load('exact'), ['links.seed:={0.5,1}'], **QUICK)
    reasons = Sets(plan).run(plan.design.columns(0, 2)).reasons
    assert reasons == {0: 'links.seed must be a whole number, got 0.5'}


@pytest.mark.parametrize(
    ('parameter', 'words'),
    [('plnt.k:=1..2/2', "no node 'plnt'"), ('plant.x0[7]:=1..2/2', 'count from 0')],
)
def test_what_is_not_there_is_refused_at_once(parameter, words):
    with pytest.raises(EventregError, match=words):
        Plan.of(load('exact'), [parameter])


def test_the_border_of_the_fixed_controller_is_where_it_was_computed_apart():
    """T 600, settle 100, steps of 0.25 of 1/tau_w in 6..25: docs of the adaptive controller."""
    pytest.importorskip('numba')
    grid = np.arange(6.0, 25.01, 0.25)
    for k, low, high in ((0.7, 9.25, 13.25), (1.0, 6.75, 15.0)):
        values = ','.join(repr(1.0 / value) for value in grid.tolist())
        plan = Plan.of(
            load('exact'), [f'exosystem.tau:={{{values}}}', f'controller.k:={k}'], duration=600.0
        )
        verdicts = Sets(plan).run(plan.design.columns(0, len(grid))).rows['verdict']
        assert grid[verdicts == 1].tolist() == np.arange(low, high + 0.01, 0.25).tolist()
