# SPDX-License-Identifier: Apache-2.0
"""What tests of several parts share: signals with known events, bags of them, the command."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from eventreg_ros.bags.writer import write_bag
from eventreg_ros.cli.main import main

ROOT = Path(__file__).resolve().parent.parent

# Under nohup, or in the background of a script, some are ignored, also by what the tests start.
for number, handler in (
    (signal.SIGHUP, signal.SIG_DFL),
    (signal.SIGINT, signal.default_int_handler),
):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, handler)

ROS = ('nodes', 'session')
"""Directories whose tests all need ROS 2; elsewhere the mark stands at the test."""

FACTOR = float(os.environ.get('EVENTREG_FUZZ', '1'))
"""How many times as many generated cases are tried; `make fuzz` says 20."""

with suppress(ImportError):
    from hypothesis import HealthCheck, settings

    settings.register_profile(
        'eventreg', max_examples=int(100 * FACTOR), derandomize=FACTOR == 1.0, deadline=None,
        database=None, suppress_health_check=[HealthCheck.too_slow],
    )  # fmt: skip
    settings.load_profile('eventreg')

SCENARIO = """\
exosystem:
  ros__parameters: {}
plant:
  ros__parameters: {time_scale: 10.0, rate: 50.0}
controller:
  ros__parameters: {}
"""


def pytest_collection_modifyitems(items):
    """Keep what runs in real time in one process, so that it does not disturb itself."""
    for item in items:
        if item.path.parent.name in ROS and item.path.parent.parent == ROOT / 'test':
            item.add_marker(pytest.mark.ros)
        if item.get_closest_marker('ros') is not None:
            item.add_marker(pytest.mark.xdist_group('ros'))


def pytest_runtest_setup(item):
    """In a process of pytest-xdist, let what needs no punctuality step aside."""
    if 'PYTEST_XDIST_WORKER' in os.environ and item.get_closest_marker('ros') is None:
        os.nice(max(0, 5 - os.nice(0)))


def pulses(times, t):
    """A signal at rest at -1 that rises through 1 at each of ``times``, in a straight line."""
    x = np.full(len(t), -1.0)
    for start in times:
        x = np.maximum(x, 3.0 - 4.0 * np.abs(t - (start + 0.5)))
    return x


@pytest.fixture(name='pulses')
def _pulses():
    return pulses


def stamped(signals, time_scale=10.0):
    """The signals with stamps in nanoseconds for their model times."""
    return {
        name: (np.rint(np.asarray(t) * (1e9 / time_scale)).astype(np.int64).tolist(), x)
        for name, (t, x) in signals.items()
    }


@pytest.fixture(name='stamped')
def _stamped():
    return stamped


@pytest.fixture
def loop_signals():
    """Make signals over model time, every 0.2 until ``end``, with events at the given times."""

    def make(end=260.0, **events):
        t = np.arange(round(end / 0.2) + 1) * 0.2
        return {name: (t, pulses(times, t)) for name, times in events.items()}

    return make


@pytest.fixture
def make_bag(tmp_path, loop_signals):
    """Write a bag of signals with events at the given times; return its path."""

    def make(name='bag', *, end=260.0, text=SCENARIO, storage='mcap', **events):
        write_bag(tmp_path / name, stamped(loop_signals(end, **events)), 'made', text, storage)
        return tmp_path / name

    return make


@pytest.fixture
def eventreg():
    """Run ``python -m eventreg_ros ARGUMENTS`` as a process."""

    def run(*arguments, **more):
        return python('-m', 'eventreg_ros', *map(str, arguments), **more)

    return run


@pytest.fixture
def refused(capsys):
    """Run the command, which refuses its arguments; return its one line."""

    def run(*arguments):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code
        captured = capsys.readouterr()
        assert code == 2
        assert captured.out == ''
        assert captured.err.endswith('\n')
        assert captured.err.count('\n') == 1
        assert captured.err.startswith('eventreg: ')
        return captured.err

    return run


@pytest.fixture
def spawn():
    """Start this Python with arguments as a process; it is ended with the test."""
    started = []

    def start(*arguments, **options):
        process = subprocess.Popen(
            [sys.executable, *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture(name='python')
def _python():
    return python


def python(*arguments, env=None, **more):
    """Run this Python with ``arguments`` so that it finds the package."""
    environment = {**(os.environ if env is None else env), 'PYTHONPATH': str(ROOT)}
    return subprocess.run(
        [sys.executable, *arguments],
        env=environment, capture_output=True, text=True, timeout=120, check=False, **more,
    )  # fmt: skip
