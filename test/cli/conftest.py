# SPDX-License-Identifier: Apache-2.0
"""Starting ``eventreg run`` as a process, and finding the nodes that it started."""

import os

import pytest


@pytest.fixture
def run(spawn, tmp_path):
    """Start ``eventreg run`` on a free domain of the loopback; nothing of it outlives the test."""
    environment = {k: v for k, v in os.environ.items() if k != 'ROS_DOMAIN_ID'}

    def start(*arguments):
        return spawn(
            '-m', 'eventreg_ros', 'run', *arguments,
            env=environment, cwd=tmp_path, start_new_session=True,
        )  # fmt: skip

    return start


@pytest.fixture(name='children')
def _children():
    return children


def children(process):
    """The node processes of a run, by node."""
    found = {}
    for pid in (int(entry) for entry in os.listdir('/proc') if entry.isdigit()):
        try:
            with open(f'/proc/{pid}/stat') as file:
                parent = int(file.read().rpartition(')')[2].split()[1])
            with open(f'/proc/{pid}/cmdline') as file:
                words = file.read().split('\0')
        except OSError:
            continue
        if parent == process.pid:
            found.update({w.rpartition('.')[2]: pid for w in words if '.nodes.' in w})
    return found
