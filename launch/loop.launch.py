# SPDX-License-Identifier: Apache-2.0
"""Start the nodes of a scenario: ros2 launch eventreg_ros loop.launch.py scenario:=exact."""

import shutil
import tempfile
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnShutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from eventreg_ros import scenario as scenarios
from eventreg_ros.errors import EventregError

ARGUMENTS = (
    DeclareLaunchArgument(
        'scenario', default_value='exact', description='a shipped scenario, or the path of one'
    ),
    DeclareLaunchArgument(
        'params_file', default_value='', description='a parameter file read after the scenario'
    ),
    DeclareLaunchArgument(
        'link',
        default_value='',
        description='links on signals: "u:delay=0.02,jitter=0.005 y:loss=0.1"',
    ),
    DeclareLaunchArgument('namespace', default_value='', description='namespace of all nodes'),
    DeclareLaunchArgument('record', default_value='false', description='record a bag'),
    DeclareLaunchArgument(
        'bag', default_value='', description='directory of the bag; empty: eventreg_<date>-<time>'
    ),
)


def start(context):
    """Return the nodes that the scenario names, and a recorder when one is asked for."""

    def value(name):
        return LaunchConfiguration(name).perform(context)

    scratch = Path(tempfile.mkdtemp(prefix='eventreg_'))
    try:
        scenario = scenarios.load(value('scenario')).with_links(value('link').split())
        if value('params_file'):
            scenario = merged(scenario, Path(value('params_file')), value('namespace'))
        scenario = scenario.with_codings()
        if value('record').lower() in ('true', '1', 'yes', 'on'):
            text = stored(scratch / 'scenario' / f'{scenario.name}.yaml', scenario.to_yaml())
            scenario = scenario.with_recorder(value('bag'), str(text), monitor=False)
    except EventregError as error:
        shutil.rmtree(scratch, ignore_errors=True)
        raise RuntimeError(str(error)) from None
    # As one file, in which a node of another package finds the signal y quoted, too.
    file = str(
        stored(
            scratch / 'parameters.yaml',
            scenario.to_yaml(anywhere=True, namespace=value('namespace')),
        )
    )
    return [
        RegisterEventHandler(
            OnShutdown(on_shutdown=lambda *_: shutil.rmtree(scratch, ignore_errors=True))
        ),
        LogInfo(msg=f'scenario {scenario.name}: {", ".join(scenario.nodes)}'),
        *(node_of(scenario, name, value('namespace'), file) for name in scenario.nodes),
    ]


def node_of(scenario, name, namespace, file):
    """Return the action that starts one node of the scenario with the parameters in ``file``."""
    values, parts = scenario.nodes[name], scenario.name_of(name)
    foreign = name in scenario.foreign
    return Node(
        package=values['package'] if foreign else 'eventreg_ros',
        executable=values['executable'] if foreign else parts.kind,
        name=parts.name,
        namespace='/'.join(filter(None, (namespace, parts.namespace))),
        output='screen',
        parameters=[file],
    )


def merged(scenario, path, namespace):
    """Return the scenario with what a parameter file says of its nodes, in their namespace."""
    try:
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise RuntimeError(f'params_file {path} must be a readable text file: {error}') from None
    return scenarios.with_file(scenario, text, path.name, namespace, path.parent)


def stored(path, text):
    """Write ``text`` to ``path`` and return it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding='utf-8')
    return path


def generate_launch_description():
    """Return the launch description."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=start)])
