# SPDX-License-Identifier: Apache-2.0
"""The event detector: by hand, at its edges, live against offline, and against the truth."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from eventreg_ros.analysis.events import EventDetector, detect, rises
from eventreg_ros.errors import EventregError, ParameterError


def events(values, threshold=1.0, reset=0.0, times=None, **more):
    """Return what the offline detector finds, which must be what the live one finds."""
    times = range(len(values)) if times is None else times
    found = detect(times, values, threshold, reset, **more)
    push = EventDetector(threshold, reset, **more).push
    live = [push(float(t), float(x)) for t, x in zip(times, values, strict=True)]
    assert found == [t for t in live if t is not None]
    return found


# By hand ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('values', 'found'),
    [
        ([], []),
        ([2.0], []),
        ([0.0, 2.0], [0.5]),
        ([0.0, 4.0], [0.25]),
        ([-3.0, 1.0], [1.0]),  # it is enough to reach the threshold
        ([0.0, 0.999], []),
        ([0.0, 2.0, 0.5, 2.0], [0.5]),  # not back at reset: the same event
        ([0.0, 2.0, 0.0, 2.0], [0.5, 2.5]),  # at reset: the next may begin
        ([0.0, 2.0, -1.0, 0.5, 0.9, 2.0], [0.5, 4 + 0.1 / 1.1]),
        ([0.0, 0.5, 2.0], [1 + 0.5 / 1.5]),
        ([0.0, 1.0, 1.0, 1.0, 2.0], [1.0]),  # a plateau at the threshold is one event
        ([0.0, 1.0, 0.5, 1.0, 0.0, 1.0], [1.0, 5.0]),
    ],
)
def test_threshold_and_reset(values, found):
    assert events(values) == pytest.approx(found, abs=1e-15)


@pytest.mark.parametrize(
    ('start', 'found'),
    [
        (2.0, [3.5]),  # above: only after it has been down
        (1.0, [3.5]),  # at the threshold: it is not below it
        (0.5, [0.5 / 1.5, 3.5]),  # below the threshold, above reset: it may rise at once
        (-1.0, [2 / 3, 3.5]),
    ],
)
def test_the_start(start, found):
    assert events([start, 2.0, 2.0, 0.0, 2.0]) == pytest.approx(found, abs=1e-15)


def test_a_start_above_reset_falls_to_reset_first():
    assert events([2.0, 0.5, 2.0]) == []
    assert events([2.0, 0.0, 2.0]) == [1.5]


def test_other_thresholds():
    wave = [-1.0, 0.6, -0.2, 0.6, -1.0, 0.6]
    assert events(wave, 0.5, 0.0) == pytest.approx([1.5 / 1.6, 2.875, 4.9375])
    assert events(wave, 0.5, -0.5) == pytest.approx([1.5 / 1.6, 4.9375])
    assert events(wave) == []


@pytest.mark.parametrize(('threshold', 'reset'), [(1.0, 1.0), (0.0, 1.0), (1.0, math.nan)])
def test_reset_must_lie_below_the_threshold(threshold, reset):
    with pytest.raises(ValueError, match='reset must be < threshold'):
        EventDetector(threshold, reset)


def test_the_time_of_a_crossing_is_exact_on_a_line_whatever_the_spacing():
    rng = np.random.default_rng(1)
    for _ in range(200):
        t = np.sort(rng.uniform(-10.0, 10.0, 30))
        slope, crossing = rng.uniform(0.1, 5.0), rng.uniform(t[0], t[-1])
        found = events(1.0 + slope * (t - crossing), 1.0, -1e9, t)
        assert found == pytest.approx([crossing], abs=1e-12)


def test_samples_that_are_not_finite_are_passed_over():
    values = [0.0, math.nan, 2.0, math.inf, 0.0, -math.inf, 2.0]
    clean = [v for v in values if math.isfinite(v)]
    times = [t for t, v in enumerate(values) if math.isfinite(v)]
    assert events(values) == events(clean, times=times) == [1.0, 5.0]
    assert events([math.nan, 0.5, 2.0]) == events([0.5, 2.0], times=[1, 2])
    assert events([math.nan] * 5) == []


def test_huge_values_and_equal_times():
    assert events([-1e308, 1e308]) == [0.0]  # the difference overflows, the time stays finite
    assert events([0.0, 2.0, 0.0, 2.0], times=[3.0] * 4) == [3.0, 3.0]


def test_an_event_that_rounding_puts_before_the_last_one_is_no_less_an_event():
    assert 0.6 + (1.8 - 0.6) > 1.8
    found = events([0.0, 1.0, 0.0, 2.0], times=[0.6, 1.8, 1.8, 1.8])
    assert found == [math.nextafter(1.8, 2.0), 1.8]


def test_times_and_values_must_be_as_many():
    with pytest.raises(EventregError, match='as many'):
        detect([0.0, 1.0], [0.0])


def test_live_equals_offline():
    rng = np.random.default_rng(2)
    for _ in range(50):
        t = np.cumsum(rng.exponential(1.0, 400))
        x = np.cumsum(rng.normal(0.0, 1.0, 400))
        x[rng.integers(0, 400, 10)] = rng.choice([math.nan, math.inf, 1.0, 0.0], 10)
        detector = EventDetector(1.0, 0.0)
        live = []
        for time, value in zip(t.tolist(), x.tolist(), strict=True):
            event = detector.push(time, value)
            if event is not None:
                live.append(event)
            assert detector.count == len(live)
        assert live == detect(t, x)


def test_events_and_resets_take_turns():
    rng = np.random.default_rng(3)
    for _ in range(50):
        x = rng.normal(0.0, 1.0, 300)
        x[0] = -1.0
        t = np.arange(300.0)
        found = detect(t, x)
        above, below = t[x >= 1.0], t[x <= 0.0]
        state, counted = 'armed', 0
        for time in t:  # the definition, said as a machine of two states
            if state == 'armed' and time in above:
                state, counted = 'spent', counted + 1
            elif state == 'spent' and time in below:
                state = 'armed'
        assert len(found) == counted


# Width and dead time ------------------------------------------------------------------------------

PULSES = [0.0, 2.0, 0.5, -0.5, 0.0, 2.0, 2.0, 2.0, -2.0]
# Up through 1 at 0.5 and 4.5; down through 0 at 2.5 and 7.5: widths 2 and 3.


def test_a_rise_lasts_until_reset_is_crossed():
    found = rises(range(9), PULSES)
    assert found.start.tolist() == [0.5, 4.5]
    assert found.end.tolist() == [2.5, 7.5]
    assert found.width.tolist() == [2.0, 3.0]


def test_the_last_rise_may_have_no_end():
    found = rises(range(3), [0.0, 2.0, 2.0])
    assert (found.start.tolist(), found.width.tolist()) == ([0.5], [1.5])
    assert math.isnan(found.end[0])
    assert rises([], []).start.tolist() == rises([3.0], [2.0]).end.tolist() == []


@pytest.mark.parametrize(
    ('min_width', 'found'),
    [(0.0, [0.5, 4.5]), (2.0, [0.5, 4.5]), (2.0001, [4.5]), (3.0, [4.5]), (3.0001, [])],
)
def test_a_rise_must_last_at_least_min_width(min_width, found):
    assert events(PULSES, min_width=min_width) == found


def test_a_rise_that_the_recording_cuts_short_counts_once_it_was_long_enough():
    assert events([0.0, 2.0, 2.0, 2.0], min_width=2.5) == [0.5]
    assert events([0.0, 2.0, 2.0, 2.0], min_width=2.6) == []


@pytest.mark.parametrize(
    ('refractory', 'found'), [(0.0, [0.5, 4.5]), (4.0, [0.5, 4.5]), (4.0001, [0.5])]
)
def test_no_event_begins_in_the_dead_time(refractory, found):
    assert events(PULSES, refractory=refractory) == found


def test_only_events_have_a_dead_time():
    beat = [0.0, 2.0] * 5  # up at 0.5, 2.5, ... 8.5
    assert events(beat, refractory=3.0) == [0.5, 4.5, 8.5]  # 2.5 does not prolong that of 0.5
    assert events([0.0, 2.0, 0.0, *PULSES], refractory=6.0, min_width=1.6) == [3.5]


def test_a_rise_in_the_dead_time_is_none_even_when_it_outlasts_it():
    assert events([0.0, 2.0, 0.0, 2.0, 2.0, 2.0, 2.0, 2.0], refractory=3.0) == [0.5]


def test_a_live_event_is_returned_when_it_has_lasted_and_has_the_time_of_its_rise():
    detector = EventDetector(min_width=2.0)
    returned = [detector.push(t, x) for t, x in enumerate([0.0, 2.0, 2.0, 2.0, 2.0])]
    assert returned == [None, None, None, 0.5, None]
    detector = EventDetector(min_width=2.0)
    returned = [detector.push(t, x) for t, x in enumerate(PULSES)]
    assert returned == [None, None, None, 0.5, None, None, None, 4.5, None]


@pytest.mark.parametrize('name', ['refractory', 'min_width'])
@pytest.mark.parametrize('value', [-1.0, math.nan, math.inf])
def test_bad_limits_are_refused(name, value):
    with pytest.raises(ParameterError, match=f'{name} must be finite and >= 0'):
        EventDetector(**{name: value})
    with pytest.raises(ParameterError, match=f'{name} must be finite and >= 0'):
        events([0.0, 2.0], **{name: value})


# Against the truth --------------------------------------------------------------------------------

# ../shared/truth/trajectories.json, "events" of exact, uncontrolled and open (rounded to 1e-4).
W = (34.1671, 71.7138, 109.2605, 146.8072, 184.3539, 221.9006, 259.4473, 296.994, 334.5406,
     372.0873)  # fmt: skip
TRUTH = {
    'exact': {
        'w': W,
        'y': (),
        'u': (0.6303, 34.1643, 71.7139, *W[2:]),
    },
    'uncontrolled': {
        'w': W,
        'y': (0.8623, 34.1258, 71.6731, 109.2198, 146.7665, 184.3132, 221.8598, 259.4065,
              296.9532, 334.4999, 372.0466),
    },
    'open': {
        'w': (*W, 409.634, 447.1807, 484.7274, 522.2741, 559.8208, 597.3675, 634.9142, 672.4609,
              710.0075, 747.5542, 785.1009),
        'y': (60.5804, 110.612, 190.6318, 250.5735, 290.5807, 360.5803, 420.6242, 455.6421,
              520.5537, 600.6332, 645.6281, 720.6252),
        'y_r': (60.3056, 110.3072, 190.3056, 250.3061, 290.3109, 360.3057, 420.3061, 455.3153,
                520.3059, 600.3056, 645.3085, 720.3057),
        'u': (0.5459, 34.1799, 71.0884, 109.2611, 125.0825, 146.795, 184.3645, 221.8893,
              259.9766, 297.2787, 334.5341, 371.3243, 409.6353, 447.1843, 484.7182, 522.9476,
              535.0231, 559.8072, 597.3786, 634.9023, 672.4626, 710.0173, 747.5556, 785.1106),
    },
}  # fmt: skip
# ... and its "stimulus" of open: pulses of 1.5, 10 long.
ONSETS = (60.0, 110.0, 190.0, 250.0, 290.0, 360.0, 420.0, 455.0, 520.0, 600.0, 645.0, 720.0)

# (k, tau) of exosystem, plant, controller and reference: the paper's figures.
VALUES = {
    'exact': ((2, 1 / 12), (1, 1 / 11), (2, 1 / 12), (1, 1 / 11)),
    'uncontrolled': ((2, 1 / 12), (1, 1 / 11), None, (1, 1 / 11)),
    'open': ((1, 1 / 12), (1, 1 / 11), (4, 1 / 15), (3, 1 / 13)),
}


def neuron(x1, x2, drive, k, tau):
    return x1 - x1**3 / 3 - x2 + k * (drive - x1), tau * (x1 - x2)


def loop(name, v):
    """Return the right-hand side of the paper's loop (eqs. s.w, s.E, s.I, sys.reference)."""
    w, p, eta, r = VALUES[name]

    def rhs(t, x):
        u, e = (x[6], x[4] - x[10]) if eta else (0.0, 0.0)
        return [
            *neuron(x[0], x[1], -x[2], *w), *neuron(x[2], x[3], -x[0], *w),
            *neuron(x[4], x[5], x[0] + v - u, *p),
            *neuron(x[6], x[7], e - x[8], *(eta or (1, 1))),
            *neuron(x[8], x[9], -x[6], *(eta or (1, 1))),
            *neuron(x[10], x[11], v, *r),
        ]  # fmt: skip

    return rhs


def integrate(name, end):
    """Integrate from one jump of v to the next; return t and the signals, every 0.02."""
    x = np.array([1.0, 0, -1, 0, 0, 0, 0.5, 0, -0.5, 0, 0, 0])
    jumps = [s for onset in ONSETS for s in (onset, onset + 10.0)] if name == 'open' else []
    edges = [0.0, *jumps, end]
    times, states = [], []
    for i, (start, stop) in enumerate(itertools.pairwise(edges)):
        t = np.linspace(start, stop, round((stop - start) / 0.02) + 1)
        rhs = loop(name, 1.5 * (i % 2))
        solution = solve_ivp(rhs, (start, stop), x, 'DOP853', t, rtol=1e-9, atol=1e-10)
        times.append(t)
        states.append(solution.y)
        x = solution.y[:, -1]
    states = np.concatenate(states, axis=1)
    rows = {'w': 0, 'y': 4, 'u': 6, 'y_r': 10}
    return np.concatenate(times), {signal: states[row] for signal, row in rows.items()}


@pytest.mark.slow
@pytest.mark.parametrize('name', TRUTH)
def test_the_papers_trajectories_have_the_events_of_the_truth(name):
    t, signals = integrate(name, 800.0 if name == 'open' else 400.0)
    for signal, times in TRUTH[name].items():
        found = detect(t, signals[signal])
        assert len(found) == len(times)
        assert found == pytest.approx(list(times), abs=1e-3)
