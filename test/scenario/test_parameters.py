# SPDX-License-Identifier: Apache-2.0
"""The table of parameters: every rule, every error."""

import array
import math

import numpy as np
import pytest

from eventreg_ros.errors import EventregError, ParameterError, shown
from eventreg_ros.scenario.names import KINDS
from eventreg_ros.scenario.parameter import Parameter
from eventreg_ros.scenario.parameters import is_ros_parameter, parameters_of, resolve

BLOCKS = ('exosystem', 'plant', 'controller', 'reference')

# CONTRACT.md, "Nodes": the parameters of the four blocks, then those of the other nodes.
BLOCK_TYPES = {
    'model': 'string', 'k': 'double', 'tau': 'double', 'gain': 'double[]', 'k_y': 'double',
    'x0': 'double[]', 'excitatory': 'string[]', 'inhibitory': 'string[]', 'output': 'string',
    'rate': 'double', 'time_scale': 'double', 'hold': 'string', 'input_timeout': 'double',
    'lockstep': 'bool', 'autostart': 'bool',
}  # fmt: skip
OTHER_TYPES = {
    'stimulus': {
        'waveform': 'string', 'amplitude': 'double', 'offset': 'double', 'period': 'double',
        'phase': 'double', 'onsets': 'double[]', 'width': 'double', 'file': 'string',
    },
    'spike_monitor': {'signals': 'string[]', 'threshold': 'double', 'reset': 'double'},
    'recorder': {'signals': 'string[]', 'path': 'string', 'storage': 'string'},
}  # fmt: skip

# CONTRACT.md: per role, and the default initial states.
DEFAULTS = {
    'exosystem': ('oscillator', [], [], 'w', [1.0, 0.0, -1.0, 0.0]),
    'plant': ('neuron', ['w', 'v'], ['u'], 'y', [0.0, 0.0]),
    'controller': ('oscillator', ['y'], ['y_r'], 'u', [0.5, 0.0, -0.5, 0.0]),
    'reference': ('neuron', ['v'], [], 'y_r', [0.0, 0.0]),
}

WRONG = {
    'bool': [1, 'true', None, [True]],
    'int': [True, 1.0, '1', None, [1]],
    'double': [True, '1.0', None, [1.0], {}, math.nan, math.inf, -math.inf, 10**400],
    'string': [1, True, None, ['w'], b'w'],
    'double[]': [1.0, 'abc', b'ab', [True], ['1'], [math.nan], [1.0, None], {1.0: 2.0}],
    'string[]': ['w', b'w', [1], [True], [['w']]],
}

NODES = {kind: tuple(parameters_of(kind).values()) for kind in KINDS}
EVERY = [(node, p) for node, table in NODES.items() for p in table]
IDS = [f'{node}.{p.name}' for node, p in EVERY]


def refused(parameter, value, where='here'):
    """Return the message with which ``value`` is refused; it is one line."""
    with pytest.raises(ParameterError) as caught:
        parameter.check(where, value)
    message = str(caught.value)
    assert '\n' not in message
    return message


def complaint(node, **given):
    with pytest.raises(ParameterError) as caught:
        resolve(node, given)
    message = str(caught.value)
    assert '\n' not in message
    return message


def test_the_table_is_the_contract():
    for node in BLOCKS:
        assert {p.name: p.type for p in NODES[node]}.items() >= BLOCK_TYPES.items()
    for node, types in OTHER_TYPES.items():
        assert {p.name: p.type for p in NODES[node]}.items() >= types.items()
    for node in BLOCKS:
        values = resolve(node, {})
        assert (
            values['model'], values['excitatory'], values['inhibitory'], values['output'],
            values['x0'],
        ) == DEFAULTS[node]  # fmt: skip
        assert (values['rate'], values['time_scale'], values['input_timeout']) == (200, 10, 0.5)
        assert (values['autostart'], values['lockstep']) == (True, False)
        assert values['k_y'] == 0.0
    values = resolve('controller', {})
    assert (values['adapt'], values['tau_min'], values['tau_max']) == (0.0, 0.02, 1.5)
    monitor = resolve('spike_monitor', {})
    assert (monitor['threshold'], monitor['reset']) == (1.0, 0.0)
    tables = {p.name: p for p in NODES['plant']}
    assert tables['model'].choices()[:3] == ('neuron', 'oscillator', 'linear')
    assert set(tables['hold'].choices) == {'zero', 'linear'}
    assert {p.name: p for p in NODES['recorder']}['storage'].choices == ('mcap', 'sqlite3')
    waveforms = {p.name: p for p in NODES['stimulus']}['waveform'].choices
    assert set(waveforms) == {'constant', 'sine', 'square', 'pulses', 'csv'}


def test_what_may_be_set_while_running_is_the_contract_and_what_only_warns():
    for node in BLOCKS:
        margins = {'delay_margin', 'delay_margin_zero', 'delay_warn'}
        live = {p.name for p in NODES[node] if p.settable == 'active'}
        learning = {'adapt', 'tau_min', 'tau_max'} if node == 'controller' else set()
        limits = {'input_limit', 'output_limit', 'recover'}
        assert live == {'k', 'tau', 'gain', 'time_scale', *limits, *margins, *learning}


@pytest.mark.parametrize(('node', 'parameter'), EVERY, ids=IDS)
def test_every_parameter_has_a_meaning_and_a_default_that_it_allows(node, parameter):
    assert parameter.doc
    if parameter.default not in ('', []):
        assert parameter.check(node, parameter.default) == parameter.default


@pytest.mark.parametrize(('node', 'parameter'), EVERY, ids=IDS)
def test_every_parameter_refuses_wrong_types_in_one_line(node, parameter):
    for value in WRONG[parameter.type]:
        message = refused(parameter, value, node)
        assert message.startswith(f'{node}.{parameter.name} must be {parameter.rule}, got ')
        assert shown(value) in message


@pytest.mark.parametrize(('node', 'parameter'), EVERY, ids=IDS)
def test_every_bound_is_kept(node, parameter):
    def beside(bound, towards):
        if parameter.type == 'int':
            return int(bound) + (1 if towards > 0 else -1)
        return math.nextafter(bound, towards)

    kind = int if parameter.type == 'int' else float
    if parameter.low is not None:
        inside, low = beside(parameter.low, math.inf), kind(parameter.low)
        assert parameter.check(node, inside) == inside
        refused(parameter, beside(low, -math.inf))
        if parameter.open_low:
            refused(parameter, low)
        else:
            assert parameter.check(node, low) == low
    if parameter.high is not None:
        high = kind(parameter.high)
        assert parameter.check(node, high) == high
        refused(parameter, beside(high, math.inf))


def test_the_bounds_are_the_contract():
    table = {p.name: p for p in NODES['plant']}
    assert table['k'].check('plant', 0) == 0.0
    assert 'must be a finite number >= 0, got -0.5' in refused(table['k'], -0.5)
    assert 'must be a finite number > 0, got 0.0' in refused(table['tau'], 0.0)
    for name in ('tau', 'rate', 'time_scale', 'input_timeout'):
        refused(table[name], 0)


@pytest.mark.parametrize(('node', 'parameter'), EVERY, ids=IDS)
def test_choices_are_kept_and_named(node, parameter):
    choices = parameter.choices() if callable(parameter.choices) else parameter.choices
    for choice in choices:
        assert parameter.check(node, choice) == choice
    if choices:
        message = refused(parameter, 'something else')
        assert all(choice in message for choice in choices)


def test_length():
    gain = next(p for p in NODES['controller'] if p.name == 'gain')
    assert gain.check('controller', [1, 0]) == [1.0, 0.0]
    for value in ([], [1.0], [1.0, 2.0, 3.0]):
        assert 'of length 2' in refused(gain, value)


@pytest.mark.parametrize(
    ('parameter', 'rule'),
    [
        (Parameter('a', 'double', 0.0, ''), 'a finite number'),
        (Parameter('a', 'double', 0.0, '', low=0.0), 'a finite number >= 0'),
        (Parameter('a', 'double', 1.0, '', low=0.0, open_low=True), 'a finite number > 0'),
        (Parameter('a', 'double', 1.0, '', low=0, high=2.5), 'a finite number >= 0 and <= 2.5'),
        (Parameter('a', 'double', 1.0, '', high=2.0), 'a finite number <= 2'),
        (Parameter('a', 'int', 1, '', low=1), 'a whole number >= 1'),
        (Parameter('a', 'string', 'b', '', choices=('b', 'c')), 'one of b, c'),
        (Parameter('a', 'bool', True, ''), 'true or false'),
        (Parameter('a', 'double[]', [], '', length=2), 'a list of finite numbers of length 2'),
        (Parameter('a', 'string[]', [], '', most=9), 'a list of at most 9 strings'),
    ],
)
def test_rules_in_words(parameter, rule):
    assert parameter.rule == rule


def test_whole_numbers_count_as_doubles_and_stay_nothing_else():
    values = resolve('plant', {'k': 2, 'x0': [1, 0]})
    assert (values['k'], values['x0']) == (2.0, [1.0, 0.0])
    assert {type(v) for v in (values['k'], *values['x0'])} == {float}
    assert Parameter('n', 'int', 1, '').check('a', 3) == 3


def test_arrays_that_rclpy_hands_over_become_lists():
    values = resolve('plant', {'x0': array.array('d', [1.0, 2.0]), 'excitatory': ('w',)})
    assert (values['x0'], values['excitatory']) == ([1.0, 2.0], ['w'])
    assert resolve('plant', {'x0': np.array([1.0, 2.0])})['x0'] == [1.0, 2.0]


def test_a_list_that_holds_an_empty_string_is_ros_for_an_empty_list():
    assert resolve('plant', {'excitatory': ['']})['excitatory'] == []


def test_the_hint_to_quote_comes_where_it_helps():
    for message in (
        complaint('spike_monitor', signals=['w', True]),
        complaint('plant', output=True),
        complaint('plant', inhibitory=[False]),
    ):
        assert "quote words that YAML takes for true or false, like 'y'" in message
    for message in (complaint('plant', k=True), complaint('plant', output=1)):
        assert 'quote' not in message


@pytest.mark.parametrize('node', NODES)
def test_unknown_parameters_are_named_with_the_nearest(node):
    assert f'{node} has no parameter ' in complaint(node, nonsense=1)
    assert "did you mean 'autostart'?" in complaint(node, autostrat=True)
    message = complaint(node, qqqq=1)
    assert all(parameter.name in message for parameter in NODES[node])


def test_parameters_of_ros_pass_unchecked():
    given = {'use_sim_time': True, 'qos_overrides./w.publisher.depth': 3}
    assert all(is_ros_parameter(name) for name in given)
    assert given.keys().isdisjoint(resolve('plant', given))
    assert not is_ros_parameter('qos')


def test_the_initial_state_fits_the_model():
    assert resolve('controller', {'model': 'neuron'})['x0'] == [0.5, 0.0]
    assert resolve('exosystem', {'model': 'linear'})['x0'] == [1.0, 0.0]
    assert resolve('plant', {'model': 'linear'})['x0'] == [0.0]
    assert resolve('controller', {'model': 'linear'})['x0'] == [0.0, 0.0]
    assert resolve('plant', {'x0': []})['x0'] == [0.0, 0.0]
    message = complaint('plant', x0=[1.0, 2.0, 3.0])
    assert message == 'plant.x0 must have 2 numbers for model neuron, got [1.0, 2.0, 3.0]'
    assert 'must have 4 numbers for model oscillator' in complaint('controller', x0=[1.0])
    assert 'must have 1 numbers for model linear' in complaint('plant', model='linear', x0=[1, 2])


@pytest.mark.parametrize(
    'bad', ['', ' ', 'a b', '1w', 'w-u', 'w//y', 'w/', '~w', 'w\n', '{w}', '/w']
)
def test_signals_are_names_of_topics(bad):
    if bad:
        for name in ('excitatory', 'inhibitory'):
            message = complaint('plant', **{name: [bad]})
            assert message.startswith(f'plant.{name} must name relative topics')
            assert repr(bad) in message
        assert repr(bad) in complaint('spike_monitor', signals=[bad])
    assert complaint('plant', output=bad).startswith('plant.output must name relative topics')
    resolve('plant', {'output': 'robot_1/y'})


def test_signals_of_a_block_differ():
    for given in (
        {'excitatory': ['w'], 'inhibitory': ['w']},
        {'excitatory': ['w', 'w']},
        {'output': 'u'},
        {'excitatory': ['y']},
    ):
        assert 'must name different signals' in complaint('plant', **given)


def test_values_that_must_fit_each_other():
    message = complaint('spike_monitor', threshold=0.0)
    assert message == 'spike_monitor.reset must be < threshold (0), got 0'
    assert complaint('spike_monitor', reset=2).endswith('threshold (1), got 2')
    assert complaint('stimulus', waveform='csv').startswith('stimulus.file must name a csv file')
    resolve('stimulus', {'waveform': 'csv', 'file': 'v.csv'})


@pytest.mark.parametrize('node', NODES)
def test_a_change_to_the_values_leaves_the_table_alone(node):
    before = repr(resolve(node, {}))
    for value in resolve(node, {}).values():
        if isinstance(value, list):
            value.append('changed')
    assert repr(resolve(node, {})) == before


def test_parameter_errors_are_bad_input():
    assert issubclass(ParameterError, EventregError)


def test_a_model_that_is_not_there_is_named_before_its_parameters():
    with pytest.raises(ParameterError, match=r"exosystem\.model must be .* got 'nowhere'"):
        resolve('exosystem', {'mu': 3.0, 'model': 'nowhere'})
