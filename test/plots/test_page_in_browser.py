# SPDX-License-Identifier: Apache-2.0
"""Pages in a headless Chromium: silent, alone, safe, legible at any width, used by keyboard."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from eventreg_ros.analysis.changes import Change
from eventreg_ros.analysis.comparison import compare, trains_of
from eventreg_ros.analysis.signal import Signal
from eventreg_ros.analysis.subject import subject_by_name
from eventreg_ros.analysis.verdict import judge
from eventreg_ros.bags.finding import Finding
from eventreg_ros.plots.comparison_page import render_comparison
from eventreg_ros.plots.comparison_plot import Shown
from eventreg_ros.plots.report import ReportPage, render
from eventreg_ros.plots.sweep_map import draw_sweep
from eventreg_ros.plots.sweep_page import render_sweep

SPEC = importlib.util.spec_from_file_location('browser', Path(__file__).with_name('browser.py'))
browser_module = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(browser_module)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.xdist_group('browser'),  # one Chromium for all
    pytest.mark.skipif(browser_module.program() is None, reason='needs a Chromium'),
]

HOSTILE = (
    '--></svg></style></title><script>window.broken = 1</script>'
    '<img src="https://example.org/x.png" onerror="window.broken = 2"><a href="javascript:x">'
    '"\'&$x$' + 'long' * 30
)
ONLY_OURS = '[...document.scripts].length === 1 && window.broken === undefined'
CUT_OFF = """
[...document.querySelectorAll('body *')].filter((element) => {
  const box = element.getBoundingClientRect();
  const inside = element.parentElement.closest('.wide, .long, .area, .time, .scale, pre');
  return !inside && box.width > 0 && (box.right > innerWidth + 0.5 || box.left < -0.5);
}).map((element) => `${element.tagName} ${element.textContent.slice(0, 40)}`)
"""


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    browser = browser_module.Browser(tmp_path_factory.mktemp('browser'))
    yield browser
    browser.close()


def a_loop(end=260.0):
    """Signals of a loop with everything that can be wrong with one, and names that attack."""
    t = np.arange(round(end / 0.2) + 1) * 0.2
    w = 2.0 * np.sin(t / 6.0)
    y = np.where((t > 170.0) & (t < 172.0), 2.0, 0.1 * w)
    y[700] = 1e9
    seen = (t < 190.0) | (t > 205.0)
    signals = {'w': (t, w), 'y': (t[seen], y[seen]), 'y_r': (t, 0.0 * t), 'u': (t, 0.98 * w)}
    signals[HOSTILE] = (t, 300.0 + w)
    return {name: Signal(*signal) for name, signal in signals.items()}


def a_report():
    signals = a_loop()
    found = [Finding('lost-samples', HOSTILE, 171.0, HOSTILE)]
    changes = [Change(160.0, 'controller', 'k:=3'), Change(200.0, HOSTILE, HOSTILE)]
    subject = subject_by_name(signals, scenario=HOSTILE)
    report = judge(signals, subject, findings=found, changes=changes)
    return signals, report


def report_text():
    signals, report = a_report()
    parameters = {HOSTILE: {HOSTILE: HOSTILE, 'x0': [1.0, 2.0]}, 'plant': {'k': 1.0}}
    return render(
        ReportPage(HOSTILE, signals, report, parameters, HOSTILE, 0, 'publish',
                   [Finding('node-warning', HOSTILE, 165.0, HOSTILE)], HOSTILE)
    )  # fmt: skip


def comparison_text():
    signals, report = a_report()
    names = ['one', HOSTILE, 'three']
    found = compare([trains_of(name, report, None) for name in names], 5.0)
    events = {name: list(s.events) for name, s in report.signals.items()}
    return render_comparison(found, [Shown(name, signals, events) for name in names])


def sweep_text():
    """A map so fine that it is drawn as images."""
    k, tau = np.indices((12, 13)).reshape(2, -1)
    columns = {
        'controller.k': 1.0 + k,
        'controller.tau': 2.0 + tau,
        'verdict': np.array(['rejected', 'not rejected', 'undecided'] * 52, dtype=object),
        'spurious': k,
        'missed': tau,
        'residual_max_abs': 0.1 + k,
    }
    picture = draw_sweep(columns, ['controller.k', 'controller.tau'], HOSTILE)
    return render_sweep(HOSTILE, [f'controller.k:={HOSTILE}'], HOSTILE, picture)


@pytest.fixture(scope='module')
def pages(tmp_path_factory):
    home = tmp_path_factory.mktemp('pages')
    texts = {'report': report_text(), 'comparison': comparison_text(), 'sweep': sweep_text()}
    for name, text in texts.items():
        (home / f'{name}.html').write_text(text, encoding='utf-8')
    return {name: home / f'{name}.html' for name in texts}


KINDS = ['report', 'comparison', 'sweep']


@pytest.mark.parametrize('kind', KINDS)
def test_no_word_on_the_console_no_request_no_foreign_script(browser, pages, kind):
    browser.open(pages[kind])
    assert browser.asked() == [pages[kind].resolve().as_uri()]
    assert browser.eval(ONLY_OURS)
    assert browser.eval('document.querySelectorAll("img, a, iframe, link").length') == 0
    assert browser.eval('document.title').count('<script>') == 1
    assert browser.said() == []


def test_the_images_of_a_map_are_seen(browser, pages):
    browser.open(pages['sweep'])
    assert browser.eval('document.querySelectorAll("svg image").length') >= 3
    assert browser.said() == []  # what the policy refuses is said


def test_the_policy_holds_even_if_something_were_let_in(browser, pages):
    browser.open(pages['report'])
    browser.eval("""
        const script = document.createElement('script');
        script.textContent = 'window.broken = 3';
        document.body.append(script);
        const image = document.createElement('img');
        image.src = 'http://127.0.0.1:9/x.png';
        document.body.append(image);
    """)
    assert browser.eval('window.broken === undefined')
    assert len(browser.said()) == 2
    refused = [
        event['params'].get('blockedReason')
        for event in browser.events
        if event['method'] == 'Network.loadingFailed'
    ]
    assert refused == ['csp']


@pytest.mark.parametrize('width', [320, 400, 1200])
@pytest.mark.parametrize('kind', KINDS)
def test_nothing_is_cut_off_at_any_width(browser, pages, kind, width):
    browser.open(pages[kind], width)
    assert browser.eval('document.documentElement.scrollWidth') == width
    assert browser.eval(CUT_OFF) == []


@pytest.mark.parametrize('scheme', ['light', 'dark'])
def test_the_colours_follow_the_reader(browser, pages, scheme):
    browser.open(pages['report'], scheme=scheme)
    paper, ink, y = (
        browser.eval(f'getComputedStyle(document.querySelector("{selector}")).{name}')
        for selector, name in (
            ('body', 'backgroundColor'), ('body', 'color'), ('.area .line.y', 'stroke'),
        )
    )  # fmt: skip
    assert ink == y
    bright = sum(map(int, paper[4:-1].split(','))) > sum(map(int, ink[4:-1].split(',')))
    assert bright == (scheme == 'light')


def test_on_paper_headings_stay_with_what_follows_and_tools_are_gone(browser, pages):
    browser.open(pages['report'], media='print', scheme='dark')
    assert set(
        browser.eval('[...document.querySelectorAll("h1, h2, h3")].map((h) => '
                     'getComputedStyle(h).breakAfter)')
    ) == {'avoid'}  # fmt: skip
    assert browser.eval('getComputedStyle(document.body).backgroundColor') == 'rgb(255, 255, 255)'
    assert browser.eval('[...document.querySelectorAll(".tools, .hint")].every((e) => '
                        'getComputedStyle(e).display === "none")')  # fmt: skip


# Zoom and pan ------------------------------------------------------------------------------------


def views(browser):
    """What the charts show: the words beside their buttons."""
    return browser.eval('[...document.querySelectorAll("output")].map((o) => o.textContent)')


def labels(browser, chart):
    return browser.eval(
        f'[...document.querySelectorAll(".chart")[{chart}].querySelectorAll(".ticks text")]'
        '.map((t) => t.textContent)'
    )


def test_a_chart_zooms_and_moves_by_keyboard_and_others_of_its_span_with_it(browser, pages):
    browser.open(pages['report'])
    assert labels(browser, 1)[:3] == ['0', '50', '100']
    browser.eval('document.querySelectorAll(".view")[1].focus()')
    for key in ('+', '+'):
        browser.press(key)
    first, *others = views(browser)
    assert first == ''  # the magnified chart has a span of its own
    assert set(others) == {'t = 97.5 to 162.5'}
    browser.press('ArrowRight')
    assert views(browser)[1] == 't = 113.8 to 178.8'
    assert all(110.0 < float(words) < 180.0 for words in labels(browser, 3))
    box = browser.eval('document.querySelectorAll(".chart")[1].querySelector(".data")'
                       '.getAttribute("viewBox")')  # fmt: skip
    assert [float(n) for n in box.split()[::2]] == pytest.approx([43750.0, 25000.0])
    browser.press('ArrowLeft')
    browser.press('-')
    assert views(browser)[1] == 't = 65 to 195'
    browser.press('0')
    assert set(views(browser)) == {''}
    for _ in range(20):
        browser.press('+')
    assert views(browser)[1] == 't = 129.935 to 130.065'  # and no closer
    browser.press('0')
    browser.press('ArrowLeft')
    assert set(views(browser)) == {''}
    assert browser.said() == []


def test_marks_move_with_the_curves(browser, pages):
    place = """
        (() => {
          const chart = document.querySelectorAll('.chart')[1];
          const area = chart.querySelector('.area').getBoundingClientRect();
          return [...chart.querySelectorAll('.area')[0].querySelectorAll('.change')].map((mark) =>
            (mark.getBoundingClientRect().x - area.x) / area.width);
        })()
    """
    browser.open(pages['report'])
    assert browser.eval(place) == pytest.approx([160 / 260, 200 / 260], abs=2e-3)
    browser.eval('document.querySelectorAll(".view")[1].focus()')
    browser.press('+')  # 65 to 195
    assert browser.eval(place) == pytest.approx([95 / 130, 135 / 130], abs=2e-3)


def test_buttons_do_what_they_say(browser, pages):
    browser.open(pages['comparison'])

    def click(do):
        browser.eval(f'document.querySelector("button[data-do={do}]").click()')

    click('in')
    assert views(browser) == ['t = 65 to 195']
    click('on')
    assert views(browser) == ['t = 97.5 to 227.5']
    click('back')
    click('out')
    assert views(browser) == ['']


def test_a_chart_is_dragged_and_the_wheel_zooms_with_ctrl_alone(browser, pages):
    browser.open(pages['comparison'])
    browser.eval('document.querySelector(".area").scrollIntoView({block: "center"})')
    x, y, width = browser.eval(
        '(() => { const b = document.querySelector(".area").getBoundingClientRect();'
        'return [b.x + b.width / 2, b.y + b.height / 2, b.width]; })()'
    )
    browser.mouse('mouseWheel', x, y, deltaX=0, deltaY=-100, modifiers=2)
    assert views(browser) == ['t = 26 to 234']
    browser.mouse('mousePressed', x, y, button='left', buttons=1, clickCount=1)
    browser.mouse('mouseMoved', x - 0.1 * width, y, button='left', buttons=1)
    browser.mouse('mouseReleased', x - 0.1 * width, y, button='left', clickCount=1)
    assert views(browser) == ['t = 46.8 to 254.8']
    browser.mouse('mouseMoved', x, y)
    browser.mouse('mouseWheel', x, y, deltaX=0, deltaY=-100)
    assert views(browser) == ['t = 46.8 to 254.8']


def test_close_up_each_sample_is_a_dot(browser, pages):
    browser.open(pages['report'])
    dots = ('[...document.querySelectorAll(".chart")[0].querySelectorAll(".points")].filter((p) => '
            'getComputedStyle(p).display !== "none").length')  # fmt: skip
    assert browser.eval(dots) > 0  # 150 samples
    browser.open(pages['report'], 320)
    assert browser.eval(dots) == 0
    browser.eval('document.querySelectorAll(".view")[0].focus()')
    for _ in range(3):
        browser.press('+')
    assert browser.eval(dots) > 0


def test_without_its_script_the_page_shows_all_the_same(browser, pages):
    browser.call('Emulation.setScriptExecutionDisabled', value=True)
    try:
        browser.open(pages['report'])
        shown = browser.call('DOM.getDocument', depth=-1)
        text = browser.call('DOM.getOuterHTML', nodeId=shown['root']['nodeId'])['outerHTML']
    finally:
        browser.call('Emulation.setScriptExecutionDisabled', value=False)
    assert '<div class="tools" hidden="">' in text
    assert text.count('class="line y"') >= 3
    assert '>100</text>' in text


def test_the_picture_of_a_sweep_keeps_its_colours(browser, pages):
    browser.open(pages['sweep'])
    strokes = browser.eval('[...new Set([...document.querySelectorAll(".picture path")].map((p) => '
                           'getComputedStyle(p).stroke))]')  # fmt: skip
    assert len(strokes) > 2
