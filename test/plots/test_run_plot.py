# SPDX-License-Identifier: Apache-2.0
"""A run as a picture: its data, one scale for all panels, and a legend that covers nothing."""

from io import BytesIO

import numpy as np
import pytest

from eventreg_ros import simulate
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.plots.run_plot import Shade, draw_run

# What is drawn is drawn once.
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group('run_plot')]


@pytest.fixture(scope='module')
def run():
    return simulate('open', 300.0)


@pytest.fixture(scope='module')
def figure(run):
    figure = run.plot()
    figure.draw_without_rendering()
    return figure


def drawn(axes):
    return {line.get_label(): line for line in axes.get_lines() if line.get_label() != 'threshold'}


def test_the_panels_hold_the_signals_and_the_last_one_their_events(run, figure):
    *panels, events = figure.axes
    assert [set(drawn(ax)) for ax in panels] == [{'$w$', '$u$'}, {'$v$'}, {'$y$', '$y_r$'}]
    y = drawn(panels[2])['$y$']
    np.testing.assert_array_equal(y.get_xdata(), run.t)
    np.testing.assert_array_equal(y.get_ydata(), run['y'])
    rows = [list(row.get_positions()) for row in events.collections]
    assert rows == [run.events[name] for name in ('w', 'v', 'y', 'y_r', 'u')]


def test_all_panels_have_one_scale_with_the_threshold_in_it(figure):
    limits = {ax.get_ylim() for ax in figure.axes[:-1]}
    assert len(limits) == 1
    assert limits.pop()[1] > 1.0


def test_the_legend_names_everything_once_and_covers_no_panel(figure):
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert words == ['$w$', '$u$', '$v$', '$y$', '$y_r$', 'threshold', 'settling']
    box = legend.get_window_extent()
    assert not any(box.overlaps(ax.get_window_extent()) for ax in figure.axes)


def test_a_notebook_gets_a_png_without_pyplot(run, python):
    assert run.plot()._repr_png_().startswith(b'\x89PNG')
    code = (
        'import sys; from eventreg_ros import simulate; simulate("exact", 50.0).plot();'
        'print("matplotlib.pyplot" in sys.modules)'
    )
    assert python('-c', code).stdout == 'False\n'


def test_a_second_signal_has_the_colour_of_the_first_and_another_line():
    t = np.linspace(0.0, 10.0, 50)
    signals = {name: Signal(t, np.sin(t)) for name in ('w', 'w_2', 'y')}
    figure = draw_run(signals, {'w': [1.0]}, threshold=0.5, shades=[Shade(2.0, 4.0, 'off')])
    first, second = (drawn(figure.axes[0])[name] for name in ('$w$', 'w_2'))
    assert first.get_color() == second.get_color()
    assert first.get_linestyle() != second.get_linestyle()
    assert 'off' in [text.get_text() for text in figure.axes[0].texts]
    figure.savefig(BytesIO(), format='svg')


def test_neither_an_outlier_nor_a_foreign_signal_squeezes_the_loop(run):
    signals = {name: Signal(run.t, x.copy()) for name, x in run.signals.items()}
    signals['y'].x[1000] = 1e9
    signals['effort'] = Signal(run.t, 300.0 + run['w'])
    figure = draw_run(signals, {}, threshold=1.0)
    *loop, effort = figure.axes[:-1]
    assert len({ax.get_ylim() for ax in loop}) == 1
    assert loop[0].get_ylim()[1] < 4.0
    assert effort.get_ylim()[0] > 290.0
