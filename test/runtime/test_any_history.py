# SPDX-License-Identifier: Apache-2.0
"""Inputs and messages, whatever comes in whatever order."""

import math
import struct
import sys

import pytest

from eventreg_ros.runtime.cdr import age_of, packed, unpacked, with_age
from eventreg_ros.runtime.sequenced_input import SequencedInput
from eventreg_ros.runtime.stamped_input import RESTART, StampedInput
from eventreg_ros.runtime.tick_grid import SECOND
from eventreg_ros.runtime.waiting_input import WaitingInput

pytestmark = pytest.mark.slow

hypothesis = pytest.importorskip('hypothesis')
given, st = hypothesis.given, hypothesis.strategies

PERIOD = 5_000_000
TIMEOUT = 0.5 * SECOND
STAMPS = st.integers(0, 200 * PERIOD) | st.sampled_from([0, 2**62, -(2**62)])
VALUES = st.floats(-2.0, 2.0) | st.floats() | st.sampled_from([0.0, 50.0, math.nan, math.inf])
NUMBERS = st.none() | st.integers(0, 50) | st.integers(0, 2**63)
HISTORY = st.lists(st.tuples(STAMPS, VALUES, NUMBERS), max_size=40)


# Samples by stamp ---------------------------------------------------------------------------------


@pytest.mark.parametrize('kind', [StampedInput, WaitingInput])
@given(history=HISTORY, limit=st.sampled_from([sys.float_info.max, 100.0, 1.0]), start=STAMPS)
def test_every_sample_is_counted_once_and_a_step_uses_what_was_there(kind, history, limit, start):
    found = kind()
    found.limit = limit
    believed = [found.push(*sample) for sample in history]
    dropped = found.dropped
    assert found.received + found.out_of_order + dropped.not_finite + dropped.out_of_range == len(
        history
    )
    assert sum(believed) + dropped.outliers <= found.received
    line = found.over(start, float(PERIOD), TIMEOUT, 8.0)
    if line is not None:
        assert math.isfinite(line[0])
        assert found.used < start + PERIOD
        assert start - found.used <= TIMEOUT
        assert found.used in {stamp for stamp, value, _ in history if abs(value) <= limit}


@given(
    samples=st.lists(
        st.tuples(st.integers(0, 100 * PERIOD), st.floats(-2.0, 2.0)),
        max_size=30, unique_by=lambda sample: sample[0],
    ),
    shuffle=st.randoms(use_true_random=False),
)  # fmt: skip
def test_the_order_of_arrival_does_not_matter_before_samples_are_due(samples, shuffle):
    mixed = list(samples)
    shuffle.shuffle(mixed)
    straight, found = WaitingInput(), WaitingInput()
    for arriving, each in ((sorted(samples), straight), (mixed, found)):
        each.lead = round(RESTART * SECOND)
        for sample in arriving:
            assert each.push(*sample)
    assert found.take(math.inf) == straight.take(math.inf) == sorted(samples)
    assert (found.out_of_order, found.late) == (0, 0)


@given(
    samples=st.lists(
        st.tuples(st.integers(0, 100 * PERIOD), st.floats(-2.0, 2.0)), min_size=1, max_size=30,
        unique_by=lambda sample: sample[0],
    ),
    later=st.lists(st.floats(-2.0, 2.0), max_size=5),
    n=st.integers(0, 100),
)  # fmt: skip
def test_a_step_does_not_know_what_comes_later(samples, later, n):
    found, more = StampedInput(), StampedInput()
    for each in (found, more):
        for sample in sorted(samples):
            each.push(*sample)
    for i, value in enumerate(later):
        more.push((101 + i) * PERIOD, value)
    line = found.over(n * PERIOD, float(PERIOD), TIMEOUT, 8.0)
    assert more.over(n * PERIOD, float(PERIOD), TIMEOUT, 8.0) == line


# Samples by number --------------------------------------------------------------------------------


@given(
    history=st.lists(st.tuples(st.none() | st.integers(0, 12), VALUES), max_size=30),
    delay=st.integers(0, 5),
    lead=st.integers(0, 5),
)
def test_samples_by_number_are_sound_and_complete_or_the_flaw_is_named(history, delay, lead):
    found, kept = SequencedInput(delay, lead), []
    for number, value in history:
        found.push(number, value)
        if found.flaw is None and number == len(kept):
            kept.append(value)
    assert found.received == len(kept)
    assert all(map(math.isfinite, kept))
    if found.flaw is None:  # what came twice is passed over
        assert all(number is not None and number < len(kept) for number, _ in history)
    for n in range(len(kept) + max(delay, lead)):
        assert found.has(n)
        at = n - max(delay, lead)
        assert found.newest(n) == (None if at < 0 else (at, kept[at]))
    assert not found.has(len(kept) + max(delay, lead))


# Messages -----------------------------------------------------------------------------------------


@given(
    value=st.floats(width=64) | st.sampled_from([math.nan, -0.0, 5e-324]),
    age=st.integers(-(10**12), 10**12),
)
def test_a_message_keeps_its_bits_and_its_age(value, age):
    bits = struct.pack('<d', value)
    message = packed(value)
    assert struct.pack('<d', unpacked(message)) == bits
    assert struct.pack('<d', unpacked(b'\0\0\0\0' + bits[::-1])) == bits, 'the other byte order'
    aged = with_age(message, age)
    assert struct.pack('<d', unpacked(aged)) == bits
    wanted = min(max(age, 0), 65_534_000_000)
    assert abs(age_of(aged) - wanted) <= (50_000 if wanted < 3_276_750_000 else 1_000_000)
