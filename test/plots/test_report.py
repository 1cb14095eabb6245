# SPDX-License-Identifier: Apache-2.0
"""The HTML report: whole, self-contained, true to the verdict, safe whatever the bag holds."""

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.changes import Change
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.timing import Timing
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.bags.finding import Finding
from eventreg_ros.plots import report_charts
from eventreg_ros.plots.report import ReportPage, render
from eventreg_ros.plots.report_words import sentence
from eventreg_ros.scenario import Criteria

VOID = {'meta', 'br', 'hr', 'img', 'input', 'link'}
SCRIPTS = {'script', 'style'}
W = [110, 150, 190, 230]
PAGES = {}
HOSTILE = '--></svg></style><script>alert("&$x$")</script>'


class Page(HTMLParser):
    """What is on a page: its tags with their attributes, its text, and whether tags match."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.headings, self.open, self.raw = [], [], [], [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ['h2']:
            self.headings.append(data)
        if not self.open or self.open[-1] not in SCRIPTS:
            self.text.append(data)
        else:
            self.raw[self.open[-1]] = self.raw.get(self.open[-1], '') + data

    def every(self, tag):
        return [attributes for found, attributes in self.tags if found == tag]

    @property
    def charts(self):
        return [a['aria-label'] for a in self.every('div') if a.get('class') == 'view']

    @property
    def words(self):
        return ' '.join(' '.join(self.text).split())


def a_run(signals, **more):
    limits = {name: more.pop(name) for name in ('threshold', 'reset', 'window') if name in more}
    there = [name for name, (t, _) in signals.items() if len(t)]
    subject = subject_by_name(there, Criteria(**limits), scenario=more.pop('scenario', 'made'))
    report = judge(signals, subject)
    parameters = {'plant': {'k': 1.0, 'x0': [0.0, 0.25]}, 'spike_monitor': {'reset': 0.0}}
    return ReportPage(
        **{'source': 'bag', 'signals': signals, 'report': report, 'parameters': parameters,
           **more}
    )  # fmt: skip


@pytest.fixture
def page_of(loop_signals):
    """Render a run with events at the given times, once for all tests."""

    def make(**events):
        if (key := repr(events)) not in PAGES:
            PAGES[key] = Page(render(a_run(loop_signals(**events))))
        return PAGES[key]

    return make


# The whole page ---------------------------------------------------------------------------------


def test_the_page_is_whole_and_needs_nothing_else(loop_signals):
    text = render(a_run(loop_signals(w=W, v=[150], y=[152], y_r=[151], u=W)))
    page = Page(text)
    assert text.startswith('<!DOCTYPE html>\n<html lang="en">')
    assert page.open == []
    assert page.every('meta')[0] == {'charset': 'utf-8'}
    for tag in ('link', 'img', 'iframe', 'object', 'base', 'form'):
        assert page.every(tag) == []
    for _, attributes in page.tags:
        assert not any(name.startswith('on') or name == 'style' for name in attributes)
        for name in ('src', 'href', 'xlink:href', 'data'):
            assert attributes.get(name, '#').startswith('#')
    assert set(re.findall(r'url\((.*?)\)', text)) <= {'#hatch'}
    assert '@import' not in text
    assert not re.search(r'https?:', text)


def test_the_policy_allows_our_script_and_our_style_alone(page_of):
    page = page_of(w=W, y=[], u=W)
    (policy,) = (m['content'] for m in page.every('meta') if 'http-equiv' in m)
    rules = dict(rule.strip().split(' ', 1) for rule in policy.split(';'))
    assert rules.pop('default-src') == "'none'"
    for tag, rule in (('script', 'script-src'), ('style', 'style-src')):
        assert page.every(tag) == [{}]
        digest = b64encode(sha256(page.raw[tag].encode()).digest()).decode()
        assert rules.pop(rule) == f"'sha256-{digest}'"
    assert rules == {'img-src': 'data:', 'base-uri': "'none'", 'form-action': "'none'"}


def test_every_part_is_there_the_verdict_and_its_evidence_first(page_of):
    page = page_of(w=W, y=[130], y_r=[200], u=W)
    assert len(page.charts) == len(page.every('figcaption')) == 5
    assert all(page.charts)
    assert page.headings == [
        'Evidence', 'After t = 100', 'The first unwanted event', 'Signals', 'Events', 'Residual',
        'Does the controller follow the disturbance?', 'Spike trains', 'Table of events',
        'Scenario', 'How the numbers are defined',
    ]  # fmt: skip
    assert page.words.index('Not rejected') < page.words.index('Evidence')


def test_ids_are_unique_and_references_lead_somewhere(page_of):
    page = page_of(w=W, y=[], u=W)
    ids = [attributes['id'] for _, attributes in page.tags if 'id' in attributes]
    assert len(ids) == len(set(ids))
    fills = {a['fill'] for _, a in page.tags if a.get('fill', '').startswith('url')}
    assert fills <= {f'url(#{name})' for name in ids}


def test_the_page_works_by_keyboard_and_tells_what_things_are(page_of):
    page = page_of(w=W, y=[], u=W)
    focusable = [a for _, a in page.tags if 'tabindex' in a]
    assert len(focusable) >= 8
    assert all(a['tabindex'] == '0' and a['role'] and a['aria-label'] for a in focusable)
    assert all(a.get('aria-hidden') == 'true' for a in page.every('svg') if 'x' not in a
               and a.get('class') != 'data')  # fmt: skip
    assert {a['data-do'] for a in page.every('button')} == {'in', 'out', 'back', 'on', 'all'}
    assert all(a['scope'] == 'col' for a in page.every('th'))


@pytest.mark.parametrize(
    ('y', 'y_r', 'w', 'verdict', 'symbol', 'kind'),
    [
        ([], [], W, 'Rejected', '✓', 'rejected'),
        ([130], [], W, 'Not rejected', '✗', 'not-rejected'),
        ([], [], W[:2], 'Undecided', '?', 'undecided'),
    ],
)
def test_the_verdict_is_said_in_colour_symbol_and_words(page_of, y, y_r, w, verdict, symbol, kind):
    page = page_of(w=w, y=y, y_r=y_r, u=w)
    assert f'{symbol} {verdict} ' in page.words
    assert {'class': f'verdict {kind}', 'role': 'status'} in page.every('div')
    assert f'made: {verdict.lower()}' in page.words  # the title


@pytest.mark.parametrize(
    ('reason', 'words'),
    [
        ('after t = 100 w had 4 events', 'After t = 100 w had 4 events.'),
        ('there is no w', 'There is no w.'),
        ('y was not seen', 'y was not seen.'),
        ('w_2 is missing', 'w_2 is missing.'),
        ('2 events of w after 100', '2 events of w after 100.'),
    ],
)
def test_the_reason_is_a_sentence_and_signals_keep_their_names(reason, words):
    assert sentence(reason) == words


def test_the_reason_is_the_reports(loop_signals):
    run = a_run(loop_signals(w=W, y=[130], y_r=[210]))
    assert sentence(run.report.reason) in Page(render(run)).words


def test_what_was_not_seen_is_hatched_in_every_chart_and_reported_first(loop_signals):
    signals = loop_signals(w=W, y=[], u=W)
    t, y = signals['y']
    keep = (t < 120.0) | (t > 140.0)
    signals['y'] = (t[keep], y[keep])
    noted = [Finding('node-warning', 'plant', at, 'plant: late') for at in (101.0, 102.0)]
    run = a_run(signals, noted=noted)
    page = Page(render(run))
    assert 'Seen of it: w 100 %, y 87.2 %.' in page.words
    assert 'from 119.8 to 140.2 (unseen, y, t = 119.8)' in page.words
    assert 'plant: late (node-warning, 2 times, from t = 101.0 on)' in page.words
    hatched = [a for a in page.every('rect') if a['class'] == 'unseen' and 'data-a' in a]
    assert len(hatched) == len([a for a in page.every('svg') if a.get('class') == 'area'])
    assert {(a['data-a'], a['data-b']) for a in hatched} == {
        (f'{119.8 / 260:.6f}', f'{140.2 / 260:.6f}')
    }


def test_changes_are_lines_in_every_chart(loop_signals):
    changes = (Change(120.0, 'controller', 'k:=3'), Change(150.0, 'plant', 'deactivate'))
    run = a_run(loop_signals(w=W, y=[130], u=W))
    page = Page(render(replace(run, report=replace(run.report, changes=changes))))
    marks = [a for a in page.every('path') if a.get('class') == 'change' and 'V12' not in a['d']]
    areas = [a for a in page.every('svg') if a.get('class') == 'area']
    assert len(marks) == 2 * len(areas) - 2  # t = 150 is beyond the magnified chart of 2 panels
    assert '1: controller.k:=3, t = 120.0' in page.words
    assert 't = 150.0: plant: deactivate' in page.words
    assert 'controller.k:=3 at t = 120.0, 10.0 before it.' in page.words


def test_several_plants_are_kept_apart(loop_signals):
    signals = loop_signals(w=W, w_2=[120, 160], y_left=[130], y_right=[], y_r_left=[], u=W)
    page = Page(render(a_run(signals)))
    for row in ('y_left not rejected 1 0 0', 'y_right rejected 0 0 0'):
        assert row in page.words
    for line in ('Settling time of y_left: 130.0', 'Settling time of y_right: 0'):
        assert line in page.words
    assert 'The residual, |y_right|, over model time' in page.charts
    assert 'The residual, |y_left \u2212 y_r_left|, over model time' in page.charts


def test_spike_trains(page_of):
    page = page_of(w=W, y=[151, 190.2], y_r=[150, 190], u=[t + 4 for t in W])
    assert 'w 4 0.025 40 40 40 0 0 0' in page.words
    assert 'y answers y_r: 2 events match, precision 1, recall 1, median latency 0.6.' in page.words
    assert 'u follows w: locking 1, mean phase 0.1 of a period.' in page.words
    assert 'Settling time of y: 0, there is no unwanted event' in page.words


# Numbers ----------------------------------------------------------------------------------------


def test_the_numbers_are_the_reports(page_of):
    page = page_of(w=W, y=[130, 190.2], y_r=[190], u=W)
    for tile in (
        '4 disturbance events: w', '1 reference events: y_r', '1 preserved: y with y_r',
        '1 spurious: y alone', '0 missed: y_r alone', '0.75 ratio of rejection',
        '0 |w - u|, largest',
    ):  # fmt: skip
        assert tile in page.words


def test_the_table_of_events_says_what_each_counts_as(page_of):
    page = page_of(w=[50, *W], y=[60, 130, 190.2], y_r=[190, 210], u=[])
    for row in (
        '50.0000 w before settling: not counted', '60.0000 y before settling: not counted',
        '110.0000 w disturbance', '130.0000 y spurious', '190.0000 y_r answered',
        '190.2000 y preserved', '210.0000 y_r missed',
    ):  # fmt: skip
        assert row in page.words


def test_timing_is_shown_where_the_run_was_recorded(loop_signals):
    run = a_run(loop_signals(w=W, y=[], u=W))
    assert 'Timing' not in Page(render(run)).words
    w = replace(run.report.signals['w'], timing=Timing(200.0, 5e-3, 6e-3, 0.0125, 3))
    run = replace(run, report=replace(run.report, signals={**run.report.signals, 'w': w}))
    assert 'w 200.00 5.000 6.000 12.500 3' in Page(render(run)).words


def test_origin(loop_signals):
    signals = loop_signals(w=W, y=[])
    recorded = Page(render(a_run(signals, source='bag_7', start=1_795_304_457_727_915_003))).words
    assert 'bag_7: 260.0 units of model time in 26.0 s (10 units per second)' in recorded
    assert 'from 2026-11-21 23:40:57 UTC.' in recorded
    assert 'UTC' not in Page(render(a_run(signals, start=12_000_000_000))).words


def test_the_scenario_is_shown_by_node(loop_signals):
    signals = loop_signals(w=W, y=[])
    page = Page(render(a_run(signals, text='plant:\n  k: 1')))
    assert 'plant spike_monitor k 1 x0 0, 0.25 reset 0' in page.words
    assert 'The parameter file plant: k: 1' in page.words
    assert 'holds no scenario' in Page(render(a_run(signals, parameters={}))).words


def test_threshold_reset_and_window_stand_in_the_definitions(loop_signals):
    run = a_run(loop_signals(w=W, y=[]), threshold=0.75, reset=-0.5, window=3.5)
    words = Page(render(run)).words
    assert 'rises through the threshold 0.75 after having been at or below -0.5' in words
    assert 'at most 3.5 apart' in words


# Whatever the bag holds ---------------------------------------------------------------------------


@pytest.mark.parametrize('present', [[], ['w'], ['v', 'y_r', 'u']])
def test_without_w_or_u(page_of, present):
    page = page_of(y=[130], **dict.fromkeys(present, W))
    assert len(page.charts) == 3 + bool(page.words.count('first unwanted'))
    assert 'Does the controller follow' not in page.words
    assert page.open == []


def test_everything_from_the_bag_is_escaped(loop_signals):
    signals = loop_signals(w=W, y=[130], u=W)
    signals[HOSTILE] = signals['w']
    signals['$\\frac{$'] = signals['_under'] = signals['w']
    run = a_run(
        signals, source=HOSTILE, scenario=HOSTILE, text=HOSTILE,
        parameters={HOSTILE: {HOSTILE: HOSTILE, 'b': [HOSTILE]}},
    )  # fmt: skip
    text = render(run)
    page = Page(text)
    assert page.every('script') == [{}]
    assert page.open == []
    assert text.count('<script') == 1
    assert 'alert' not in page.raw['script']
    assert page.words.count(HOSTILE) >= 6  # title, heading, source, tables, file
    assert '$\\frac{$' in page.words
    assert '_under' in page.words


def test_many_foreign_signals(loop_signals):
    signals = loop_signals(w=W, y=[], u=W, **{f'robot/joint_{i}/effort': W for i in range(20)})
    page = Page(render(a_run(signals)))
    assert len(report_charts.panels(signals)) == report_charts.MOST
    assert 'Not drawn: robot/joint_' in page.words
    assert all(f'robot/joint_{i}/effort' in page.words for i in range(20))


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize(
    'values',
    [
        [0.0], [np.nan] * 50, [np.inf, 1e308, -1e308] * 20, [0.0] * 50, [1e-320] * 50,
        [2.0, np.nan, 0.0] * 100,
    ],
)  # fmt: skip
def test_signals_of_any_kind(values):
    t = np.linspace(0.0, 300.0, len(values)) if len(values) > 1 else np.zeros(1)
    x = np.array(values)
    page = Page(render(a_run(dict.fromkeys(('w', 'v', 'y', 'y_r', 'u'), (t, x)))))
    assert page.open == []
    assert len(page.charts) in (3, 4, 5)


def test_signals_that_were_announced_but_never_came(loop_signals):
    empty = (np.empty(0), np.empty(0))
    signals = {**loop_signals(w=W, y=[]), 'u': empty, 'y_r': empty, 'v': empty}
    page = Page(render(a_run(signals)))
    assert len(page.charts) == 3
    assert 'y_r 0 - - 0 0' in page.words


def test_long_runs_make_pages_of_bounded_size(loop_signals):
    t = np.arange(300_000) * 0.05
    signals = {name: (t, 2.0 * np.sin(t / 3.0)) for name in ('w', 'y', 'u')}
    run = a_run(signals)
    assert sum(len(s.events) for s in run.report.signals.values()) > 2000
    text = render(run)
    assert len(text) < 2_000_000
    assert re.search(r'and \d+ more; --json lists all', text)


def test_the_same_run_is_the_same_page(loop_signals):
    pages = [render(a_run(loop_signals(w=W, y=[130], u=W))) for _ in range(2)]
    assert pages[0] == pages[1]


def test_what_controllers_learned_is_drawn_with_the_generator_s_value():
    run = simulate(load('exact', 'controller.adapt:=0.04'), 150.0)
    signals = {name: Signal(run.t, x) for name, x in run.signals.items()}
    text = render(ReportPage('run', signals, run.report, {}))
    assert 'What was learned' in text
    assert 'u/tau went from 1/12.0000 to' in text
    assert 'exosystem has 1/12.0000' in text
    assert 'Not drawn' not in text
    plain = render(ReportPage('run', signals, replace(run.report, learned=()), {}))
    assert 'What was learned' not in plain
    assert len(Page(text).charts) == len(Page(plain).charts) + 1
