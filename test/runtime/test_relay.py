# SPDX-License-Identifier: Apache-2.0
"""The wire: what it delays, loses, doubles and reorders, against the binomial law and by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from eventreg_ros.runtime.relay import ORDERS, Impairment, Relay

MS = 1_000_000


def leave(impairment, seed=0, count=20_000, period=5 * MS, until=math.inf):
    """Send 0, 1, ... over a wire, one per ``period``; return the wire and all departures."""
    wire = Relay(impairment, seed)
    gone = []
    for n in range(count):
        while wire.next_due is not None and wire.next_due <= n * period:
            gone += wire.pop(wire.next_due)
        wire.push(n * period, n)
    while wire.next_due is not None:
        gone += wire.pop(wire.next_due)
    return wire, gone


def expect_rate(found, trials, p):
    """Five standard deviations of the binomial law: one sound wire in 1.7 million fails."""
    assert abs(found - trials * p) <= 5.0 * math.sqrt(trials * p * (1.0 - p))


def test_every_sample_leaves_exactly_the_delay_after_it_came():
    wire, gone = leave(Impairment(delay=0.0201), count=100)
    assert [d.item for d in gone] == list(range(100))
    assert {d.due - d.entered for d in gone} == {20_100_000}
    assert (wire.received, wire.sent, wire.in_flight) == (100, 100, 0)


def test_nothing_leaves_before_it_is_due():
    wire = Relay(Impairment(delay=0.02))
    wire.push(0, 'a')
    assert wire.next_due == 20 * MS
    assert wire.pop(20 * MS - 1) == []
    assert wire.in_flight == 1
    assert [d.item for d in wire.pop(20 * MS)] == ['a']
    assert wire.next_due is None


@pytest.mark.slow
@pytest.mark.parametrize('p', [0.0, 0.01, 0.2, 0.9, 1.0])
def test_losses_and_duplicates_come_as_often_as_they_should(p):
    wire, gone = leave(Impairment(loss=p))
    expect_rate(wire.dropped, wire.received, p)
    assert len(gone) == wire.sent == wire.received - wire.dropped
    wire, gone = leave(Impairment(duplicate=p))
    expect_rate(wire.duplicated, wire.received, p)
    assert len(gone) == wire.sent == wire.received + wire.duplicated


def test_losses_are_independent_of_each_other_and_of_duplicates():
    _, gone = leave(Impairment(loss=0.3, duplicate=0.3))
    copies = np.bincount([d.item for d in gone], minlength=20_000)
    lost = copies == 0
    expect_rate(np.count_nonzero(lost[1:] & lost[:-1]), 19_999, 0.09)
    expect_rate(np.count_nonzero(copies == 2), 20_000, 0.7 * 0.3)
    assert copies.max() == 2


def test_jitter_is_uniform_above_the_delay():
    _, gone = leave(Impairment(delay=0.01, jitter=0.02, order='any'))
    late = np.array([d.due - d.entered for d in gone]) / (20 * MS) - 0.5
    assert len(late) == 20_000
    assert late.min() >= 0.0
    assert late.max() <= 1.0
    # The Kolmogorov-Smirnov distance exceeds 2.7 / sqrt(n) once in a million.
    distance = np.abs(np.sort(late) - np.arange(20_000) / 20_000).max()
    assert distance < 2.7 / math.sqrt(20_000)


@pytest.mark.slow
def test_the_order_is_what_was_asked_for():
    jittered = Impairment(delay=0.01, jitter=0.02)
    leaving = {order: leave(replace(jittered, order=order), seed=3) for order in ORDERS}
    numbers = {order: [d.item for d in gone] for order, (_, gone) in leaving.items()}
    assert sorted(numbers['any']) == list(range(20_000))
    assert numbers['any'] != sorted(numbers['any'])
    assert numbers['fifo'] == list(range(20_000))
    assert numbers['newest'] == sorted(set(numbers['newest']))
    wire, _ = leaving['newest']
    assert wire.overtaken == 20_000 - len(numbers['newest']) > 1_000
    # Those that stay are those that no later one overtook, as in links.received.
    due = {d.item: d.due for d in leaving['any'][1]}
    least = np.minimum.accumulate([due[n] for n in reversed(range(20_000))])[::-1]
    assert numbers['newest'] == [n for n in range(20_000) if due[n] <= least[n]]
    fifo = np.array([d.due for d in leaving['fifo'][1]])
    assert fifo.tolist() == np.maximum.accumulate([due[n] for n in range(20_000)]).tolist()


@pytest.mark.slow
def test_the_seed_decides_and_the_same_samples_are_lost_with_another_delay():
    harsh = Impairment(delay=0.01, jitter=0.02, loss=0.2, duplicate=0.1, order='any')
    assert leave(harsh, seed=4)[1] == leave(harsh, seed=4)[1]
    assert leave(harsh, seed=4)[1] != leave(harsh, seed=5)[1]
    lost = set(range(20_000)) - {d.item for d in leave(harsh, seed=4)[1]}
    gentle = Impairment(loss=0.2)
    assert lost == set(range(20_000)) - {d.item for d in leave(gentle, seed=4)[1]}


def test_a_new_impairment_holds_for_what_comes_from_then_on():
    wire = Relay(Impairment(delay=0.02, order='any'))
    wire.push(0, 'before')
    wire.impairment = Impairment(delay=0.001, order='any')
    wire.push(1 * MS, 'after')
    assert [(d.item, d.due) for d in wire.pop(50 * MS)] == [('after', 2 * MS), ('before', 20 * MS)]


def test_equal_times_leave_in_the_order_in_which_they_came():
    wire = Relay(Impairment())
    for item in 'abc':
        wire.push(7, item)
    assert [d.item for d in wire.pop(7)] == ['a', 'b', 'c']
