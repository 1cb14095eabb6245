# SPDX-License-Identifier: Apache-2.0
"""Signals in a run: noted and looked at, never lost, and kept out while all is stopped."""

import os
import signal

import pytest

from eventreg_ros.session import interruption
from eventreg_ros.session.interruption import (
    InterruptError,
    Interruption,
    handling,
    uninterrupted,
)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_is_noted_until_somebody_looks(number):
    noted = Interruption()
    before = signal.getsignal(number)
    with handling(noted):
        noted.look()
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        with pytest.raises(InterruptError):
            noted.look()
    assert signal.getsignal(number) is before


@pytest.mark.parametrize(('later', 'breaks_in'), [(1.0, False), (3.0, True), (29.0, True)])
def test_a_second_signal_breaks_in_after_two_seconds(monkeypatch, later, breaks_in):
    now = 100.0
    monkeypatch.setattr(interruption.time, 'monotonic', lambda: now)
    noted = Interruption()
    noted(signal.SIGINT, None)
    now += later
    if breaks_in:
        with pytest.raises(InterruptError):
            noted(signal.SIGINT, None)
    else:
        noted(signal.SIGINT, None)
    with pytest.raises(InterruptError):  # noted all the same
        noted.look()


def test_nothing_stops_the_stopping():
    with uninterrupted():
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            os.kill(os.getpid(), number)


def test_what_was_ignored_stays_ignored(monkeypatch):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        noted = Interruption()
        with handling(noted):
            os.kill(os.getpid(), signal.SIGHUP)
            noted.look()
    finally:
        signal.signal(signal.SIGHUP, before)
