# SPDX-License-Identifier: Apache-2.0
"""``ros2 launch eventreg_ros loop.launch.py`` with ROS's own launch, where that is installed."""

import os
import shutil
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip('launch_pytest')
pytest.importorskip('launch_ros')

import launch_pytest
import rclpy
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import Node
from rclpy.context import Context
from std_msgs.msg import Float64

from eventreg_ros import analyze
from eventreg_ros.nodes.ros import make_executor
from eventreg_ros.session.domain import loopback_domain

ROOT = Path(__file__).resolve().parent.parent
LAUNCH = ROOT / 'launch' / 'loop.launch.py'
LONG = 60.0

pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.fixture
def domain(monkeypatch):
    """A free domain of the loopback for the launched processes."""
    with loopback_domain({k: v for k, v in os.environ.items() if k != 'ROS_DOMAIN_ID'}) as found:
        for name, value in found.items():
            monkeypatch.setenv(name, value)
        yield int(found['ROS_DOMAIN_ID'])


@pytest.fixture(autouse=True)
def _installed(tmp_path, monkeypatch):
    """The package where ``ros2 launch`` looks for it: what colcon installs, from the sources."""
    prefix = tmp_path / 'prefix'
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'eventreg_ros').touch()
    shutil.copytree(ROOT / 'resource' / 'executables', prefix / 'lib' / 'eventreg_ros')
    (prefix / 'bin').mkdir()
    command = prefix / 'bin' / 'eventreg'
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m eventreg_ros "$@"\n')
    command.chmod(0o755)
    before = os.environ.get('AMENT_PREFIX_PATH', '')
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(filter(None, [str(prefix), before])))
    paths = [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))


@pytest.fixture
def heard(domain):
    """Await samples of a topic; return how many samples each has had by then."""
    context = Context()
    context.init(args=['--ros-args', '--log-level', 'FATAL'], domain_id=domain)
    node, executor = rclpy.create_node('listener', context=context), make_executor(context)
    executor.add_node(node)
    counts = {}

    def until(count, *topics):
        for topic in topics:
            counts[topic] = []
            node.create_subscription(Float64, topic, counts[topic].append, 100)
        end = time.monotonic() + LONG
        while not all(len(found) >= count for found in counts.values()):
            assert time.monotonic() < end, {t: len(found) for t, found in counts.items()}
            executor.spin_once(timeout_sec=0.1)

    yield until
    node.destroy_node()
    context.try_shutdown()


def loop(**arguments):
    source = PythonLaunchDescriptionSource(str(LAUNCH))
    return IncludeLaunchDescription(source, launch_arguments=arguments.items())


@launch_pytest.fixture
def recorded(domain, tmp_path):
    """The scenario exact, recorded."""
    arguments = {'scenario': 'exact', 'record': 'true', 'bag': str(tmp_path / 'bag')}
    return LaunchDescription([loop(**arguments), launch_pytest.actions.ReadyToTest()])


@pytest.mark.launch(fixture=recorded)
def test_the_loop_runs_and_its_bag_can_be_judged(heard, tmp_path):
    heard(100, '/w', '/y', '/u')
    yield
    found = analyze(tmp_path / 'bag')
    assert set(found.signals) >= {'w', 'y', 'u'}
    assert found.verdict == 'undecided'  # it ran for seconds
    assert found.scenario.name == 'exact'


@launch_pytest.fixture
def in_a_namespace(domain):
    """The scenario exact in a namespace, a link on u."""
    arguments = {'scenario': 'exact', 'namespace': 'lab', 'link': 'u:delay=0.01'}
    return LaunchDescription([loop(**arguments), launch_pytest.actions.ReadyToTest()])


@pytest.mark.launch(fixture=in_a_namespace)
def test_in_a_namespace_with_a_link(heard):
    heard(20, '/lab/w', '/lab/y', '/lab/u', '/lab/u_link')


@pytest.fixture
def plant():
    """A plant whose dictionary of parameters launch writes to a file, the signal y unquoted."""
    return Node(
        package='eventreg_ros',
        executable='plant',
        parameters=[{'output': 'y', 'k': 2, 'excitatory': ['w', 'v']}],
        cached_output=True,
    )


@launch_pytest.fixture
def plant_alone(domain, plant):
    """That plant alone."""
    return LaunchDescription([plant, launch_pytest.actions.ReadyToTest()])


@pytest.mark.launch(fixture=plant_alone)
def test_a_dictionary_of_parameters_and_a_clean_end(heard, plant):
    heard(20, '/y')
    yield
    assert plant.return_code == 0
