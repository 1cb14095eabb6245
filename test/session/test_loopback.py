# SPDX-License-Identifier: Apache-2.0
"""A run keeps to the loopback: seen from another host, there is nothing, unless it is opened."""

import functools
import importlib.util
import json
import os
from pathlib import Path

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.session.loopback import HERE, PROFILES, RANGE, closed, opened

ROOT = Path(__file__).resolve().parent.parent.parent
BENCH = ROOT / 'bench'

STRANGER = """
import json, select, sys
import rclpy
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
rclpy.init()
node = rclpy.create_node('stranger')
client = node.create_client(SetParameters, '/controller/set_parameters')
while not (client.service_is_ready() or select.select([sys.stdin], [], [], 0.0)[0]):
    rclpy.spin_once(node, timeout_sec=0.1)
set_it = False
if client.service_is_ready():
    value = ParameterValue(type=3, double_value=7.0)
    future = client.call_async(SetParameters.Request(parameters=[Parameter(name='k', value=value)]))
    rclpy.spin_until_future_complete(node, future, timeout_sec=5.0)
    set_it = future.done() and future.result().results[0].successful
names = sorted(set(node.get_node_names()) - {'stranger'})
print(json.dumps({'seen': names, 'set': set_it}), flush=True)
rclpy.shutdown()
"""

HOSTS = """
import json, subprocess, sys, os, signal
import netns
from netns import Hosts

netns.enter()
CASES = {'closed': [], 'lockstep': ['--lockstep', '--composed'], 'open': ['--network']}
found, runs = {}, {}
with Hosts([*CASES, 'stranger']) as hosts:
    environment = {**os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
    pipes = {'stdout': subprocess.PIPE, 'stderr': subprocess.STDOUT, 'text': True}
    for i, (name, options) in enumerate(CASES.items()):
        command = [sys.executable, '-m', 'eventreg_ros', 'run', 'exact', '--duration', '3600',
                   '--bag', f'{sys.argv[1]}/{name}', *options]
        domain = {**environment, 'ROS_DOMAIN_ID': str(66 + i)}
        runs[name] = subprocess.Popen([*hosts.within(name), *command], env=domain, **pipes)
    for name, run in runs.items():
        for line in run.stdout:  # the first counts of events: it goes on
            if 'events:' in line:
                break
        else:
            raise SystemExit(f'{name}: {run.wait()}')
    strangers = {}
    for i, name in enumerate(runs):
        peers = {'ROS_STATIC_PEERS': hosts.addresses[name], 'ROS_DOMAIN_ID': str(66 + i),
                 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}  # which asks 32 ports, not 4
        command = [*hosts.within('stranger'), sys.executable, '-c', sys.argv[2]]
        strangers[name] = subprocess.Popen(
            command, env={**environment, **peers}, stdin=subprocess.PIPE, **pipes)
    strangers['open'].wait()  # the others look as long as that one needs
    for name, stranger in strangers.items():
        found[name] = json.loads(stranger.communicate()[0].splitlines()[-1])
        command = [*hosts.within(name), 'ss', '-lunH']
        listed = subprocess.run(command, capture_output=True, text=True).stdout
        local = [line.split()[3] for line in listed.splitlines()]
        found[name]['listens'] = sorted({each.rpartition(':')[0] for each in local})
        runs[name].send_signal(signal.SIGINT)
    for run in runs.values():
        run.communicate()
print(json.dumps(found))
"""


@pytest.fixture(scope='module')
def netns():
    """The module bench/netns.py, where the machine allows what it needs."""
    pytest.importorskip('rclpy')
    spec = importlib.util.spec_from_file_location('netns', BENCH / 'netns.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if reason := module.unavailable():
        pytest.skip(reason)
    return module


def test_nobody_on_another_host_sees_a_run_or_sets_its_nodes(netns, spawn, tmp_path):
    (tmp_path / 'hosts.py').write_text(HOSTS)
    paths = os.pathsep.join(map(str, (ROOT, BENCH)))
    start = functools.partial(spawn, env={**os.environ, 'PYTHONPATH': paths})
    out, err = start(tmp_path / 'hosts.py', tmp_path, STRANGER).communicate(timeout=120)
    found = json.loads(out or err)
    for name in ('closed', 'lockstep'):
        assert found[name] == {'seen': [], 'set': False, 'listens': ['127.0.0.1']}
    # The stranger is none that sees nothing anyway.
    assert found['open']['set'] is True
    assert found['open']['listens'] != ['127.0.0.1']


def test_the_profiles_pin_fast_dds_and_leave_the_range_to_it(tmp_path):
    given = {'ROS_DOMAIN_ID': '7', RANGE: 'SUBNET', 'ROS_STATIC_PEERS': 'a;b', 'PATH': '/bin'}
    found = closed(given, tmp_path)
    for environment, name in ((found.nodes, 'nodes'), (found.client, 'client')):
        assert {environment.pop(each) for each in PROFILES} == {str(tmp_path / f'{name}.xml')}
        assert environment == {
            'ROS_DOMAIN_ID': '7', 'PATH': '/bin', RANGE: 'SYSTEM_DEFAULT', 'SKIP_DEFAULT_XML': '1',
        }  # fmt: skip
    assert found.notes == ['ROS_STATIC_PEERS=a;b is left aside; --network opens the run to others']


@pytest.mark.parametrize('name', PROFILES)
def test_profiles_of_one_s_own_are_respected_and_reported(tmp_path, name):
    mine = tmp_path / 'mine.xml'
    given = {name: str(mine), 'ROS_STATIC_PEERS': 'a'}
    with pytest.raises(EventregError, match=f'{name} must name a file'):
        closed(given, tmp_path)  # Fast DDS would do without, and be open
    mine.touch()
    found = closed(given, tmp_path)
    assert found.nodes == found.client == {**given, RANGE: 'LOCALHOST'}
    assert f'({name}={mine})' in found.notes[0]
    assert list(tmp_path.iterdir()) == [mine]


def test_a_file_of_profiles_where_one_stands_is_respected_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / HERE).write_text('')
    assert str(HERE) in closed({}, tmp_path).notes[0]
    assert closed({'SKIP_DEFAULT_XML': '1'}, tmp_path).notes == []


def test_another_middleware_is_reported(tmp_path):
    found = closed({'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}, tmp_path)
    assert found.nodes[RANGE] == 'LOCALHOST'
    assert 'rmw_cyclonedds_cpp may listen on the network' in found.notes[0]


@pytest.mark.parametrize(('domain', 'participants'), [('7', 100), ('231', 100), ('232', 62)])
def test_peers_are_looked_for_only_where_there_are_ports(tmp_path, domain, participants):
    """Fast DDS ends the process, with 1 of all codes, for a port beyond 65535."""
    closed({'ROS_DOMAIN_ID': domain}, tmp_path)
    found = f'<maxInitialPeersRange>{participants}</maxInitialPeersRange>'
    assert all(found in file.read_text() for file in tmp_path.iterdir())
    last = 7400 + 250 * int(domain) + 11 + 2 * (participants - 1)  # its port for data
    assert last <= 65535


def test_an_open_run_has_what_the_environment_says():
    assert opened({}).nodes == {RANGE: 'SUBNET'}
    given = {RANGE: 'LOCALHOST', 'ROS_STATIC_PEERS': 'a', 'FASTDDS_BUILTIN_TRANSPORTS': 'SHM'}
    assert opened(given).nodes == opened(given).client == given
    assert 'whoever reaches this domain' in opened({}).notes[0]
