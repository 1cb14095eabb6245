# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from matplotlib.colors import to_hex

from eventreg_ros.plots.margin_map import KEYS, draw_map
from eventreg_ros.plots.style import BLACK

# What is drawn is drawn once.
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group('margin_map')]

DELAYS, LOSSES = 0.1 * np.arange(4), 0.25 * np.arange(3)
SHARE = np.array([[1.0, 1.0, 0.5, 0.0], [1.0, 0.2, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])


@pytest.fixture
def panels():
    figure = draw_map(DELAYS, LOSSES, {'zero': SHARE, 'linear': 0.0 * SHARE + 1.0}, 'title', 5.0)
    figure.draw_without_rendering()
    return figure.axes


def test_each_cell_is_where_its_delay_and_loss_are_and_has_its_colour(panels):
    none, some, every = (colour.lower() for colour, _ in KEYS)
    expected = [
        [every, every, some, none],
        [every, some, none, none],
        [none, none, none, none],
    ]
    mesh = panels[0].collections[0]
    colours = [to_hex(c) for c in mesh.to_rgba(mesh.get_array()).reshape(-1, 4)]
    assert colours == [colour for row in expected for colour in row]
    corners = np.asarray(mesh.get_coordinates())
    middle = 0.5 * (corners[:-1, :-1] + corners[1:, 1:])
    assert middle[..., 0] == pytest.approx(np.tile(DELAYS, (3, 1)))
    assert middle[..., 1] == pytest.approx(np.tile(LOSSES[:, None], (1, 4)))


def test_a_line_surrounds_what_is_always_rejected(panels):
    edges = {
        tuple(np.round([*line.get_xdata(), *line.get_ydata()], 6))
        for line in panels[0].lines
        if line.get_color() == BLACK
    }
    assert edges == {
        (0.15, 0.15, -0.125, 0.125),
        (0.05, 0.15, 0.125, 0.125),
        (0.05, 0.05, 0.125, 0.375),
        (-0.05, 0.05, 0.375, 0.375),
    }
    assert not panels[1].lines


def test_the_upper_axis_is_in_milliseconds(panels):
    (top,) = panels[0].child_axes
    low, high = panels[0].get_xlim()
    assert top.get_xlim() == pytest.approx((200.0 * low, 200.0 * high))
    assert 'time_scale 5' in top.get_xlabel()


def test_the_holds_are_side_by_side(panels):
    assert [axis.get_title(loc='left') for axis in panels] == ['hold: zero', 'hold: linear']
