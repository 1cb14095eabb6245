# SPDX-License-Identifier: Apache-2.0
"""What a session does when nodes die: said with fake processes, without ROS."""

from pathlib import Path

import pytest

from eventreg_ros import scenario as scenarios
from eventreg_ros.scenario.interventions import read_all
from eventreg_ros.session.observer import Observer
from eventreg_ros.session.session import Session


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


class Client:
    """A client of nodes that do all they are asked, except ``dying``, which die while asked."""

    def __init__(self, session=None, dying=()):
        self.session, self.dying, self.heard = session, dying, set()
        self.done, self.patience = [], []
        self.names = {}
        """How many nodes of a name there are, at each look."""

    def namesakes(self, node):
        left = self.names.get(node, [1])
        return left.pop(0) if len(left) > 1 else left[0]

    def take_heard(self, node):
        heard = node in self.heard
        self.heard.discard(node)
        return heard

    def act(self, each, seconds):
        if each.node in self.dying:
            self.session.processes.fresh = [each.node]
        self.alive()
        self.done.append(each.text)
        self.patience.append(seconds)

    def resume(self):
        self.alive()


def session(scenario=None, **options):
    made = Session(
        scenario or scenarios.load('exact'), Path('bag'), 12.0, observer=Heard(), **options
    )
    made.processes, made._elapsed = Processes(), lambda: 1.8
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
    dying._report_deaths(Client())
    assert dying.observer.lines == [
        'plant was killed by SIGKILL after 1.8 s; the others run on, and it may be started '
        f'again: {command}'
    ]


def test_a_node_that_died_before_the_first_sample_did_not_die_at_a_negative_time():
    dying = session()
    dying._elapsed = lambda: -1.1
    dying.processes.fresh = ['plant']
    dying._report_deaths(Client())
    assert dying.troubles == ['plant was killed by SIGKILL before the first sample']


def test_in_lockstep_nobody_runs_on():
    dying = session(lockstep=True)
    dying.processes.fresh = ['plant']
    dying._report_deaths(Client())
    assert dying.over
    assert dying.troubles == ['plant was killed by SIGKILL after 1.8 s']
    assert not dying.observer.lines


AT = ['6:plant.k:=2', '7:controller.k:=2']


def intervened(now, before=(), dying=(), heard=(), names=(1,)):
    case = scenarios.load('exact')
    made = session(case, interventions=read_all(AT, case))
    client = Client(made, dying)
    made._elapsed = lambda: now
    made.processes.fresh = list(before)
    made._report_deaths(client)
    client.heard.update(heard)
    client.names = {'plant': list(names)}
    for _ in names[1:]:
        made._note_returns(client)
    made._intervene(client, now)
    return made, client


@pytest.mark.parametrize('death', ['before', 'dying'])
def test_an_action_on_a_dead_node_is_reported_and_the_others_are_done(death):
    made, client = intervened(7.0, **{death: ['plant']})
    undone = 'at 6:plant.k:=2 was not done: plant was killed by SIGKILL'
    assert client.done == AT[1:]
    assert made.troubles == ['plant was killed by SIGKILL after 7.0 s', undone]
    assert undone in made.observer.lines


def test_a_node_that_was_started_again_is_asked():
    made, client = intervened(7.0, before=['plant'], heard=['plant'])
    assert client.done == AT
    assert len(made.troubles) == 1


@pytest.mark.parametrize(
    ('names', 'done'),
    [
        ([1], AT[1:]),
        ([0], AT[1:]),
        ([1, 0, 1], AT),
        ([1, 2], AT),
        ([2, 1], AT),
        ([1, 0, 0], AT[1:]),
    ],
)
def test_a_node_without_diagnostics_is_known_by_its_name(names, done):
    made, client = intervened(7.0, before=['plant'], names=names)
    assert client.done == done
    assert (made._gone == set()) == (done == AT)


@pytest.mark.parametrize(('now', 'patience'), [(7.0, 5.0), (11.9, 1.0)])
def test_a_node_is_waited_for_as_long_as_the_run_lasts_or_a_second(now, patience):
    _, client = intervened(now)
    assert client.patience == [patience] * 2
