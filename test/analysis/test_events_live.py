# SPDX-License-Identifier: Apache-2.0
"""Live and offline detector give the same floats, whatever comes; with limits off, as ever."""

import itertools
import math

import numpy as np
import pytest

from eventreg_ros.analysis.events import EventDetector, detect, ending, rises
from eventreg_ros.analysis.signal import Signal

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

LIMITS = st.sampled_from(((1.0, 0.0), (0.5, -0.5), (1.0, -1.9), (1.9, 1.0), (1e-300, 0.0)))
SPECIAL = (math.nan, math.inf, -math.inf, 0.0, -0.0, 1.0, 0.5, -0.5, 1.9, -1.9, 1e308, -1e308)
NEXT = tuple(math.nextafter(x, to) for x in (0.0, 1.0) for to in (-9.0, 9.0))
VALUE = st.one_of(st.sampled_from((*SPECIAL, *NEXT)), st.floats(-2.0, 2.0))
# Runs of one value are plateaus; steps of 0 are equal stamps.
RUN = st.tuples(VALUE, st.integers(1, 3))
STEP = st.one_of(st.sampled_from((0.0, 0.1, 0.5)), st.floats(0.0, 3.0))
TIME = st.sampled_from((0.0, 0.1, 0.5, 1.0, 2.0)) | st.floats(0.0, 10.0)


@st.composite
def signals(draw):
    values = [x for x, count in draw(st.lists(RUN, max_size=30)) for _ in range(count)]
    t, times = draw(st.floats(-100.0, 1e6)), []
    for _ in values:
        t += draw(STEP)
        times.append(t)
    return times, values


def live(times, values, *limits):
    detector = EventDetector(*limits)
    found = [detector.push(t, x) for t, x in zip(times, values, strict=True)]
    found = [t for t in found if t is not None]
    assert detector.count == len(found)
    return found


def first_detector(times, values, threshold, reset):
    """The definition in as few words as it takes, without width and dead time."""
    armed, last, found = None, None, []
    for t, x in zip(times, values, strict=True):
        if not math.isfinite(x):
            continue
        if armed is None:
            armed = x < threshold
        elif armed and x >= threshold:
            found.append(last[0] + (threshold - last[1]) / (x - last[1]) * (t - last[0]))
            armed = False
        armed = armed or x <= reset
        last = t, x
    return found


@pytest.mark.slow
@hypothesis.given(signals(), LIMITS, TIME, TIME)
def test_offline_is_live_to_the_last_bit(signal, limits, refractory, min_width):
    found = detect(*signal, *limits, refractory, min_width)
    assert found == live(*signal, *limits, refractory, min_width)


@pytest.mark.slow
@hypothesis.given(signals(), LIMITS)
def test_how_a_signal_was_above(signal, limits):
    detector = EventDetector(*limits)
    for t, x in zip(*signal, strict=True):
        detector.push(t, x)
    assert detector.risen.longest == rises(*signal, *limits).width.max(initial=0.0)
    end = ending(Signal(*map(np.array, signal)), limits[0], math.inf)
    assert (detector.risen.since, detector.risen.last) == end


@pytest.mark.slow
@hypothesis.given(signals(), LIMITS)
def test_without_width_and_dead_time_nothing_is_new(signal, limits):
    expected = first_detector(*signal, *limits)
    assert detect(*signal, *limits) == live(*signal, *limits) == expected


@pytest.mark.slow
@hypothesis.given(signals(), LIMITS, TIME, TIME)
def test_what_the_limits_promise(signal, limits, refractory, min_width):
    found = rises(*signal, *limits)
    kept = found.events(refractory, min_width).tolist()
    start, width = found.start.tolist(), found.width.tolist()
    assert all(width[i] >= min_width for i in kept) or not min_width
    assert all(start[j] >= start[i] + refractory for i, j in itertools.pairwise(kept))
    dropped = set(range(len(start))) - set(kept)
    for i in dropped:  # each for a reason
        before = [start[j] for j in kept if j < i]
        assert width[i] < min_width or (before and start[i] < before[-1] + refractory)
