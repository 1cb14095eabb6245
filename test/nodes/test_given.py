# SPDX-License-Identifier: Apache-2.0
"""What a node is given, as people and their tools write it, and what it takes of it."""

import os
from functools import partial
from pathlib import Path

import pytest
import yaml

from eventreg_ros.errors import EventregError
from eventreg_ros.nodes.composed import make
from eventreg_ros.nodes.declare import fitted
from eventreg_ros.nodes.given import as_meant
from eventreg_ros.nodes.stimulus import StimulusNode
from eventreg_ros.scenario import parse
from eventreg_ros.scenario.parameters import parameters_of


@pytest.fixture
def file(tmp_path):
    """Write a parameter file and return the arguments that name it."""

    def write(text):
        path = tmp_path / 'parameters.yaml'
        path.write_text(text)
        return ['--params-file', str(path)]

    return write


def launched(node, parameters):
    """A dictionary of parameters, as launch_ros writes it for Node(parameters=[...])."""
    return yaml.dump({f'/**/{node}': {'ros__parameters': parameters}}, default_flow_style=False)


def test_dictionaries_of_a_launch_file_name_the_signal_y(bench, file):
    """PyYAML, which writes them, leaves y unquoted, and rcl takes that for true."""
    text = launched('plant', {'output': 'y', 'lockstep': False})
    assert 'output: y\n' in text
    plant = bench.add(partial(make, 'plant'), arguments=file(text), start=False)
    assert plant.values['output'] == 'y'
    assert parse(text, 'mine').nodes['plant']['output'] == 'y'
    text = launched('spike_monitor', {'signals': ['w', 'y', 'u']})
    assert '- y\n' in text
    monitor = bench.add(partial(make, 'spike_monitor'), arguments=file(text), start=False)
    assert monitor.values['signals'] == ['w', 'y', 'u']


def test_what_ros2_param_dump_writes_can_be_read_again(bench, file):
    first = bench.add(partial(make, 'plant'), 'k:=2.5', 'qos_overrides./y.publisher.depth:=7')
    values = {name: p.value for name, p in first._parameters.items()}
    nested = {k: list(v) if hasattr(v, 'tolist') else v for k, v in values.items()}
    text = yaml.dump({'/plant': {'ros__parameters': nested}}, default_flow_style=False)
    assert 'output: y\n' in text
    again = bench.add(partial(make, 'plant'), arguments=file(text), start=False)
    assert again.values == first.values


def test_a_command_line_names_the_signal_y(bench):
    plant = bench.add(
        partial(make, 'plant'), 'output:=y', 'inhibitory:=[u, n]', 'lockstep:=n', start=False
    )
    assert (plant.values['output'], plant.values['inhibitory']) == ('y', ['u', 'n'])
    assert plant.values['lockstep'] is False


@pytest.mark.parametrize(
    ('rule', 'meant'),
    [
        ('output:=y', "output:='y'"),
        ('plant:output:=y', "plant:output:='y'"),
        ('signals:=[w, y,y_r, Y]', "signals:=[w, 'y',y_r, 'Y']"),
        ('signals:=[\'y\', "n", yy]', None),
        ('output:=yes', None),
        ('lockstep:=y', None),
        ('output:=!!str y', None),
        ('signals:=[w, [y', None),
        ('output:=', None),
        ('y', None),
    ],
)
def test_only_signals_are_quoted(rule, meant):
    with as_meant(['plant', '--ros-args', '-p', rule, '--', '-p', 'output:=y']) as arguments:
        assert arguments == [
            'plant', '--ros-args', '-p', meant or rule, '--', '-p', 'output:=y',
        ]  # fmt: skip


def test_a_file_stays_as_it_is_but_for_the_quotes(tmp_path):
    text = '# é\r\nplant:\r\n  ros__parameters: {output: y, file: y, inhibitory: [y ,  n]}\r\n'
    (tmp_path / 'it.yaml').write_bytes(b'\xef\xbb\xbf' + text.encode())
    with as_meant(['--ros-args', '--params-file', str(tmp_path / 'it.yaml')]) as arguments:
        found = Path(arguments[-1]).read_bytes().decode()
    assert found == text.replace('output: y', "output: 'y'").replace('[y ,  n]', "['y' ,  'n']")
    assert not os.path.exists(arguments[-1])


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (os.mkdir, 'it is a directory'),
        (os.mkfifo, 'it is a pipe'),
        (lambda path: os.symlink('/dev/zero', path), 'it is a device'),
        (lambda path: None, 'no such file or directory'),
    ],
)
def test_a_parameter_file_that_is_none_is_refused_at_once(tmp_path, make, reason):
    path = str(tmp_path / 'it')
    make(path)
    with pytest.raises(EventregError, match=f'--params-file {path}: {reason}'):
        refused(['--ros-args', '--params-file', path])


def test_a_parameter_given_twice_is_refused_as_offline(file):
    text = '/**: {ros__parameters: {k: 2.0}}\nplant:\n  ros__parameters: {k: 3, tau: 1, k: 2.5}\n'
    with pytest.raises(EventregError, match="line 3: 'k' is given twice; keep one"):
        refused(['--ros-args', *file(text)])
    foreign = 'talker: {ros__parameters: {pace: 2.0, pace: 3.0}}\n'  # not ours to judge
    with as_meant(['--ros-args', *file(foreign)]) as arguments:
        assert arguments == ['--ros-args', *file(foreign)]


def refused(arguments):
    with as_meant(arguments):
        pass


@pytest.mark.parametrize(
    ('arguments', 'key'),
    [
        (['-r', '__ns:=/qd'], 'qos_overrides./qd/y.publisher.depth'),
        (['-r', 'y:=/arm/m'], 'qos_overrides./arm/m.publisher.depth'),
    ],
)
def test_a_qos_key_acts_or_is_refused_with_the_one_that_does(bench, arguments, key):
    plant = partial(make, 'plant')
    with pytest.raises(EventregError, match=f'/y.publisher.depth acts on nothing.*write {key}'):
        bench.add(plant, 'qos_overrides./y.publisher.depth:=7', arguments=arguments)
    node = bench.add(plant, f'{key}:=7', arguments=arguments)
    assert node.get_parameter(key).value == 7


@pytest.mark.parametrize(
    ('rule', 'words'),
    [
        ('qos_overrides./y.publisher.durability:=volatile', "no policy 'durability'"),
        ('qos_overrides./y.depth:=7', 'must be qos_overrides.TOPIC.publisher.POLICY'),
        ('qos_overrides./y.publisher.reliability:=foo', 'foo'),
    ],
)
def test_a_qos_key_that_is_none_is_refused(bench, rule, words):
    with pytest.raises(EventregError, match=words):
        bench.add(partial(make, 'plant'), rule)


def test_a_qos_key_of_everybody_may_be_of_a_topic_that_this_node_does_not_have(bench):
    plant = bench.add(partial(make, 'plant'), 'qos_overrides./elsewhere.publisher.depth:=7')
    assert plant.stage == 'active'


def test_a_file_of_a_stimulus_is_looked_for_beside_the_file_that_names_it(bench, file, tmp_path):
    """Whatever the node is called, and where it is started from; -p counts from there."""
    (tmp_path / "it's v.csv").write_text('t,v\n0,0.25\n')
    text = '{}: {{ros__parameters: {{waveform: csv, file: "it\'s v.csv"}}}}'
    for key in ('stimulus', '/**', '/**/stimulus'):
        node = bench.add(StimulusNode, arguments=file(text.format(key)), start=False)
        assert node.values['file'] == str(tmp_path / "it's v.csv")
        node.trigger_configure()
        assert node.waveform(1.0) == 0.25
    here = bench.add(StimulusNode, 'file:=v.csv', start=False)
    assert here.values['file'] == 'v.csv'
    path = file('/**: {ros__parameters: {path: b}}')
    other = bench.add(partial(make, 'recorder'), arguments=path, start=False)
    assert other.values['path'] == 'b'


def test_a_parameter_that_no_node_has_is_a_warning_of_one_short_line():
    class Node:
        label, said = 'plant', []

        def get_logger(self):
            return self

        def warning(self, words):
            self.said.append(words)

    given = {'k': 2.0, 'nonsense': 1.0, 'long' * 1000: 1.0}
    assert fitted(Node(), parameters_of('plant', {}), given) == {'k': 2.0}
    assert "plant has no parameter 'nonsense', ignored; it has " in Node.said[0]
    assert max(map(len, Node.said)) <= 300
