# SPDX-License-Identifier: Apache-2.0
"""A second signal breaks in where nobody looks, after the time that is meant for it."""

import signal

import pytest

from eventreg_ros.session import session


@pytest.mark.parametrize(('later', 'breaks_in'), [(1.0, False), (3.0, True), (29.0, True)])
def test_a_second_signal_breaks_in_after_two_seconds(monkeypatch, later, breaks_in):
    now = 100.0
    monkeypatch.setattr(session.time, 'monotonic', lambda: now)
    interruption = session.Interruption()
    interruption(signal.SIGINT, None)
    now += later
    if breaks_in:
        with pytest.raises(session.InterruptError):
            interruption(signal.SIGINT, None)
    else:
        interruption(signal.SIGINT, None)
    with pytest.raises(session.InterruptError):  # noted all the same
        interruption.look()
