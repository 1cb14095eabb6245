# SPDX-License-Identifier: Apache-2.0
"""What was seen and what was not, of any history: by definition, instant by instant, and live."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from eventreg_ros.analysis.evidence import coverage_of, gather
from eventreg_ros.analysis.live import LiveJudge
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.scenario import Criteria

pytestmark = pytest.mark.slow

hypothesis = pytest.importorskip('hypothesis')
given, st = hypothesis.given, hypothesis.strategies

BLIND = 5.0
STEPS = st.sampled_from([0.0, 0.5, 1.0, BLIND, math.nextafter(BLIND, 9.0), 7.0, 40.0])
VALUES = st.sampled_from([0.0, 0.5, 2.0, math.nan, math.inf])
HISTORY = st.lists(st.tuples(STEPS | st.floats(0.0, 20.0), VALUES), max_size=25)
SPANS = st.tuples(st.floats(-10.0, 100.0), st.floats(0.0, 100.0)).map(lambda s: (s[0], sum(s)))


def signal_of(history):
    steps = np.array([step for step, _ in history], dtype=np.float64)
    return Signal(np.cumsum(steps), np.array([x for _, x in history], dtype=np.float64))


def judged(coverage, span):
    subject = replace(subject_by_name(['w', 'y'], Criteria(blind=BLIND)), duration=None)
    everything = coverage_of(Signal(np.arange(-20.0, 300.0), np.zeros(320)), BLIND)
    return gather(subject, {'y': coverage, 'w': everything}, span, span[1])


@given(history=HISTORY, span=SPANS)
def test_an_instant_is_unseen_where_no_two_samples_near_each_other_enclose_it(history, span):
    signal = signal_of(history)
    evidence = judged(coverage_of(signal, BLIND), span)
    t = signal.t[np.isfinite(signal.x)].tolist()
    edges = sorted({*span, *(at for at in t if span[0] < at < span[1])})
    unseen = 0.0
    for a, b in pairwise(edges):  # no sample is between them
        before = max((at for at in t if at <= a), default=None)
        after = min((at for at in t if at >= b), default=None)
        start = span[0] if before is None else before
        stop = span[1] if after is None else after
        blind = (before is None and after is None) or stop - start > BLIND
        middle = a + (b - a) / 2.0
        if a < middle < b:
            assert evidence.was_seen('y', middle, middle) is not blind, (a, b)
        unseen += (b - a) * blind
    length = span[1] - span[0]
    if length > 0.0:
        assert evidence.seen['y'] == pytest.approx(1.0 - unseen / length, abs=1e-9)


@given(history=HISTORY)
def test_live_and_afterwards_the_same_was_seen(history):
    signal = signal_of(history)
    live = LiveJudge(replace(subject_by_name(['w', 'y'], Criteria(blind=BLIND)), duration=None))
    live.rescale(0.0, 1.0)
    live.saw('w', 0.0, 0.0)  # t = 0
    for t, x in zip(signal.t.tolist(), signal.x.tolist(), strict=True):
        live.saw('y', t, x)
    end = float(signal.t[-1]) if len(signal.t) else 0.0
    found, expected = live._seen['y'].coverage(end), coverage_of(signal, BLIND)
    assert found == expected
