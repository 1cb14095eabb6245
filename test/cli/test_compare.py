# SPDX-License-Identifier: Apache-2.0
"""``eventreg compare``: bags and scenarios side by side, as a table, JSON, a page, a picture."""

import json
import re

import pytest

from eventreg_ros import analyze, compare, load, simulate
from eventreg_ros.analysis.comparison_words import as_json, table
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.cli.main import main

W = [110, 150, 190, 230]


@pytest.fixture
def bags(make_bag):
    return (
        make_bag('quiet', w=W, y=[], u=W),
        make_bag('loud', w=W, y=[112, 190], u=W, text='plant: {ros__parameters: {k: 2.0}}\n'),
    )


def test_two_bags(bags, tmp_path, capsys):
    out = tmp_path / 'out.json'
    assert main(['compare', *map(str, bags), '--json', str(out)]) == 0
    printed = capsys.readouterr()
    found = json.loads(out.read_text())
    assert printed.err == ''
    assert found['runs'] == ['quiet', 'loud']
    assert found['verdicts'] == ['rejected', 'not rejected']
    (pair,) = found['signals']['y']['pairs']
    assert pair['only_other'] == pytest.approx([112.0, 190.0], abs=0.2)
    assert found['signals']['w']['pairs'][0]['distances']['victor_purpura'] == 0.0
    assert found['parameters']['plant.k'] == [1.0, 2.0]
    assert found['parameters']['exosystem'] == ['present', None]
    direct = compare(*(analyze(bag) for bag in bags), names=['quiet', 'loud'])
    assert found == json.loads(json.dumps(as_json(direct)))
    assert printed.out == table(direct) + '\n'


@pytest.mark.slow
def test_a_scenario_is_simulated(bags, tmp_path):
    out = tmp_path / 'out.json'
    assert main(['compare', 'exact', str(bags[1]), '--json', str(out)]) == 0
    found = json.loads(out.read_text())
    assert found['runs'] == ['exact', 'loud']
    run = simulate('exact')
    assert found['verdicts'][0] == run.verdict
    assert found['signals']['u']['counts'][0] == len(run.events['u'])


@pytest.mark.slow
def test_a_scenario_by_its_file_and_one_run_twice(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text(load('exact', 'controller.k:=3').to_yaml())
    found = compare('exact', path, load('exact'))
    assert found.runs == ('exact', 'mine.yaml', 'exact (2)')
    (k,) = (row for row in found.parameters if row.parameter == 'controller.k')
    assert k.values == (2.0, 3.0, 2.0)
    y = next(s for s in found.signals if s.signal == 'w')
    assert {len(o.runs) for o in y.occurrences} == {3}


def test_settle_and_window_are_those_of_the_verdict(bags, tmp_path):
    out = tmp_path / 'out.json'
    limits = ['--settle', '113', '--window', '1']
    assert main(['compare', *map(str, bags), *limits, '--json', str(out)]) == 0
    assert json.loads(out.read_text())['window'] == 1.0
    late = compare(*bags, settle=200.0)
    assert late.verdicts == ('undecided', 'undecided')  # one event of w is left
    runs = [simulate('exact', 150.0), simulate('uncontrolled', 150.0)]
    assert compare(*runs).verdicts == ('undecided', 'undecided')
    assert compare(*runs, settle=0.0).verdicts == ('rejected', 'not rejected')


@pytest.mark.slow
def test_the_page_needs_no_network_and_trusts_no_name(make_bag, tmp_path):
    make = {'w': W, 'y': [150], 'u': W}
    names = ['a', '<script>alert(1)<', '_$x$_' + 40 * 'long']
    bags = [str(make_bag(name, **make)) for name in names]
    page, picture = tmp_path / 'page.html', tmp_path / 'picture.svg'
    assert main(['compare', *bags, '--report', str(page), '--plot', str(picture)]) == 0
    text = page.read_text()
    assert text.count('<script') == 1
    assert '&lt;script&gt;alert(1)' in text
    assert not re.search(r'(?:src|href)="(?!#)', text)
    assert 'var(--ink)' in text
    assert text.count('class="chart"') == 1
    assert 'How often each event occurs' in text
    assert picture.read_text().count('<svg') == 1


@pytest.mark.slow
def test_a_picture_is_the_same_every_time(tmp_path):
    pictures = [tmp_path / 'a.pdf', tmp_path / 'b.pdf']
    for picture in pictures:
        assert main(['compare', 'exact', 'uncontrolled', '--plot', str(picture)]) == 0
    assert pictures[0].read_bytes() == pictures[1].read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['exact'], 'two runs or more'),
        (['exact', 'nonsense'], "'nonsense' is neither a bag nor a scenario"),
        (['exact', 'gone.yaml'], 'does not exist'),
        (['exact', 'exact', '--plot', 'x.bmp'], '--plot must end in'),
        (['exact', 'exact', '--json', 'gone/x.json'], 'cannot write'),
        (['exact', 'exact', '--window', '0'], 'window must be > 0'),
    ],
)
def test_bad_input(refused, arguments, words):
    assert words in refused('compare', *arguments)


def test_what_was_not_seen_of_a_run_is_said_with_its_name(
    bags, tmp_path, loop_signals, stamped, capsys
):
    signals = loop_signals(w=W, y=[], u=W)
    t, y = signals['y']
    signals['y'] = (t[t < 150.0], y[t < 150.0])
    write_bag(tmp_path / 'torn', stamped(signals), 'exact', load('exact').to_yaml())
    assert main(['compare', str(bags[0]), str(tmp_path / 'torn')]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith('eventreg: torn: y was not seen for ')
    assert printed.err.count('\n') == 1
    assert 'undecided' in printed.out
