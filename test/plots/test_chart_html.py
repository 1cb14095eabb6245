# SPDX-License-Identifier: Apache-2.0
"""Charts as HTML: the curves are the signals, marks stand where they belong."""

import re

import numpy as np
import pytest

from eventreg_ros.plots.axis import Axis
from eventreg_ros.plots.chart import Chart, Events, Fault, Line, Mark, Panel, Raster, Row
from eventreg_ros.plots.chart_curves import MOST_EVENTS
from eventreg_ros.plots.chart_html import chart
from eventreg_ros.plots.chart_scale import ACROSS, FINE, short

SPAN, AXIS, HEIGHT = (50.0, 150.0), Axis(-2.0, 3.0), 100


def a_chart(*lines, **more):
    return chart(Chart('made', SPAN, [Panel(lines, AXIS, height=HEIGHT)], **more))


def points(html, kind):
    """The points of the path of a class, in model time and values; NaN between its parts."""
    path = re.findall(rf'<path class="{kind}"[^>]* d="([^"]*)"', html)[-1]  # after its key
    t, x = [], []
    for run in filter(None, path.split('M')):
        start, _, steps = run.partition('l')
        whole = [int(number) for number in f'{start.replace("h0", "")} {steps}'.split()]
        t += [np.nan, *np.cumsum(whole[::2])]
        x += [np.nan, *np.cumsum(whole[1::2])]
    t = SPAN[0] + np.array(t) / ACROSS * (SPAN[1] - SPAN[0])
    return t, AXIS.high - np.array(x) / (HEIGHT * FINE) * (AXIS.high - AXIS.low)


def test_a_curve_goes_through_its_samples():
    t = np.linspace(40.0, 160.0, 1201)
    x = np.sin(t / 7.0) + 0.3 * np.cos(t)
    drawn_t, drawn_x = points(a_chart(Line('y', 'y', t, x)), 'line y')
    assert np.isnan(drawn_t[0])
    assert drawn_t[1] == pytest.approx(49.9)  # the last sample before the span
    assert drawn_t[-1] == pytest.approx(150.1)
    at = np.linspace(50.0, 150.0, 1001)
    np.testing.assert_allclose(
        np.interp(at, drawn_t[1:], drawn_x[1:]), np.interp(at, t, x), atol=6e-3
    )


def test_a_curve_is_broken_where_samples_lack_or_are_no_numbers():
    t = np.concatenate([np.arange(60.0, 90.0, 0.5), np.arange(110.0, 130.0, 0.5)])
    x = np.where((t > 70.0) & (t < 75.0), np.nan, 1.0)
    drawn_t, drawn_x = points(a_chart(Line('y', 'y', t, x)), 'line y')
    assert drawn_t[~np.isnan(drawn_t)] == pytest.approx([60.0, 70.0, 75.0, 89.5, 110.0, 129.5])
    assert np.isnan(drawn_t)[[0, 3, 6]].all()
    assert np.nanmax(np.abs(drawn_x - 1.0)) < 1e-9


@pytest.mark.parametrize('x', [[], [1.0], [np.nan] * 3, [1e308, -1e308, np.inf], [1.0] * 9])
def test_any_curve_is_whole(x):
    t = 60.0 + np.arange(float(len(x)))
    html = a_chart(Line('y', 'y', t, np.array(x, float), True))
    assert 'nan' not in html
    assert 'inf' not in html.replace('info', '')


def test_what_leaves_the_scale_is_marked_at_the_edge():
    t = np.arange(50.0, 150.0, 0.5)
    x = np.zeros(len(t))
    x[t == 75.0], x[t == 100.0] = 1e9, -50.0
    html = a_chart(Line('y', 'y', t, x))
    marks = re.findall(
        r'<svg class="glyph" x="([\d.]+)%" y="([\d.]+)"[^>]*><path class="(\w+)', html
    )
    assert marks == [('25.0000', '0.0', 'above'), ('50.0000', '100.0', 'below')]
    _, drawn = points(html, 'line y')
    assert np.nanmax(np.abs(drawn)) < 9.0  # close enough to be drawn


def test_shades_and_marks_stand_where_they_belong():
    html = a_chart(
        uncounted=[(50.0, 75.0)], unseen=[(100.0, 110.0)], marks=[Mark(125.0, 'k:=<3>')], at=140.0
    )
    rects = re.findall(r'<rect class="(\w+)"[^>]* data-a="([\d.]+)" data-b="([\d.]+)"', html)
    assert rects == [('uncounted', '0.000000', '0.250000'), ('unseen', '0.500000', '0.600000')]
    glyphs = re.findall(r'data-a="([\d.]+)"><path class="(\w+)"', html)
    assert glyphs == [('0.750000', 'change'), ('0.900000', 'instant')]
    assert '1: k:=&lt;3&gt;, t = 125.0' in html


def test_events_are_rings_and_ticks_at_their_times():
    panel = Panel([], AXIS, events=[Events('w', [75.0, 160.0], 0.5)], height=HEIGHT)
    raster = Raster(
        [Row('w', 'w', [75.0, 100.0]), Row('<y>', 'y', [60.0], [Fault('spurious', [60.0])])]
    )
    html = chart(Chart('made', SPAN, [panel, raster]))
    assert re.findall(r'<path class="ring w" d="([^"]*)"', html) == ['M25000 500h0']
    assert re.findall(r'<path class="tick w" d="([^"]*)"', html) == ['M25000 40v140M50000 40v140']
    assert html.count('class="spurious"') == 2  # in the chart and in its key
    assert '&lt;y&gt;' in html


def test_no_more_events_are_drawn_than_can_be_seen():
    times = np.sort(np.random.default_rng(1).uniform(*SPAN, 200_000))
    html = chart(Chart('made', SPAN, [Raster([Row('w', 'w', times)])]))
    assert html.count('v140') == MOST_EVENTS


def test_a_span_of_no_length_is_drawn():
    line = Line('y', 'y', np.zeros(1), np.ones(1))
    assert 'nan' not in chart(Chart('made', (0.0, 0.0), [Panel([line], AXIS)]))


def test_names_are_cut_in_their_middle():
    assert short('y_left', 7) == 'y_left'
    assert short('robot/arm/effort', 7) == 'rob\u2026ort'
