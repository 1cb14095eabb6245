# SPDX-License-Identifier: Apache-2.0
"""Runs in lanes against runs one by one: the same rows, to the last bit."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.analysis.subject import subject_of
from eventreg_ros.robustness import lane_counts, lane_judge, lane_run
from eventreg_ros.robustness.lane_group import Group, Template
from eventreg_ros.robustness.outcome import Case, one_by_one
from eventreg_ros.scenario import parse
from eventreg_ros.simulation.impairment import PERFECT, Impairment
from eventreg_ros.simulation.lanes import Start
from eventreg_ros.simulation.noise import SILENCE, Noise


def scenario(name, rng):
    """The scenario of that name with random parameters and initial states, 50 steps a second."""
    numbers = {
        'exosystem.tau': 1.0 / rng.uniform(5.0, 30.0),
        'plant.x0': rng.normal(size=1 if name == 'linear' else 2).tolist(),
    }
    if name != 'uncontrolled':
        numbers['controller.tau'] = 1.0 / rng.uniform(5.0, 30.0)
        numbers['controller.k'] = rng.uniform(0.2, 4.0)
    if name == 'linear':
        numbers['controller.gain'] = rng.uniform(-1.0, 3.0, 2).tolist()
        numbers['controller.k_y'] = rng.uniform(-1.0, 3.0)
    if name == 'mismatch':
        numbers['controller.adapt'] = rng.uniform(0.01, 0.1)
    overrides = [f'{key}:={value}' for key, value in numbers.items()]
    return load(name, *overrides, '/**.rate:=50')


def judged(made, **more):
    """What is judged of a scenario, from t = 60 on."""
    subject = subject_of(made, made.loop.signals)
    return replace(subject, criteria=replace(subject.criteria, settle=60.0, **more))


def cases(name, count, impaired, seed, noisy=False):
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        links = Impairment()
        if impaired:
            links = Impairment(
                0.2 * int(rng.integers(0, 4)), rng.uniform(0.0, 0.4), rng.uniform(0.0, 0.5),
                int(rng.integers(0, 3)),
            )  # fmt: skip
        noise = (
            Noise((rng.uniform(0.0, 0.3),), int(rng.integers(0, 2)), ('y',)) if noisy else SILENCE
        )
        made = scenario(name, rng)
        found.append(Case(made.loop, links, judged(made), 250.0, noise))
    return found


def assert_same(lanes, alone):
    reasons = {i: each.reason for i, each in enumerate(alone) if each.reason}
    assert lanes.reasons == reasons
    for a, b in zip(lanes.rows, alone, strict=True):
        assert a.tobytes() == b.row.tobytes(), f'{a} in lanes, {b.row} alone'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'impaired'),
    [('exact', False), ('mismatch', True), ('open', True), ('uncontrolled', False), ('linear', 0)],
)
def test_random_sets_give_the_same_bits_in_lanes(name, impaired):
    pytest.importorskip('numba')
    tried = cases(name, 40, impaired, seed=len(name))
    found = lane_run.run(tried)
    assert_same(found, [one_by_one(case) for case in tried])
    assert len(set(found.rows['verdict'].tolist())) > 1 or name == 'uncontrolled'


@pytest.mark.slow
@pytest.mark.parametrize('name', ['open', 'linear'])
def test_noise_is_the_same_in_lanes(name):
    pytest.importorskip('numba')
    tried = cases(name, 20, False, 7, noisy=True)
    found = lane_run.run(tried)
    assert_same(found, [one_by_one(case) for case in tried])
    quiet = [case._replace(noise=SILENCE) for case in tried]
    assert (lane_run.run(quiet).rows['residual_rms'] != found.rows['residual_rms']).all()


def test_cases_of_several_kinds_come_back_in_their_order():
    pytest.importorskip('numba')
    tried = cases('exact', 3, False, 1) + cases('uncontrolled', 2, False, 2)
    tried.insert(1, cases('exact', 1, False, 3)[0]._replace(duration=120.0))
    tried.insert(3, tried[0]._replace(subject=judged(load('exact'), refractory=3.0)))
    assert_same(lane_run.run(tried), [one_by_one(case) for case in tried])


BANK = """\
/**: {ros__parameters: {rate: 50.0}}
exosystem: {ros__parameters: {}}
exosystem_2: {ros__parameters: {tau: 0.05}}
plant: {ros__parameters: {excitatory: [w, w_2], inhibitory: [u]}}
plant_2: {ros__parameters: {k: 1.5, excitatory: [w, w_2], inhibitory: [u]}}
reference_2: {ros__parameters: {excitatory: [u]}}
controller: {ros__parameters: {k: 1.5, adapt: 0.02}}
"""


@pytest.mark.slow
def test_several_generators_and_plants_are_judged_together():
    pytest.importorskip('numba')
    rng = np.random.default_rng(2)
    found = []
    for _ in range(10):
        made = parse(BANK, 'bank', [f'controller.tau:={rng.uniform(0.04, 0.2)}'])
        found.append(Case(made.loop, Impairment(), judged(made), 250.0))
    assert len(found[0].subject.plants) == 2
    assert_same(lane_run.run(found), [one_by_one(case) for case in found])


def test_a_run_that_diverges_has_the_reason_of_simulate():
    pytest.importorskip('numba')
    wild = load('exact', '/**.rate:=50', 'controller.k:=40')
    tried = [*cases('exact', 2, False, 1), Case(wild.loop, Impairment(), judged(wild), 250.0)]
    found = lane_run.run(tried)
    assert_same(found, [one_by_one(case) for case in tried])
    assert 'stops being finite at t = ' in found.reasons[2]
    assert found.rows['verdict'][2] == 0


def test_more_events_than_there_is_room_for_are_counted_alone(monkeypatch):
    pytest.importorskip('numba')
    tried = cases('exact', 2, False, 1)
    monkeypatch.setattr(lane_judge, 'ROOM', 1)
    monkeypatch.setattr(lane_judge, 'PER_EVENT', 10**9)
    assert_same(lane_run.run(tried), [one_by_one(case) for case in tried])


def test_without_numba_the_rows_are_the_same(monkeypatch):
    pytest.importorskip('numba')
    tried = cases('exact', 3, False, 4)
    quick = lane_run.run(tried)
    monkeypatch.setattr(lane_run, 'compiles', lambda: False)
    slow = lane_run.run(tried)
    assert slow.rows.tobytes() == quick.rows.tobytes()


@pytest.mark.parametrize('count', [1, 7, 8, 100, 128, 129, 1000, 5678])
def test_the_sum_in_lanes_is_numpys(count):
    def total(numbers):
        parts = []
        for start, size, joins in lane_counts.halves(0, len(numbers)):
            parts.append(numbers[start : start + size].sum())
            for _ in range(joins):
                last = parts.pop()
                parts[-1] += last
        return parts.pop()

    numbers = np.random.default_rng(count).random(count)
    assert total(numbers) == numbers.sum()


@pytest.mark.slow
def test_a_group_that_was_run_goes_at_once():
    """It holds tens of megabytes, and a sweep makes one after the other."""
    case = cases('exact', 1, False, 1)[0]
    start = Start.of([list(case.loop.blocks.values())] * 2)
    group = Group(Template(case.loop, case.subject, case.duration), start, [PERFECT], [SILENCE])
    gc.disable()
    try:
        found = group.run(np.arange(2))
        last = weakref.ref(group)
        del group
        assert last() is None
    finally:
        gc.enable()
    assert found.holds.all()
