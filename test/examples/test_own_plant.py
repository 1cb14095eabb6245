# SPDX-License-Identifier: Apache-2.0
"""The example of a plant of one's own: twice in lockstep to one hash, and in real time."""

import hashlib
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2: pip install eventreg_ros[ros]')

pytestmark = pytest.mark.ros

SCENARIO = Path(__file__).resolve().parents[2] / 'examples/own_plant/config/membrane.yaml'
FAST = ('-p', '/**.time_scale:=20', '-p', '/**.rate:=400')


@pytest.fixture(scope='module')
def run(installed):
    return installed('own_plant')


def test_twice_in_lockstep_it_is_the_same_to_the_bit(run):
    hashes = set()
    for bag in ('first', 'second'):
        arguments = ('--lockstep', '--duration', '16', '--settle', '40', '--bag', bag)
        out = run('-m', 'eventreg_ros', 'run', SCENARIO, *arguments).stdout
        assert 'verdict: rejected' in out
        (file,) = (run.work / bag).glob('*.mcap')
        hashes.add(hashlib.sha256(samples(file)).hexdigest())
    assert len(hashes) == 1


def samples(file):
    """All samples of a bag, without the scenario's text, which names temporary files."""
    from eventreg_ros.bags.reader import read_bag

    signals = read_bag(file).signals
    return b''.join(signals[s][0].tobytes() + signals[s][1].tobytes() for s in sorted(signals))


def test_in_real_time_it_comes_to_a_verdict(run):
    arguments = (*FAST, '--duration', '9', '--settle', '40', '--bag', 'real')
    out = run('-m', 'eventreg_ros', 'run', SCENARIO, *arguments).stdout
    assert 'verdict: rejected' in out


def test_offline_tools_do_not_know_its_code(run):
    err = run('-m', 'eventreg_ros', 'simulate', SCENARIO, code=2).stderr
    assert 'plant is run by package own_plant' in err
    assert 'use eventreg run' in err


def test_an_executable_that_is_nowhere_is_one_line(run):
    arguments = ('-p', 'plant.executable:=nowhere', '--duration', '1')
    err = run('-m', 'eventreg_ros', 'run', SCENARIO, *arguments, code=2).stderr
    assert "plant: no executable 'nowhere' of package 'own_plant'" in err


def test_its_parameters_are_checked_by_the_node(run):
    found = run(
        '-m', 'own_plant.membrane', '--ros-args', '-p', 'leak:=-1.0', code=2
    )  # fmt: skip
    assert 'plant.leak must be a finite number > 0, got -1.0' in found.stderr


def test_composed_it_is_refused_with_the_way_out(run):
    arguments = ('--composed', '--duration', '1')
    err = run('-m', 'eventreg_ros', 'run', SCENARIO, *arguments, code=2).stderr
    assert 'got plant of another package; leave out --composed' in err


def test_its_own_parameter_is_set_while_it_runs(run):
    """The gain is 0 from the first sample on: the plant stays at rest."""
    at = ('--at', '0:plant.gain:=0', '--lockstep', '--duration', '16', '--bag', 'gain')
    run('-m', 'eventreg_ros', 'run', SCENARIO, *at, '--settle', '40')
    code = """
from eventreg_ros.bags.reader import read_bag
y = read_bag('gain').signals['y'][1]
assert len(y) > 3000 and abs(y[1:]).max() == 0.0
"""
    run('-c', code)
