# SPDX-License-Identifier: Apache-2.0
"""The nodes of a run as processes of their own: started, watched, and always ended."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from .. import interrupts

PATIENCE = 10.0
"""Seconds that a process is given to end by itself after SIGTERM."""

_PR_SET_PDEATHSIG = 1


@dataclass
class Processes:
    """Named child processes. Each ends with its parent, however that ends."""

    running: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)
    died: dict[str, str] = field(default_factory=dict)

    def start(self, name: str, command: Sequence[str], environment: dict[str, str]) -> None:
        """Start ``command`` in a session of its own, so that Ctrl-C reaches only the parent.

        Signals wait until one of our nodes can take them; others could leave them waiting.
        """
        ours = command[1:2] == ['-m'] and command[2].startswith('eventreg_ros.')
        self.running[name] = subprocess.Popen(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=_first(ours),
        )

    def look(self) -> list[str]:
        """Return the names of processes that ended since the last look; how is in ``died``."""
        fresh = []
        for name, process in self.running.items():
            code = process.poll()
            if code is not None and name not in self.died:
                self.died[name] = how_it_ended(code)
                fresh.append(name)
        return fresh

    def stop(self, names: Sequence[str] | None = None) -> None:
        """Ask processes to end (SIGTERM), wait for them, kill those that do not."""
        self.look()
        ending = [
            process
            for name, process in self.running.items()
            if (names is None or name in names) and process.poll() is None
        ]
        for process in ending:
            process.terminate()
            process.send_signal(signal.SIGCONT)  # one that was stopped ends too
        deadline = time.monotonic() + PATIENCE
        for process in ending:
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        for name in names if names is not None else list(self.running):
            self.running.pop(name, None)


def how_it_ended(code: int) -> str:
    """Say in words how a process with return code ``code`` ended."""
    if code >= 0:
        return f'ended with exit code {code}'
    try:
        return f'was killed by {signal.Signals(-code).name}'
    except ValueError:
        return f'was killed by signal {-code}'


def node_command(node: str, arguments: Sequence[str], names: Sequence[str] = ()) -> list[str]:
    """Return the command that runs one of our nodes, with ``names`` and then ROS ``arguments``."""
    module = f'eventreg_ros.nodes.{node}'
    return [sys.executable, '-m', module, *names, '--ros-args', *arguments]


def _first(ours: bool) -> Callable[[], None] | None:
    """Return what a child does first, on Linux: ask for SIGTERM when its parent dies."""
    if not sys.platform.startswith('linux'):
        return None
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    parent = os.getpid()

    def ask() -> None:
        if ours:
            interrupts.block()
        prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:
            os._exit(1)

    return ask
