"""What a session does when nodes die: said with fake processes, without ROS."""

from pathlib import Path

import pytest

from eventreg_ros import scenario as scenarios
from eventreg_ros.session.session import Observer, Session


class Heard(Observer):
    def __init__(self):
        self.lines = []

    def warned(self, line):
        self.lines.append(line)


class Processes:
    """Processes of which ``fresh`` die at the next look."""

    def __init__(self):
        self.fresh, self.died = [], {}

    def look(self):
        found, self.fresh = self.fresh, []
        self.died.update(dict.fromkeys(found, 'was killed by SIGKILL'))
        return found


def session(scenario=None, **options):
    made = Session(
        scenario or scenarios.load('exact'), Path('bag'), 12.0, observer=Heard(), **options
    )
    made.processes = Processes()
    return made


@pytest.mark.parametrize(
    ('values', 'command'),
    [
        ({}, 'ros2 run eventreg_ros plant'),
        ({'package': 'arm_driver', 'executable': 'motor'}, 'ros2 run arm_driver motor'),
    ],
)
def test_a_node_that_died_is_started_again_by_its_own_executable(values, command):
    dying = session(scenarios.load('exact').with_given({'plant': values}))
    dying.processes.fresh = ['plant']
    dying._tell_deaths(1.8)
    assert dying.observer.lines == [
        'plant was killed by SIGKILL after 1.8 s; the others run on, and it may be started '
        f'again: {command}'
    ]


def test_in_lockstep_nobody_runs_on():
    dying = session(lockstep=True)
    dying.processes.fresh = ['plant']
    dying._tell_deaths(1.8)
    assert dying.over
    assert dying.troubles == ['plant was killed by SIGKILL after 1.8 s']
    assert not dying.observer.lines
