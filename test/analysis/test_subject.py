# SPDX-License-Identifier: Apache-2.0
"""What is judged, derived from scenarios: wiring, names, links, other packages, namespaces."""

import pytest

from eventreg_ros.analysis.subject import JudgedPlant, subject_by_name, subject_of
from eventreg_ros.scenario import Criteria, load, parse

TWO_PLANTS = """\
exosystem_left: {ros__parameters: {}}
exosystem_right: {ros__parameters: {}}
plant_left: {ros__parameters: {excitatory: [w_left, v], inhibitory: [u_left]}}
plant_right: {ros__parameters: {excitatory: [w_right], inhibitory: [u_right]}}
controller_left: {ros__parameters: {excitatory: [y_left], inhibitory: [y_r_left]}}
controller_right: {ros__parameters: {excitatory: [y_right], inhibitory: []}}
reference_left: {ros__parameters: {}}
stimulus: {ros__parameters: {}}
"""


def plants(text, signals=()):
    return subject_of(parse(text, 'made'), signals).plants


@pytest.mark.parametrize(
    ('name', 'plant'),
    [
        ('exact', JudgedPlant('y', None, ('w',), ('u',))),
        ('open', JudgedPlant('y', 'y_r', ('w',), ('u',), ('v',))),
        ('uncontrolled', JudgedPlant('y', None, ('w',))),
        ('quiescent', JudgedPlant('y', None, (), ('u',))),
    ],
)
def test_the_papers_loops(name, plant):
    subject = subject_of(load(name))
    assert subject.plants == (plant,)
    assert (subject.scenario, subject.time_scale, subject.duration) == (name, 10.0, None)


def test_the_criteria_are_the_scenarios():
    assert subject_of(load('linear')).criteria == Criteria(0.5)


def test_several_plants_each_with_what_reaches_it():
    assert plants(TWO_PLANTS) == (
        JudgedPlant('y_left', 'y_r_left', ('w_left',), ('u_left',), ('v',)),
        JudgedPlant('y_right', None, ('w_right',), ('u_right',)),
    )


def test_a_single_plant_has_all_exosystems_and_controllers():
    text = (
        'exosystem: {ros__parameters: {}}\nexosystem_2: {ros__parameters: {}}\n'
        'controller_b: {ros__parameters: {}}\nplant: {ros__parameters: {}}\n'
    )
    assert plants(text) == (JudgedPlant('y', None, ('w', 'w_2'), ('u_b',)),)


def test_what_reaches_a_plant_through_links_and_other_blocks_reaches_it():
    text = TWO_PLANTS.replace('[w_left, v]', '[felt, v]').replace('[u_right]', '[u_late]')
    text += (
        'link_u: {ros__parameters: {input: u_right, output: u_late}}\n'
        'sensor: {ros__parameters: {package: mine, executable: sense, excitatory: [w_late], '
        'output: felt}}\n'
        'link_w: {ros__parameters: {input: w_left, output: w_late}}\n'
    )
    assert plants(text) == plants(TWO_PLANTS)


def test_blocks_that_hear_each_other_come_to_an_end():
    text = (
        'plant_a: {ros__parameters: {excitatory: [x]}}\nplant_b: {ros__parameters: {}}\n'
        'one: {ros__parameters: {package: p, executable: e, excitatory: [z, w], output: x}}\n'
        'two: {ros__parameters: {package: p, executable: e, excitatory: [x], output: z}}\n'
        'exosystem: {ros__parameters: {}}\n'
    )
    assert [plant.disturbances for plant in plants(text)] == [('w',), ('w',)]


def test_a_plant_of_another_package_is_judged_like_ours():
    text = (
        'exosystem: {ros__parameters: {}}\n'
        'plant: {ros__parameters: {package: mine, executable: tank, output: level}}\n'
    )
    assert plants(text) == (JudgedPlant('level', None, ('w',)),)


def test_namespaces_keep_two_robots_apart():
    one = ''.join(
        f'/{robot}/{node}: {{ros__parameters: {{}}}}\n'
        for robot in ('r1', 'r2')
        for node in ('exosystem', 'plant', 'controller')
    )
    text = one + '/r2/reference: {ros__parameters: {}}\n'
    assert plants(text) == (
        JudgedPlant('r1/y', None, ('r1/w',), ('r1/u',)),
        JudgedPlant('r2/y', 'r2/y_r', ('r2/w',), ('r2/u',)),
    )


def test_signals_from_outside_of_the_scenario_play_their_part_by_name():
    text = 'plant: {ros__parameters: {}}\n'
    assert plants(text) == (JudgedPlant('y'),)
    there = ['w', 'y', 'y_r', 'u', 'v', 'w_2']
    assert plants(text, there) == (JudgedPlant('y', 'y_r', ('w',), ('u',), ('v',)),)
    machine = 'controller: {ros__parameters: {}}\n'  # exosystem and plant are a real machine's
    assert plants(machine, ['w', 'y', 'u']) == (JudgedPlant('y', None, ('w',), ('u',)),)


def test_the_clock_of_a_scenario_says_how_long_a_run_should_take():
    text = 'plant: {ros__parameters: {rate: 50}}\nclock: {ros__parameters: {steps: 1500}}\n'
    assert subject_of(parse(text, 'made')).duration == 300.0
    assert subject_of(parse(text.replace('1500', '0'), 'made')).duration is None


# By name ------------------------------------------------------------------------------------------


def test_without_a_scenario_names_decide():
    subject = subject_by_name(['u', 'w_2', 'y_r', 'x', 'y', 'w', 'u_b', 'w_link'], Criteria(2.0))
    assert subject.plants == (JudgedPlant('y', 'y_r', ('w', 'w_2'), ('u', 'u_b')),)
    assert (subject.criteria, subject.time_scale) == (Criteria(2.0), 10.0)
    assert subject.needed == ['w', 'w_2', 'y', 'y_r']


def test_without_a_y_those_with_a_suffix_are_judged():
    assert subject_by_name(['y_left', 'y_right', 'y_r_left', 'w']).plants == (
        JudgedPlant('y_left', 'y_r_left', ('w',)),
        JudgedPlant('y_right', None, ('w',)),
    )
    assert subject_by_name(['y_r', 'w']).plants == ()
