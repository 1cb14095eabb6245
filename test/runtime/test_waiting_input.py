# SPDX-License-Identifier: Apache-2.0
"""Samples that come ahead of their time: what a step plays, and what came too late."""

import pytest

from eventreg_ros.runtime.stamped_input import StampedInput
from eventreg_ros.runtime.tick_grid import SECOND
from eventreg_ros.runtime.waiting_input import WaitingInput

PERIOD = 5_000_000
TIMEOUT = 0.5 * SECOND


def ahead(lead, *pairs):
    found = WaitingInput()
    found.lead = lead * PERIOD
    for stamp, value in pairs:
        found.push(round(stamp * PERIOD), value)
    return found


def over(found, n, horizon=8.0):
    return found.over(n * PERIOD, float(PERIOD), TIMEOUT, horizon)


RAMP = tuple((k + 0.1, 0.5 * k) for k in range(20))


def test_every_sample_is_played_a_lead_after_its_stamp_on_the_line_of_ever():
    waiting, prompt = ahead(4, *RAMP), StampedInput()
    for k, (stamp, value) in enumerate(RAMP):
        prompt.push(round(stamp * PERIOD), value)
        expected = prompt.over(k * PERIOD, float(PERIOD), TIMEOUT, 8.0)
        assert over(waiting, k + 4) == expected
    assert waiting.late == 0


def test_before_the_first_is_due_there_is_nothing_and_nobody_is_silent():
    found = ahead(200, *RAMP)
    assert over(found, 150) is None
    assert not found.begun
    assert over(found, 200) == (0.0, 0.0)
    assert found.begun
    assert over(found, 219 + 101) is None, 'silent after the last one was played'


def test_what_is_overtaken_on_the_way_is_played_in_its_place():
    shuffled = [RAMP[k] for k in (0, 3, 1, 2, 7, 5, 4, 6)]
    straight, found = ahead(8, *RAMP[:8]), ahead(8, *shuffled)
    assert [over(found, n) for n in range(8, 16)] == [over(straight, n) for n in range(8, 16)]
    assert (found.received, found.out_of_order, found.late) == (8, 0, 0)


def test_what_comes_after_its_time_is_counted_and_the_newest_is_held():
    found = ahead(2, *RAMP[:3])
    assert over(found, 4) == (1.0, 0.5)
    assert over(found, 5, 0.0) == (1.0, 0.0)
    assert not found.push(round(2.5 * PERIOD), 9.0), 'overtaken by what was played'
    found.push(round(3.1 * PERIOD), 1.5)
    assert found.late == 2
    assert over(found, 6, 0.0) == (1.5, 0.0)


@pytest.mark.parametrize('wild', [float('nan'), float('inf'), 60.0])
def test_an_overtaken_sample_is_looked_at_like_any_other(wild):
    found = ahead(8, RAMP[0], RAMP[2])
    found.limit = 100.0
    assert not found.push(round(1.1 * PERIOD), wild)
    assert sum(found.dropped) == 1
    assert over(found, 10)[0] == 1.0


def test_a_number_that_was_missing_is_not_lost_when_it_comes():
    found = WaitingInput()
    found.lead = 8 * PERIOD
    for k in (0, 1, 3, 2, 4):
        found.push(k * PERIOD, 0.1 * k, k)
    assert (found.received, found.lost) == (5, 0)


def test_a_clock_that_went_back_begins_anew():
    found = ahead(0, *RAMP)
    over(found, 30)
    back = -2 * SECOND
    assert found.push(back, 7.0) is not None
    assert found.over(back, float(PERIOD), TIMEOUT, 8.0) == (7.0, 0.0)
