# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from eventreg_ros.errors import ParameterError
from eventreg_ros.scenario.parameters import resolve
from eventreg_ros.simulation.stimulus import Stimulus, read_points


def jumps(stimulus, end, step):
    """Where v jumps, found by looking: the grid points just after a big change."""
    t = np.arange(0.0, end, step)
    v = np.array([stimulus(x) for x in t.tolist()])
    return t[1:][np.abs(np.diff(v)) > 0.5]


@pytest.mark.parametrize(
    'stimulus',
    [
        Stimulus('pulses', onsets=(3.0, 7.25, 9.0), width=2.0),
        Stimulus('square', period=4.0, width=1.5, phase=0.75),
        Stimulus('square', period=4.0, width=1.5, phase=-9.5),
    ],
)
def test_breaks_are_where_it_jumps(stimulus):
    found = jumps(stimulus, 20.0, 1e-3)
    breaks = [t for t in stimulus.breaks(20.0) if t > 1e-3]
    for jump in found:
        assert min(abs(jump - t) for t in breaks) <= 1e-3
    assert breaks == sorted(breaks)
    assert all(0.0 < t < 20.0 for t in breaks)


def test_a_pulse_has_its_beginning_but_not_its_end():
    v = Stimulus('pulses', amplitude=1.5, offset=0.25, onsets=(3.0,), width=2.0)
    assert [v(t) for t in (2.999, 3.0, 4.999, 5.0)] == [0.25, 1.75, 1.75, 0.25]


def test_pulses_that_touch_are_one():
    v = Stimulus('pulses', onsets=(1.0, 2.0), width=1.0)
    assert {v(t) for t in np.linspace(1.0, 2.999, 50)} == {1.0}


def test_sine_and_constant():
    v = Stimulus('sine', amplitude=2.0, offset=1.0, period=8.0, phase=1.0)
    assert v(3.0) == pytest.approx(3.0)
    assert v(1.0) == 1.0
    assert v(4.0) == pytest.approx(1.0 + 2.0 * math.sin(2 * math.pi * 3 / 8))
    assert Stimulus('constant', amplitude=2.0, offset=1.0)(5.0) == 3.0
    assert v.breaks(100.0) == []


def test_csv_runs_from_point_to_point_and_stays_outside(tmp_path):
    file = tmp_path / 'v.csv'
    file.write_text('t,v\n1,0\n2,4\n4,0\n')
    values = resolve('stimulus', {'waveform': 'csv', 'file': str(file), 'amplitude': 0.5})
    v = Stimulus.from_parameters(values)
    assert [v(t) for t in (0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0)] == [
        0.0,
        0.0,
        1.0,
        2.0,
        1.0,
        0.0,
        0.0,
    ]
    assert v.breaks(3.0) == [1.0, 2.0]


@pytest.mark.parametrize(
    ('text', 'where'),
    [('1,0\n1,2\n', 'line 2'), ('t,v\nx,1\n', 'line 2'), ('t,v\n', 'at least one')],
)
def test_a_bad_csv_names_the_line(tmp_path, text, where):
    file = tmp_path / 'v.csv'
    file.write_text(text)
    with pytest.raises(ParameterError, match=where):
        read_points(str(file))


def test_a_missing_csv_is_one_line():
    with pytest.raises(ParameterError, match='no such file') as caught:
        read_points('/nowhere/v.csv')
    assert '\n' not in str(caught.value)
