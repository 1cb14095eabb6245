"""The HTML report: whole, self-contained, true to the verdict, safe whatever the bag holds."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from eventreg_ros import load, simulate
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.timing import Timing
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.plots import report_svg as report_plots
from eventreg_ros.plots.report import ReportPage, render
from eventreg_ros.plots.report_words import in_words
from eventreg_ros.scenario import Criteria

VOID = {'meta', 'br', 'hr', 'img', 'input', 'link'}
W = [110, 150, 190, 230]
PAGES = {}
HOSTILE = '--></svg></style><script>alert("&$x$")</script>'


class Page(HTMLParser):
    """What is on a page: its tags with their attributes, its text, and whether tags match."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.open = [], [], []
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
        self.text.append(data)

    def every(self, tag):
        return [attributes for found, attributes in self.tags if found == tag]

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
    for tag in ('script', 'link', 'img', 'iframe', 'object', 'base', 'form'):
        assert page.every(tag) == []
    for _, attributes in page.tags:
        assert not any(name.startswith('on') for name in attributes)
        for name in ('src', 'href', 'xlink:href', 'data'):
            assert attributes.get(name, '#').startswith('#')
    assert 'url(http' not in text
    assert '@import' not in text
    assert not re.search(r'https?://(?!www\.w3\.org/)', text)


def test_every_part_is_there(page_of):
    page = page_of(w=W, y=[], u=W)
    assert len(page.every('svg')) == len(page.every('figcaption')) == 4
    for svg in page.every('svg'):
        assert svg['role'] == 'img'
        assert svg['aria-label']
    for heading in (
        'After t = 100', 'Signals', 'Events', 'Residual', 'Does the controller follow',
        'Table of events', 'Scenario', 'How the numbers are defined',
    ):  # fmt: skip
        assert heading in page.words


def test_references_inside_the_pictures_lead_somewhere(page_of):
    page = page_of(w=W, y=[], u=W)
    ids = {attributes['id'] for _, attributes in page.tags if 'id' in attributes}
    used = {attributes['xlink:href'][1:] for attributes in page.every('use')}
    clips = {a['clip-path'][5:-1] for _, a in page.tags if 'clip-path' in a}
    assert used | clips
    assert used | clips <= ids


def test_pictures_take_their_colours_from_the_page(page_of, loop_signals):
    text = render(a_run(loop_signals(w=W, v=[150], y=[152, 180], y_r=[151, 200], u=W, extra=W)))
    drawn = ''.join(re.findall(r'<svg.*?</svg>', text, flags=re.DOTALL))
    assert not re.search(r'#[0-9a-fA-F]{6}\b', drawn)
    style = text[: text.index('</style>')]
    used = set(re.findall(r'var\((--\w+)\)', drawn))
    assert used >= {'--w', '--u', '--v', '--y_r', '--ink', '--other', '--paper', '--grid'}
    for variable in used:
        assert style.count(f'{variable}: #') == 2  # light and dark


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
    ('events', 'words'),
    [
        ({'w': W, 'y': []}, 'the disturbance had 4 events, and none of them made the plant spike.'),
        (
            {'w': W, 'y': [150, 200], 'y_r': [151, 201]},
            'none of them made the plant spike. The 2 events that the reference asks for came.',
        ),
        ({'w': W, 'y': [130]}, 'the disturbance had 4 events. Not asked for: 1 event of y.'),
        (
            {'w': W, 'y': [130, 170], 'y_r': [210]},
            'Not asked for: 2 events of y. Missing: 1 event that the reference asks for.',
        ),
        (
            {'w': W, 'y': [], 'y_r': [210]},
            'had 4 events. Missing: 1 event that the reference asks for.',
        ),
        ({'w': W[:1], 'y': []}, 'The disturbance had 1 event after t = 100: at least 3 are needed'),
        ({'y': [130]}, 'The disturbance had 0 events after t = 100'),
    ],
)
def test_the_verdict_in_words(loop_signals, events, words):
    run = a_run(loop_signals(**events))
    assert words in in_words(run.report)


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
    assert len(page.every('svg')) == 3
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
    assert page.every('script') == []
    assert page.open == []
    assert '<script' not in text
    assert len(page.every('svg')) == 4
    assert page.words.count(HOSTILE) >= 6  # title, heading, source, tables, file
    assert '$\\frac{$' in page.words
    assert '_under' in page.words


def test_many_foreign_signals(loop_signals):
    signals = loop_signals(w=W, y=[], u=W, **{f'robot/joint_{i}/effort': W for i in range(20)})
    page = Page(render(a_run(signals)))
    assert len(report_plots.panels(signals)) == report_plots.MOST
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
    assert len(page.every('svg')) in (3, 4)


def test_signals_that_were_announced_but_never_came(loop_signals):
    empty = (np.empty(0), np.empty(0))
    signals = {**loop_signals(w=W, y=[]), 'u': empty, 'y_r': empty, 'v': empty}
    page = Page(render(a_run(signals)))
    assert len(page.every('svg')) == 3
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
    assert text.count('<svg') == plain.count('<svg') + 1
