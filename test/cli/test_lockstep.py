# SPDX-License-Identifier: Apache-2.0
"""``eventreg run --lockstep``: processes and composed, one hash; and what ends it."""

import json
import os
import random
import re
import signal
from pathlib import Path

import pytest

from eventreg_ros.bags.reader import read_bag

pytest.importorskip('rclpy', reason='needs ROS 2: pip install .[ros]')

pytestmark = pytest.mark.ros

BENCH = Path(__file__).resolve().parents[2] / 'bench'


@pytest.fixture
def determinism(monkeypatch):
    """The module bench/determinism.py; the environment that it sets is undone."""
    monkeypatch.syspath_prepend(str(BENCH))
    import determinism

    with determinism.own_environment():
        yield determinism


@pytest.fixture
def stepping(run):
    """Start a run in lockstep that would go on for long; return it once steps are made."""

    def start(*arguments):
        process = run('exact', '--lockstep', '--duration', '100000', *arguments)
        assert 'clock' in process.stdout.readline()
        # Where many nodes start at once, Fast DDS may log that a port in memory was taken.
        assert any(' of 100000 s' in line for line in process.stdout)
        return process

    return start


def data(bag):
    return {
        name: (stamps.tobytes(), values.tobytes())
        for name, (stamps, values) in read_bag(bag).signals.items()
    }


def timeless(path):
    """The report without the timing, which a simulation does not have."""
    report = json.loads(path.read_text())
    for entry in report['signals'].values():
        entry.pop('timing', None)
    return report


def test_processes_composed_and_simulated_are_the_same_bytes(eventreg, tmp_path):
    bags, reports = [], []
    for words in (['run', '--lockstep'], ['run', '--lockstep', '--composed'], ['simulate']):
        bags.append(tmp_path / str(len(bags)))
        verb, *flags = words
        live = verb == 'run'
        length = ['--duration', '10'] if live else ['--sampled', '--duration', '100']
        times = ('3.021', '6', '6.5') if live else ('30.21', '60', '65')
        for at, action in zip(times, ('.k:=2', ':deactivate', ':activate'), strict=True):
            length += ['--at', f'{at}:controller{action}']
        reports.append(tmp_path / f'{len(bags)}.json')
        more = ['--bag', bags[-1], '--settle', '10', '--json', reports[-1]]
        done = eventreg(verb, 'mismatch', *flags, *length, *more)
        assert done.returncode == 3, done.stderr  # two events of w are too few
        reports.append(tmp_path / f'{len(bags)}_again.json')
        assert eventreg('analyze', bags[-1], '--json', reports[-1]).returncode == 3
    assert data(bags[0]) == data(bags[1]) == data(bags[2])
    found = [timeless(report) for report in reports]
    assert found[0]['settle'] == 10.0
    assert [change['at'] for change in found[0]['changes']] == [30.2, 60.0, 65.0]
    assert found == [found[0]] * 6  # every number, to the last digit


def test_a_duration_of_no_whole_steps_ends(eventreg, tmp_path):
    words = ['run', 'exact', '--lockstep', '--composed', '--bag', tmp_path / 'bag']
    done = eventreg(*words, '--duration', '0.0123')
    assert done.returncode == 3, done.stderr
    assert len(read_bag(tmp_path / 'bag').signals['y'][1]) == 3


def test_stamps_of_a_rate_of_no_whole_nanoseconds_are_the_same_too(eventreg, tmp_path):
    bags = [tmp_path / 'run', tmp_path / 'simulate']
    rate = ['-p', '/**.rate:=300', '--bag']
    eventreg('run', 'exact', '--lockstep', '--composed', '--duration', '1', *rate, bags[0])
    eventreg('simulate', 'exact', '--sampled', '--duration', '10', *rate, bags[1])
    assert data(bags[0]) == data(bags[1])


def test_a_block_killed_on_the_way_ends_the_run_and_keeps_the_bag(stepping, children, tmp_path):
    process = stepping('--bag', 'bag')
    os.kill(children(process)['plant'], signal.SIGKILL)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert 'plant was killed by SIGKILL' in err
    assert 'bag: bag' in out
    signals = read_bag(tmp_path / 'bag').signals
    assert {len(values) for _, values in signals.values()} == {len(signals['y'][1])}


def test_a_stopped_block_ends_the_run_within_its_limit_and_the_link_is_named(stepping, children):
    process = stepping('-p', '/**.lockstep_timeout:=4.0')
    plant = children(process)['plant']
    os.kill(plant, signal.SIGSTOP)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert 'waits for sample' in err
    assert re.search(r'sample \d+ of (input )?y', err), err


def test_a_stopped_recorder_ends_the_run_and_is_named(stepping, children, tmp_path):
    process = stepping('-p', '/**.lockstep_timeout:=2.0', '--bag', 'bag')
    os.kill(children(process)['recorder'], signal.SIGSTOP)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert 'recorder made no step' in err
    assert len(read_bag(tmp_path / 'bag').signals['y'][1]) > 1


@pytest.mark.parametrize('name', ['mismatch', 'open'])
@pytest.mark.parametrize('composed', [False, True])
def test_busy_cores_a_random_order_and_a_late_node_change_no_bit(
    determinism, tmp_path, name, composed
):
    with determinism.busy(os.cpu_count()):
        seed = random.randrange(1000)
        found = determinism.recorded(
            name, 5.0, tmp_path / 'bag', composed=composed, seed=seed, late=2.0
        )
    assert found == determinism.simulated(name, 5.0), f'seed {seed}'


@pytest.mark.parametrize('composed', [False, True])
def test_interventions_have_the_bits_of_the_simulation(eventreg, tmp_path, composed):
    def at(a, b, c):
        actions = (f'{a}:controller:deactivate', f'{b}:controller:activate', f'{c}:plant.k:=1.5')
        return [word for action in actions for word in ('--at', action)]

    bags = [tmp_path / 'run', tmp_path / 'simulate']
    how = ['--composed'] if composed else []
    seconds, model = ('--duration', '6'), ('--duration', '60')
    settle = ('--settle', '20', '--json', tmp_path / 'report.json', '--bag')
    eventreg('run', 'exact', '--lockstep', *how, *seconds, *at(2, 3.5, 5), *settle, bags[0])
    recorded = timeless(tmp_path / 'report.json')['changes']
    eventreg('simulate', 'exact', '--sampled', *model, *at(20, 35, 50), *settle, bags[1])
    assert data(bags[0]) == data(bags[1])
    asked = timeless(tmp_path / 'report.json')['changes']
    assert [(c['node'], c['what']) for c in asked] == [
        ('controller', 'deactivate'), ('controller', 'activate'), ('plant', 'k:=1.5'),
    ]  # fmt: skip
    assert [(c['node'], c['what']) for c in recorded] == [(c['node'], c['what']) for c in asked]
    assert recorded[2]['at'] == asked[2]['at'] == 50.0  # a parameter event says when it was
    for late, due in zip(recorded, asked, strict=True):  # a transition counts from its arrival
        assert due['at'] <= late['at'] < due['at'] + 10.0


ROBOTS = """
/r1/exosystem: {ros__parameters: {}}
/r1/plant: {ros__parameters: {}}
/r1/controller: {ros__parameters: {}}
r2:
  exosystem: {ros__parameters: {tau: 0.1}}
  plant: {ros__parameters: {}}
"""


def test_two_robots_in_their_namespaces_share_a_clock_and_are_judged_apart(eventreg, tmp_path):
    file, table = tmp_path / 'robots.yaml', tmp_path / 'table.json'
    file.write_text(ROBOTS)
    bags = [tmp_path / 'run', tmp_path / 'simulate']
    settle = ('--settle', '40', '--bag')
    run = ('run', file, '--lockstep', '--duration', '16', '--json', table)
    found = eventreg(*run, *settle, bags[0])
    assert found.returncode == 1, found.stderr
    plants = json.loads(table.read_text())['plants']
    assert plants['r1/y']['verdict'] == 'rejected'
    assert plants['r2/y']['verdict'] == 'not rejected'
    eventreg('simulate', file, '--sampled', '--duration', '160', *settle, bags[1])
    assert data(bags[0]) == data(bags[1])
    assert set(data(bags[0])) == {'r1/w', 'r1/y', 'r1/u', 'r2/w', 'r2/y'}
