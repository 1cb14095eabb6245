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
from eventreg_ros.scenario.links import with_links
from eventreg_ros.scenario.parameters import kind_of

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

    try:
        scenario = with_links(scenarios.load(value('scenario')), value('link').split())
    except EventregError as error:
        raise RuntimeError(str(error)) from None
    scratch = Path(tempfile.mkdtemp(prefix='eventreg_'))
    text = scenario.to_yaml()
    nodes = {name: dict(values) for name, values in scenario.given.items()}
    if value('record').lower() in ('true', '1', 'yes', 'on'):
        nodes['recorder'] = {
            'signals': list(scenario.publishers),
            **nodes.get('recorder', {}),
            'path': value('bag'),
            'scenario': str(stored(scratch / 'scenario' / f'{scenario.name}.yaml', text)),
            'scenario_name': scenario.name,
        }
    # Not as a dictionary: launch would write the signal y unquoted, and ROS reads that as true.
    text = scenarios.Scenario(scenario.name, {}, nodes).to_yaml(anywhere=True)
    file = str(stored(scratch / 'parameters.yaml', text))
    later = [value('params_file')] if value('params_file') else []
    return [
        RegisterEventHandler(
            OnShutdown(on_shutdown=lambda *_: shutil.rmtree(scratch, ignore_errors=True))
        ),
        LogInfo(msg=f'scenario {scenario.name}: {", ".join(nodes)}'),
        *(
            Node(
                package='eventreg_ros',
                executable=kind_of(name),
                name=name,
                namespace=value('namespace'),
                output='screen',
                parameters=[file, *later],
            )
            for name in nodes
        ),
    ]


def stored(path, text):
    """Write ``text`` to ``path`` and return it."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding='utf-8')
    return path


def generate_launch_description():
    """Return the launch description."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=start)])
