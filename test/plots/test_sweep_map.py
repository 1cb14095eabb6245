# SPDX-License-Identifier: Apache-2.0
"""Pictures of sweeps: what is in which cell, on which axis, and what has no picture."""

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.errors import EventregError
from eventreg_ros.plots.sweep_map import draw_sweep
from eventreg_ros.plots.sweep_plot import need_picture, shown
from eventreg_ros.robustness.plan import Plan


def table(x, y):
    """Return the table of a grid: 2 x + y wrong events, none known where y is 0."""
    xs, ys = (
        np.asarray(each, dtype=object if isinstance(each[0], str) else float) for each in (x, y)
    )
    places = np.indices((len(x), len(y))).reshape(2, -1)
    wrong = np.where(places[1] == 0, np.nan, 2.0 * places[0] + places[1])
    verdicts = [None if np.isnan(w) else 'rejected' for w in wrong]
    return {
        'plant.k': xs[places[0]], '/**.tau': ys[places[1]],
        'verdict': np.array(verdicts, dtype=object),
        'spurious': wrong, 'missed': 0.0 * wrong, 'residual_max_abs': wrong,
    }  # fmt: skip


NAMES = ['plant.k', '/**.tau']


def test_each_value_is_in_its_cell_and_what_is_not_known_is_white():
    figure = draw_sweep(table([3.0, 1.0], [0.1, 0.2, 0.5]), NAMES, 'exact')
    verdict, wrong, size = (axis.collections[0].get_array() for axis in figure.axes[:3])
    # rows are /**.tau upwards, columns plant.k, sorted: the second value first
    expected = [[np.nan, np.nan], [3.0, 1.0], [4.0, 2.0]]
    assert np.array_equal(np.ma.filled(wrong, np.nan), expected, equal_nan=True)
    assert np.array_equal(np.ma.filled(size, np.nan), expected, equal_nan=True)
    assert verdict.tolist() == [[3, 3], [0, 0], [0, 0]]
    assert [axis.get_xlabel() for axis in figure.axes[:3]] == ['plant.k'] * 3
    assert figure.axes[0].get_ylabel() == '/**.tau'


def test_words_stand_side_by_side_and_equal_ratios_are_logarithmic():
    figure = draw_sweep(table(['zero', 'linear'], [0.5, 1.0, 2.0]), NAMES, 'exact')
    axis = figure.axes[0]
    assert [label.get_text() for label in axis.get_xticklabels()] == ['linear', 'zero']
    assert axis.get_yscale() == 'log'
    assert axis.get_ylim() == pytest.approx((0.5 / 2**0.5, 2.0 * 2**0.5))
    figure.savefig('/dev/null', format='svg')


def test_of_very_many_values_no_more_are_drawn_than_can_be_seen(monkeypatch):
    monkeypatch.setattr('eventreg_ros.plots.sweep_map.FINEST', 3)
    figure = draw_sweep(table([1.0, 2.0], [0.1, 0.2, 0.5, 0.7]), NAMES, 'exact')
    wrong = np.ma.filled(figure.axes[1].collections[0].get_array(), np.nan)
    assert np.array_equal(wrong, [[np.nan, np.nan], [2.0, 4.0]], equal_nan=True)
    assert 'exact: 8 sets' in figure.get_suptitle()


@pytest.mark.parametrize('names', [['plant.k'], NAMES])
def test_a_sweep_without_any_verdict_has_a_picture(names):
    columns = table([1.0], [0.1])
    draw_sweep(columns, names, 'exact').savefig('/dev/null', format='svg')


def test_what_takes_one_value_needs_no_axis_and_three_that_vary_are_refused():
    def plan(*ranges):
        return Plan.of(load('exact'), [*ranges, 'controller.k:=1..2/3', 'controller.tau:=0.1..1/2'])

    assert shown(plan('plant.k:={1}')) == ['controller.k', 'controller.tau']
    with pytest.raises(
        EventregError, match=r'one or two parameters, got plant\.k, controller\.k, c'
    ):
        need_picture(plan('plant.k:={1,2}'))
