# SPDX-License-Identifier: Apache-2.0
"""The nodes as processes: arguments, signals, exit codes, and the closed loop over DDS."""

import ast
import os
import re
import signal
import time
from pathlib import Path

import pytest
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Float64

from eventreg_ros.bags.reader import read_bag
from eventreg_ros.nodes import executables
from eventreg_ros.scenario.names import KINDS as NODES
from eventreg_ros.scenario.parameters import parameters_of


@pytest.fixture
def launch_bare(domain, spawn):
    """Start a node, or a script, with arguments that are not ROS's."""

    def start(node, *arguments, **options):
        script = ('-m', f'eventreg_ros.nodes.{node}') if node in NODES else (node,)
        environment = {**os.environ, 'PYTHONPATH': str(Path(executables.__file__).parents[2])}
        return spawn(*script, *arguments, env=environment, **options)

    return start


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('node', sorted(NODES))
def test_it_runs_and_ends_cleanly_on_a_signal_and_on_a_second_one(
    bench, launch, tmp_path, node, number
):
    path = ['-p', f'path:={tmp_path / "bag"}'] if node == 'recorder' else []
    process = launch(node, '-r', '__ns:=/lab', '--log-level', 'WARN', *path)
    bench.until(lambda: (node, '/lab') in bench.peer.get_node_names_and_namespaces())
    bench.until(lambda: bench.peer.count_publishers('/lab/rosout') >= 0 and _active(bench, node))
    process.send_signal(number)
    process.send_signal(number)  # as ros2 launch does
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0
    assert (out, err) == ('', '')


def _active(bench, node):
    """Whether the node's lifecycle is active, asked as ros2 lifecycle get does."""
    from lifecycle_msgs.srv import GetState

    client = bench.peer.create_client(GetState, f'/lab/{node}/get_state')
    bench.until(client.service_is_ready)
    future = client.call_async(GetState.Request())
    end = time.monotonic() + 2.0
    while not future.done() and time.monotonic() < end:
        bench.executor.spin_once(timeout_sec=0.05)
    bench.peer.destroy_client(client)
    return future.done() and future.result().current_state.label == 'active'


@pytest.mark.parametrize(
    ('node', 'arguments', 'words'),
    [
        ('plant', ['-p', 'tau:=-1.0'], 'plant.tau must be a finite number > 0, got -1.0'),
        ('plant', ['-p', 'x0:=[1.0]'], 'plant.x0 must have 2 numbers'),
        ('plant', ['-p', 'k:=[1.0]'], 'plant.k must be a finite number >= 0'),
        ('plant', ['-p', 'output:=yes'], 'quote words'),
        ('spike_monitor', ['-p', 'signals:=[w, on]'], "Value type 'bool' do not belong"),
        ('plant', ['-p', 'x0:=[1, 0.5]'], "Value type 'double' do not belong"),
        ('controller', ['-p', 'model:=tree'], 'one of neuron, oscillator, linear'),
        ('spike_monitor', ['-p', 'reset:=2.0'], 'spike_monitor.reset must be < threshold'),
        ('stimulus', ['-p', 'waveform:=csv'], 'stimulus.file'),
        ('plant', ['-p', 'k:='], 'k:='),
        ('recorder', ['-p', 'scenario:=/dev/zero', '-p', 'path:=nowhere'], 'it is a device'),
        ('recorder', ['-p', "scenario_name:='../x'", '-p', 'path:=nowhere'], 'a plain word'),
        ('plant', ['--nonsense'], "unknown ROS arguments ['--nonsense']"),
        ('plant', ['--params-file', 'nowhere.yaml'], 'nowhere.yaml'),
    ],
)
def test_bad_arguments_are_one_line_and_exit_code_2(launch, node, arguments, words):
    process = launch(node, *arguments)
    _, err = process.communicate(timeout=20)
    ours = [line for line in err.splitlines() if line.startswith('eventreg_ros: ')]
    assert process.returncode == 2
    assert len(ours) == 1
    assert words in ours[0]
    assert 'Traceback' not in err
    if arguments[0] == '-p':  # of other arguments rcl logs a line of its own
        assert err.count('\n') == 1


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        ([], []),
        (['--ros-args', '-p', 'k:=2.0'], []),
        (['--ros-args', '-r', '__node:=plant_2', '--', '--ros-args', '-p', 'k:=2.0'], []),
        (['--help'], ['--help']),
        (['k:=2.0', '--ros-args', '-p', 'k:=2.0'], ['k:=2.0']),
        (['--ros-args', '-p', 'k:=2.0', '--', 'more'], ['more']),
        (['--', 'more'], ['--', 'more']),
    ],
)
def test_what_is_not_behind_ros_args_is_not_ros_s(arguments, words):
    assert executables.own_words(arguments) == words
    assert remove_ros_args(arguments) == words


@pytest.mark.parametrize('node', sorted(NODES))
def test_help_says_what_the_node_is_and_lists_its_parameters(node, capsys):
    assert executables.run(node, ['--help']) == 0
    out, err = capsys.readouterr()
    assert err == ''
    assert out.startswith(f'usage: {node} ')
    assert '--ros-args' in out
    assert ast.get_docstring(ast.parse(_source(node))) in out
    listed = re.findall(r'^  (\w+) = ', out, re.MULTILINE)
    assert listed == list(parameters_of(node))
    assert max(map(len, out.splitlines())) <= 100


def _source(node):
    return Path(executables.__file__).with_name(f'{node}.py').read_text()


def test_help_is_help_behind_ros_args_too(capsys):
    assert executables.run('plant', ['--ros-args', '-p', 'k:=2.0', '--help']) == 0
    assert capsys.readouterr().out.startswith('usage: plant ')


def test_help_shows_values_as_ros_writes_them(capsys):
    executables.run('plant', ['-h'])
    out = capsys.readouterr().out
    assert '  excitatory = [w, v]: ' in out
    assert '  autostart = true: ' in out
    assert '  k = 1: ' in out
    executables.run('recorder', ['-h'])
    assert "  path = '': " in capsys.readouterr().out


@pytest.mark.parametrize('node', ['exosystem', 'recorder'])
@pytest.mark.parametrize('arguments', [['-p', 'k:=2.0'], ['nonsense', '--ros-args']])
def test_a_wrong_argument_is_one_line_and_starts_nothing(launch_bare, tmp_path, node, arguments):
    process = launch_bare(node, *arguments, cwd=tmp_path)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out) == (2, '')
    assert err == (
        f'eventreg_ros: {node}: unknown argument {arguments[0]!r}; parameters go behind '
        f'--ros-args, as in --ros-args -p NAME:=VALUE; see {node} --help\n'
    )
    assert list(tmp_path.iterdir()) == []


def test_help_of_a_module_that_is_run_is_that_of_the_executable(launch_bare, capsys):
    out, err = launch_bare('clock', '--help').communicate(timeout=20)
    executables.run('clock', ['--help'])
    assert (out, err) == (capsys.readouterr().out, '')


def test_a_node_of_one_s_own_answers_with_its_docstring(launch_bare, tmp_path):
    script = tmp_path / 'pendulum.py'
    script.write_text(
        '"""The pendulum: listens to u."""\n'
        'from eventreg_ros.nodes.own import OwnBlock, Parameter, run\n'
        'class Pendulum(OwnBlock):\n'
        "    parameters = (Parameter('length', 'double', 0.5, 'of the rod'),)\n"
        'raise SystemExit(run(Pendulum))\n'
    )
    out, err = launch_bare(script, '--help').communicate(timeout=20)
    assert err == ''
    assert out.startswith('usage: pendulum ')
    assert 'The pendulum: listens to u.' in out
    assert '  length = 0.5: of the rod ' in out
    assert "pendulum: unknown argument '-x'" in launch_bare(script, '-x').communicate(timeout=20)[1]


def test_an_unknown_parameter_is_reported_with_the_nearest_name(bench, launch):
    process = launch('plant', '-p', 'taau:=0.5')
    heard = bench.heard(Float64, 'y')
    bench.until(lambda: heard)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert "no parameter 'taau', ignored; did you mean 'tau'?" in err
    assert process.returncode == 0


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_killed_recorder_leaves_a_bag_that_can_be_read(bench, launch, tmp_path, storage):
    bag = tmp_path / 'bag'
    process = launch(
        'recorder', '-p', "signals:=['y']", '-p', f'path:={bag}', '-p', f'storage:={storage}'
    )
    y = bench.peer.create_publisher(Float64, 'y', 100)
    file = bag / f'bag.{"mcap" if storage == "mcap" else "db3"}'
    bench.until(lambda: y.publish(Float64(data=-1.0)) or -1.0 in _readable(file, bag))
    sent = [float(n) for n in range(20)]
    for value in sent:
        y.publish(Float64(data=value))
    bench.until(lambda: 19.0 in _readable(file, bag))  # flushed once a second
    process.kill()
    process.wait()
    assert read_bag(bag).signals['y'][1].tolist()[-20:] == sent


def _readable(file, bag):
    if not file.exists() or file.stat().st_size < 100:
        return []
    try:
        return read_bag(bag).signals['y'][1].tolist()
    except Exception:
        return []
