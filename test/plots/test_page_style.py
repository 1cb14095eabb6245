# SPDX-License-Identifier: Apache-2.0
"""Pages are legible: contrast in light and dark, lines that differ without colour, paper."""

import itertools
import re

import pytest

from eventreg_ros.plots.page_style import DARK, LIGHT, STYLE

TEXT = ('ink', 'muted', 'good', 'bad', 'open')
LINES = ('w', 'v', 'y_r', 'u', 'other', 'grey')


def colours(block):
    return dict(re.findall(r'--(\w+): (#[0-9a-f]{6});', block))


def luminance(colour):
    parts = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    r, g, b = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


def contrast(one, other):
    low, high = sorted(map(luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize('block', [LIGHT, DARK], ids=['light', 'dark'])
def test_text_and_lines_stand_out_as_wcag_asks(block):
    found = colours(block)
    for name in TEXT:
        for ground in ('paper', 'shade') if name in ('ink', 'muted') else ('paper',):
            assert contrast(found[name], found[ground]) >= 4.5, (name, ground)
    for name in LINES:
        assert contrast(found[name], found['paper']) >= 3.0, name


def test_every_colour_is_there_in_light_and_in_dark():
    assert colours(LIGHT).keys() == colours(DARK).keys()
    assert set(re.findall(r'var\(--(\w+)\)', STYLE)) <= colours(LIGHT).keys()


def rules(selector):
    """The declarations of a selector, all of them, on a screen."""
    found = re.findall(rf'(?:^|[}},\n] *){re.escape(selector)} \{{([^}}]*)\}}', STYLE)
    return dict(
        pair.strip().split(': ', 1) for block in found for pair in block.split(';') if ':' in pair
    )


@pytest.mark.parametrize('shared', [('y', 'y_r'), ('band', 'u'), ('run0', 'run1', 'run2', 'run3')])
def test_lines_that_share_a_panel_differ_without_their_colour(shared):
    looks = {
        name: tuple(rules(f'.line.{name}').get(p) for p in ('stroke-dasharray', 'stroke-width'))
        for name in shared
    }
    for one, other in itertools.combinations(shared, 2):
        assert looks[one] != looks[other]


def test_on_paper_no_heading_stands_alone_and_tables_are_whole():
    paper = STYLE[STYLE.index('@media print') :]
    assert 'h1, h2, h3, summary { break-after: avoid; }' in paper
    for words in ('break-inside: avoid', '.tools { display: none; }', '.long { max-height: none; }',
                  'thead { display: table-header-group; }', 'color-scheme: light'):  # fmt: skip
        assert words in paper
    assert colours(paper) == colours(LIGHT)
