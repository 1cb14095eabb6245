# SPDX-License-Identifier: Apache-2.0
"""Stimuli of any numbers, and csv files of any text."""

import math
from itertools import pairwise

import pytest

from eventreg_ros.errors import EventregError, ParameterError
from eventreg_ros.simulation.stimulus import MAX_BREAKS, Stimulus, read_points

pytestmark = pytest.mark.slow

hypothesis = pytest.importorskip('hypothesis')
given, st = hypothesis.given, hypothesis.strategies

NUMBER = st.floats().map(repr) | st.sampled_from(['', ' 1 ', '1e5', '-0', '1_0', 'nan', 't', 'v'])
LINES = st.lists(st.lists(NUMBER, min_size=1, max_size=3).map(','.join), max_size=6)


@pytest.fixture(scope='module')
def file(tmp_path_factory):
    return tmp_path_factory.mktemp('csv') / 'v.csv'


@given(data=st.binary(max_size=60) | LINES.map(lambda lines: '\n'.join(lines).encode()))
def test_any_file_is_points_in_order_or_refused(file, data):
    file.write_bytes(data)
    try:
        points = read_points(str(file))
    except ParameterError:
        return
    assert points
    assert all(math.isfinite(t) and math.isfinite(v) for t, v in points)
    assert all(a[0] < b[0] for a, b in pairwise(points))
    stimulus = Stimulus('csv', points=points)
    for t, v in points:
        if abs(v) < 1e300:
            assert stimulus(t) == pytest.approx(v, rel=1e-12, abs=1e-12)


@st.composite
def pulses(draw):
    """Onsets, widths and periods that may touch, overlap, or lie before 0."""
    length = st.sampled_from([0.1, 1.0, 1.0 / 3.0, 10.0]) | st.floats(0.01, 50.0)
    if draw(st.booleans()):
        at = st.floats(-100.0, 100.0)
        return Stimulus('square', period=draw(length), phase=draw(at), width=draw(length))
    onsets = draw(st.lists(st.floats(-10.0, 100.0), max_size=6))
    return Stimulus('pulses', onsets=tuple(sorted(onsets)), width=draw(length))


@given(stimulus=pulses(), end=st.floats(0.0, 100.0))
def test_between_its_breaks_a_pulse_does_not_jump(stimulus, end):
    try:
        found = stimulus.breaks(end)
    except EventregError:
        assert 2.0 * end / stimulus.period > MAX_BREAKS
        return
    assert found == sorted(set(found))
    assert all(0.0 < t < end for t in found)
    for a, b in pairwise([0.0, *found, end]):
        if b - a > 1e-9:  # closer ones are one, written twice by rounding
            assert len({stimulus(a + part * (b - a)) for part in (0.1, 0.5, 0.9)}) == 1, (a, b)
