# SPDX-License-Identifier: Apache-2.0
"""Child processes: started, watched, ended, never left behind."""

import os
import signal
import subprocess
import sys
import time

import pytest

from eventreg_ros.session import processes
from eventreg_ros.session.processes import Processes, how_it_ended, node_command

SLEEP = [sys.executable, '-S', '-c', 'import time; time.sleep(60)']
STUBBORN = [
    sys.executable, '-S', '-c',
    'import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN)\n'
    'print("ready", flush=True); time.sleep(60)',
]  # fmt: skip
GENTLE = [
    sys.executable, '-S', '-c',
    'import signal, sys, time; signal.signal(signal.SIGTERM, lambda *_: sys.exit(7))\n'
    'print("ready", flush=True); time.sleep(60)',
]  # fmt: skip


@pytest.fixture
def children():
    group = Processes()
    yield group
    for process in group.running.values():
        process.kill()
        process.wait()


def until(done):
    """Wait for something that another process does; the limit only ends a test that fails."""
    end = time.monotonic() + 20.0
    while not done():
        assert time.monotonic() < end, 'gave up waiting'
        time.sleep(0.005)


def is_gone(pid):
    """Say whether a process has ended (a zombie that waits for its parent has)."""
    try:
        with open(f'/proc/{pid}/stat', encoding='ascii') as file:
            return file.read().rpartition(')')[2].split()[0] in 'ZX'
    except FileNotFoundError:
        return True


def start(group, name, command, capfd=None):
    """Start a child; with ``capfd`` wait until it says that it is ready."""
    group.start(name, command, dict(os.environ))
    said = ''
    while capfd and 'ready' not in said:
        said += capfd.readouterr().out
        time.sleep(0.005)
    return group.running[name]


def test_children_run_until_they_are_stopped(children):
    first, second = start(children, 'a', SLEEP), start(children, 'b', SLEEP)
    assert children.look() == []
    children.stop()
    assert (first.returncode, second.returncode) == (-signal.SIGTERM, -signal.SIGTERM)
    assert children.running == {}
    assert children.died == {}  # they did not die, they were asked to end


def test_some_are_stopped_before_the_others(children):
    first, second = start(children, 'a', SLEEP), start(children, 'b', SLEEP)
    children.stop(['a'])
    assert first.returncode == -signal.SIGTERM
    assert second.poll() is None
    assert list(children.running) == ['b']
    children.stop(['nobody'])
    assert second.poll() is None


def test_who_died_is_reported_once_and_how(children):
    process = start(children, 'plant', SLEEP)
    start(children, 'other', SLEEP)
    process.kill()
    process.wait()
    assert children.look() == ['plant']
    assert children.look() == []
    assert children.died == {'plant': 'was killed by SIGKILL'}
    children.stop()


def test_who_ended_by_itself_is_known_when_all_are_stopped(children):
    process = start(children, 'plant', [sys.executable, '-S', '-c', 'raise SystemExit(3)'])
    process.wait()
    children.stop()
    assert children.died == {'plant': 'ended with exit code 3'}


def test_a_child_may_clean_up(children, capfd):
    process = start(children, 'gentle', GENTLE, capfd)
    children.stop()
    assert process.returncode == 7


def test_a_stubborn_child_is_killed(children, capfd, monkeypatch):
    monkeypatch.setattr(processes, 'PATIENCE', 0.1)
    stubborn = start(children, 'stubborn', STUBBORN, capfd)
    gentle = start(children, 'gentle', GENTLE, capfd)
    children.stop()
    assert stubborn.returncode == -signal.SIGKILL
    assert gentle.returncode == 7
    assert children.running == {}


def test_children_have_a_session_of_their_own(children):
    process = start(children, 'a', SLEEP)
    assert os.getsid(process.pid) == process.pid  # Ctrl-C does not reach it
    children.stop()


def test_children_get_the_environment_and_no_input(children, tmp_path):
    file = tmp_path / 'said'
    code = (
        'import os, sys; print(os.environ["DOMAIN"], repr(sys.stdin.read()), '
        f'file=open({str(file)!r}, "w"))'
    )
    command = [sys.executable, '-S', '-c', code]
    children.start('a', command, {**os.environ, 'DOMAIN': '7'})
    children.running['a'].wait()
    assert file.read_text() == "7 ''\n"


PARENT = """
import os, signal, sys, time
from eventreg_ros.session.processes import Processes
group = Processes()
for name in 'abc':
    group.start(name, [sys.executable, '-S', '-c', 'import time; time.sleep(60)'], dict(os.environ))
print(*(process.pid for process in group.running.values()), flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(not sys.platform.startswith('linux'), reason='needs PR_SET_PDEATHSIG of Linux')
@pytest.mark.parametrize('end', [signal.SIGKILL, signal.SIGTERM])
def test_children_end_with_their_parent_however_it_ends(end):
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    command = [sys.executable, '-c', PARENT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as parent:
        pids = [int(pid) for pid in parent.stdout.readline().split()]
        assert len(pids) == 3
        assert not any(is_gone(pid) for pid in pids)
        parent.send_signal(end)
        parent.wait()
    until(lambda: all(is_gone(pid) for pid in pids))


@pytest.mark.parametrize(
    ('code', 'words'),
    [
        (0, 'ended with exit code 0'),
        (2, 'ended with exit code 2'),
        (-9, 'was killed by SIGKILL'),
        (-11, 'was killed by SIGSEGV'),
        (-250, 'was killed by signal 250'),
    ],
)
def test_how_it_ended(code, words):
    assert how_it_ended(code) == words


def test_the_command_of_a_node():
    command = node_command('plant', ['-p', 'k:=2.0'])
    assert command == [
        sys.executable, '-m', 'eventreg_ros.nodes.plant', '--ros-args', '-p', 'k:=2.0',
    ]  # fmt: skip
