# SPDX-License-Identifier: Apache-2.0
"""Files in shared memory: those of living processes stay, those that only the dead had go."""

import mmap
import os
import subprocess
import sys

import pytest

from eventreg_ros import files
from eventreg_ros.session import shared_memory
from eventreg_ros.session.shared_memory import HOME, NOTES, Notes, remove_noted, sweep, used_by

pytestmark = pytest.mark.skipif(not os.access(HOME, os.W_OK), reason='no /dev/shm')

DOMAIN = 250
"""A domain that no run and no ROS node can have; its ports are only names here."""


@pytest.fixture
def memory():
    """Make a file of shared memory, of this process or of nobody; all go in the end."""
    made, maps = [], []

    def make(name, ours):
        path = HOME / name
        path.write_bytes(bytes(4096))
        made.append(path)
        if ours:
            with open(path, 'r+b') as file:
                maps.append(mmap.mmap(file.fileno(), 0))
        return path

    yield make
    for each in maps:
        each.close()
    for path in made:
        path.unlink(missing_ok=True)


def test_what_a_living_process_has_stays_and_what_nobody_has_goes(memory, tmp_path):
    first = 7400 + 250 * DOMAIN
    held = memory(f'fastrtps_port{first + 11}', ours=True)
    left = [
        memory(f'fastrtps_port{first + 13}', ours=False),
        memory(f'fastrtps_port{first + 13}_el', ours=False),
        memory(f'sem.fastrtps_port{first + 13}_mutex', ours=False),
    ]
    of_others = memory(f'fastrtps_port{first + 999}', ours=False)
    Notes(tmp_path, DOMAIN).take([os.getpid()])
    assert held.name in used_by([os.getpid()])
    remove_noted(tmp_path)
    assert held.exists()
    assert of_others.exists()
    assert not any(path.exists() for path in left)


def test_segments_are_noted_while_their_process_lives(memory, tmp_path):
    segment = f'fastrtps_{os.getpid():016x}'
    code = (
        'import mmap, sys\n'
        f'file = open("{HOME / segment}", "r+b"); held = mmap.mmap(file.fileno(), 0)\n'
        'print("held", flush=True); sys.stdin.read()\n'
    )
    path = memory(segment, ours=False)
    pipes = {'stdin': subprocess.PIPE, 'stdout': subprocess.PIPE}
    with subprocess.Popen([sys.executable, '-c', code], **pipes) as process:
        process.stdout.readline()
        Notes(tmp_path, DOMAIN).take([process.pid])
        remove_noted(tmp_path)
        assert path.exists()
        process.kill()
    remove_noted(tmp_path)
    assert not path.exists()


def test_what_a_dead_run_noted_goes_with_the_next_run(memory, tmp_path, monkeypatch):
    monkeypatch.setattr(files.tempfile, 'tempdir', str(tmp_path))
    with subprocess.Popen([sys.executable, '-c', '']) as gone:
        pass
    first = 7400 + 250 * DOMAIN
    left = memory(f'fastrtps_port{first + 17}', ours=False)
    dead = tmp_path / f'{files.SCRATCH}{gone.pid}_x'
    dead.mkdir()
    Notes(dead, DOMAIN).take([])
    sweep()
    assert not left.exists()
    with files.scratch_directory() as scratch:
        assert list(tmp_path.iterdir()) == [scratch]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('name', ['../etc', 'other', 'fastrtps_/../x', '', '/etc/passwd'])
def test_notes_that_somebody_forged_name_nothing_else(memory, tmp_path, name, monkeypatch):
    monkeypatch.setattr(shared_memory, '_is_ours', lambda path: pytest.fail(f'looked at {path}'))
    (tmp_path / NOTES).write_text(name)
    remove_noted(tmp_path)
