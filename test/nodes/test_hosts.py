# SPDX-License-Identifier: Apache-2.0
"""Three hosts in network namespaces: what their links do to datagrams, and the loop's verdict."""

import functools
import importlib.util
import json
import math
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from eventreg_ros.runtime.relay import Impairment

ROOT = Path(__file__).resolve().parent.parent.parent
BENCH = ROOT / 'bench'


@pytest.fixture(scope='module')
def netns():
    """The module bench/netns.py, where the machine allows what it needs."""
    spec = importlib.util.spec_from_file_location('netns', BENCH / 'netns.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    reason = module.unavailable()
    if reason:
        pytest.skip(reason)
    return module


@pytest.fixture
def start(netns, spawn):
    """Start a script of ours as a process; it and its namespaces end with the test."""
    paths = os.pathsep.join(map(str, (ROOT, BENCH)))
    return functools.partial(spawn, env={**os.environ, 'PYTHONPATH': paths})


def finished(process):
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return json.loads(out)


LINKS = """
import json, subprocess, sys
import netns
from netns import Hosts, Impairment, round_trips

netns.enter()
found = {}
with Hosts(['one', 'other']) as hosts:
    for name, impairment in {
        'late': Impairment(delay=0.02, jitter=0.01, order='any'),
        'lossy': Impairment(loss=0.3, order='any'),
        'doubled': Impairment(duplicate=0.3, order='any'),
    }.items():
        hosts.impair(impairment)
        found[name] = round_trips(hosts, 'one', 'other', 400)
    for where in ([], hosts.within('one')):
        listed = subprocess.run([*where, 'ip', '-json', 'link'], capture_output=True, check=True)
        found['interfaces'] = found.get('interfaces', []) + [
            link['ifname'] for link in json.loads(listed.stdout) if 'UP' in link['flags']
        ]
print(json.dumps(found))
"""


def test_the_links_delay_drop_and_double_datagrams_and_lead_nowhere_else(start, tmp_path):
    (tmp_path / 'links.py').write_text(LINKS)
    found = finished(start(tmp_path / 'links.py'))
    late = found['late']
    assert len(late) == 400
    assert min(copies[0] for copies in late) >= 0.04
    # Two uniform jitters of up to 10 ms: their sum has mean 10 ms and deviation 4.1 ms. Whatever
    # the machine adds makes it longer.
    assert sum(copies[0] for copies in late) / 400 >= 0.05 - 5.0 * 0.0041 / 20.0
    expect_rate(len(found['lossy']), 400, 0.7 * 0.7)
    assert len(found['doubled']) == 400
    # One copy comes back when neither way doubled it.
    single = sum(len(copies) == 1 for copies in found['doubled'])
    expect_rate(single, 400, 0.7 * 0.7)
    assert set(found['interfaces']) <= {'lo', 'eth0', 'bridge', 'to_one', 'to_other'}


def expect_rate(found, trials, p):
    """Five standard deviations of the binomial law."""
    assert abs(found - trials * p) <= 5.0 * math.sqrt(trials * p * (1.0 - p))


def test_the_loop_on_three_hosts_rejects_over_a_lossy_link_without_multicast(start, tmp_path):
    arguments = ['--delay', '10', '--loss', '0.05', '--qos', 'best effort']
    process = start(BENCH / 'hosts.py', *arguments, '--json', str(tmp_path / 'table.json'))
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    found = json.loads((tmp_path / 'table.json').read_text())
    (cell,) = found['cells']
    assert 'error' not in cell, cell['error']
    assert cell['rejection']['disturbance_events'] == 3
    assert cell['verdict'] == 'rejected'
    assert found['multicast'] in (0, None)
    # The blocks felt the link: their own diagnostics say so.
    links = {'plant': ('w', 'u'), 'controller': ('y',)}
    for node, signals in links.items():
        for signal_ in signals:
            assert float(cell['measured'][node][f'{signal_}.age.p50']) >= 0.01
            assert int(cell['measured'][node][f'{signal_}.lost']) > 0
    assert 'rejected, 0 of 3' in out


HOLD = """
import signal
import time
import netns

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's jobs are born ignoring it
netns.enter()
with netns.Hosts(['one', 'other']) as hosts:
    commands = [hosts.within(name) for name in ('one', 'other')]
    print(*(words[words.index('--target') + 1] for words in commands), flush=True)
    time.sleep(60)
"""


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGINT])
def test_nothing_is_left_behind_however_it_ends(start, tmp_path, number):
    (tmp_path / 'hold.py').write_text(HOLD)
    process = start(tmp_path / 'hold.py')
    holders = [int(word) for word in process.stdout.readline().split()]
    held = {namespace(pid) for pid in (process.pid, *holders)}
    assert len(held) == 3
    assert namespace(os.getpid()) not in held
    process.send_signal(number)
    process.wait(timeout=20)
    end = time.monotonic() + 20.0
    while held & {namespace(int(pid)) for pid in os.listdir('/proc') if pid.isdigit()}:
        assert time.monotonic() < end, 'a process still holds a namespace'
        time.sleep(0.02)


def namespace(pid):
    """The network namespace of a process, None when there is no such process."""
    try:
        return os.stat(f'/proc/{pid}/ns/net').st_ino
    except OSError:
        return None


def test_netem_gets_the_same_delay_and_jitter_in_its_own_words(netns):
    # tc's jitter is plus or minus around its delay; ours begins at the delay.
    words = netns.netem(Impairment(delay=0.01, jitter=0.004, loss=0.05, duplicate=0.01))
    assert ' '.join(words) == 'netem limit 100000 delay 12000us 2000us loss 5% duplicate 1%'
    assert ' '.join(netns.netem(Impairment())) == 'netem limit 100000 delay 0us'
    command = [*netns.unshare(), 'tc', 'qdisc', 'replace', 'dev', 'lo', 'root', *words]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 or 'qdisc kind is unknown' in done.stderr  # no sch_netem here
