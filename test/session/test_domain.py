# SPDX-License-Identifier: Apache-2.0
"""A domain of its own for every run on this machine.

The tests take ids below 0, which no run uses: the ports that belong to them are nobody's.
"""

import os
import socket
import subprocess
import sys

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.session import domain
from eventreg_ros.session.domain import DOMAINS, is_inhabited, loopback_domain, reaching, turn


def test_discovery_stays_on_the_loopback():
    with loopback_domain({'PATH': '/bin'}) as result:
        assert result['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
        assert int(result['ROS_DOMAIN_ID']) in DOMAINS
        assert result['PATH'] == '/bin'


def test_the_environment_wins():
    given = {'ROS_DOMAIN_ID': '7', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
    with loopback_domain(given) as first, loopback_domain(given) as second:
        for result in (first, second):
            assert given.items() <= result.items()
    for name, value in given.items():
        with loopback_domain({name: value}) as result:
            assert result[name] == value
            assert {'ROS_DOMAIN_ID', 'ROS_AUTOMATIC_DISCOVERY_RANGE'} <= result.keys()


def test_the_environment_itself_stays_as_it_is():
    given = {}
    with loopback_domain(given):
        pass
    assert given == {}


def test_two_at_once_differ(monkeypatch):
    monkeypatch.setattr(domain, 'DOMAINS', range(-9, -7))
    with loopback_domain({}) as first, loopback_domain({}) as second:
        assert {first['ROS_DOMAIN_ID'], second['ROS_DOMAIN_ID']} == {'-9', '-8'}
        with pytest.raises(EventregError, match='set ROS_DOMAIN_ID'), loopback_domain({}):
            pass
    with loopback_domain({}), loopback_domain({}):  # they were given back
        pass


class WaitingError(Exception):
    """Stops the waiting."""


def test_only_one_run_at_a_time_begins_in_a_domain():
    """Two that begin at once do not see each other's nodes yet, and would take them for theirs."""
    waited = []

    def look():
        waited.append(True)
        if len(waited) == 3:
            raise WaitingError

    for _ in range(2):  # it was given back
        with turn(-3, look), turn(-4, look):
            assert not waited
    with turn(-3, look), pytest.raises(WaitingError), turn(-3, look):
        pass
    assert len(waited) == 3


def test_the_highest_domain_has_fewer_ports():
    assert not is_inhabited(232)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.1', 7400 + 250 * 232 + 10 + 2 * 60))
        assert is_inhabited(232)


def test_a_domain_is_given_back_after_an_error(monkeypatch):
    monkeypatch.setattr(domain, 'DOMAINS', range(-7, -6))
    for _ in range(2):
        with pytest.raises(ZeroDivisionError), loopback_domain({}):
            raise ZeroDivisionError


HOLDER = """
import sys
from eventreg_ros.session import domain
domain.DOMAINS = range(-6, -4)
with domain.loopback_domain({}) as result:
    print(result['ROS_DOMAIN_ID'], flush=True)
    sys.stdin.read()
"""


def test_two_processes_differ():
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    pipes = {'stdin': subprocess.PIPE, 'stdout': subprocess.PIPE, 'text': True}
    command = [sys.executable, '-c', HOLDER]
    with (
        subprocess.Popen(command, env=environment, **pipes) as first,
        subprocess.Popen(command, env=environment, **pipes) as second,
    ):
        assert {p.stdout.readline().strip() for p in (first, second)} == {'-6', '-5'}
        for process in (first, second):
            process.stdin.close()


def test_a_domain_with_a_participant_is_left_alone(monkeypatch):
    """The ports of a domain's first participant, by the DDS wire protocol: 7400 + 250 d + 10."""
    monkeypatch.setattr(domain, 'DOMAINS', range(-4, -2))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as participant:
        participant.bind(('0.0.0.0', 7400 + 250 * -4 + 10))
        for _ in range(5):
            with loopback_domain({}) as result:
                assert result['ROS_DOMAIN_ID'] == '-3'


def test_the_ports_of_every_domain_lie_below_the_ephemeral_ones():
    assert max(7400 + 250 * d + 10 + 2 * 119 for d in DOMAINS) < 32768


def test_a_process_reaches_whom_it_is_told_and_then_whom_it_did(monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', '1')
    monkeypatch.setenv('ROS_STATIC_PEERS', 'a')
    monkeypatch.delenv('FASTRTPS_DEFAULT_PROFILES_FILE', raising=False)
    before = dict(os.environ)
    given = {'ROS_DOMAIN_ID': '2', 'FASTRTPS_DEFAULT_PROFILES_FILE': 'x.xml', 'HOME': 'other'}
    with reaching(given):
        assert 'ROS_STATIC_PEERS' not in os.environ
        changed = {name: value for name, value in os.environ.items() if before.get(name) != value}
        assert changed == {name: given[name] for name in given if name != 'HOME'}
    assert dict(os.environ) == before
    with pytest.raises(ZeroDivisionError), reaching(given):
        raise ZeroDivisionError
    assert dict(os.environ) == before
