"""The nodes as processes: arguments, signals, exit codes, and the closed loop over DDS."""

import signal
import time

import pytest
from std_msgs.msg import Float64

from eventreg_ros.bags.reader import read_bag
from eventreg_ros.scenario.names import KINDS as NODES


@pytest.fixture
def launch(domain, spawn):
    """Start a node as ``ros2 run`` would; everything started is ended with the test."""

    def start(node, *arguments):
        ros = ['--ros-args', *arguments] if arguments else []
        return spawn('-m', f'eventreg_ros.nodes.{node}', *ros)

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
        ('plant', ['-p', 'output:=y'], 'quote'),  # ROS reads y as true
        ('controller', ['-p', 'model:=tree'], 'one of neuron, oscillator, linear'),
        ('spike_monitor', ['-p', 'reset:=2.0'], 'spike_monitor.reset must be < threshold'),
        ('stimulus', ['-p', 'waveform:=csv'], 'stimulus.file'),
        ('plant', ['-p', 'k:='], 'k:='),
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


def test_an_unknown_parameter_is_told_with_the_nearest_name(bench, launch):
    process = launch('plant', '-p', 'taau:=0.5')
    heard = bench.heard(Float64, 'y')
    bench.until(lambda: heard)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert "no parameter 'taau'; did you mean 'tau'" in err
    assert process.returncode == 0


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_killed_recorder_leaves_a_bag_that_can_be_read(bench, launch, tmp_path, storage):
    bag = tmp_path / 'bag'
    process = launch(
        'recorder', '-p', "signals:=['y']", '-p', f'path:={bag}', '-p', f'storage:={storage}'
    )
    y = bench.peer.create_publisher(Float64, 'y', 100)
    bench.until(lambda: y.get_subscription_count() == 1)
    bench.until(lambda: _recording(bench, y))
    sent = [float(n) for n in range(20)]
    for value in sent:
        y.publish(Float64(data=value))
    file = bag / f'bag.{"mcap" if storage == "mcap" else "db3"}'
    bench.until(lambda: 19.0 in _readable(file, bag))  # flushed once a second
    process.kill()
    process.wait()
    assert read_bag(bag).signals['y'][1].tolist()[-20:] == sent


def _recording(bench, y):
    y.publish(Float64(data=-1.0))
    bench.spin(0.02)
    return bench.peer.count_subscribers('y') == 1


def _readable(file, bag):
    if not file.exists() or file.stat().st_size < 100:
        return []
    try:
        return read_bag(bag).signals['y'][1].tolist()
    except Exception:
        return []
