# SPDX-License-Identifier: Apache-2.0
"""The files of a report: the same options for simulate and analyze, and which bag is the last."""

import json
import os

import numpy as np
import pytest

from eventreg_ros.bags.writer import write_bag
from eventreg_ros.cli.main import main

W = [110, 150, 190, 230]


@pytest.mark.slow
def test_simulate_and_analyze_write_the_same_of_one_run(tmp_path, capsys):
    places = [tmp_path / name for name in ('r.json', 'r.xml', 'r.html', 'r.png')]
    options = [
        word
        for option, place in zip(('--json', '--junit', '--report', '--plot'), places, strict=True)
        for word in (option, str(place))
    ]
    bag = str(tmp_path / 'bag')
    assert main(['simulate', 'exact', '--sampled', '--bag', bag, *options]) == 0
    simulated = [place.read_bytes() for place in places]
    assert main(['analyze', bag, *options]) == 0
    recorded = [place.read_bytes() for place in places]
    one, other = (json.loads(written[0]) for written in (simulated, recorded))
    for signal in other['signals'].values():
        del signal['timing']
    assert one['rejection'] == other['rejection']
    assert one['signals']['w']['events'] == pytest.approx(other['signals']['w']['events'])
    assert simulated[1] == recorded[1]
    assert b'<title>exact: rejected</title>' in simulated[2]
    assert b'<title>exact: rejected</title>' in recorded[2]
    assert recorded[3].startswith(b'\x89PNG')


def test_a_picture_that_is_none_is_refused_before_any_work(refused, tmp_path):
    for verb in (['simulate', 'exact'], ['analyze', tmp_path / 'none']):
        assert '--plot must end in' in refused(*verb, '--plot', tmp_path / 'a.doc')


@pytest.mark.slow
def test_what_was_not_seen_is_shaded(tmp_path, loop_signals, stamped):
    from eventreg_ros.analysis.recorded import analyze
    from eventreg_ros.plots.run_plot import COLUMN, draw_report

    signals = loop_signals(w=W, y=[])
    t, y = signals['y']
    keep = (t < 120.0) | (t > 140.0)
    write_bag(tmp_path / 'bag', stamped({**signals, 'y': (t[keep], y[keep])}), 'made', None)
    analysis = analyze(tmp_path / 'bag')
    figure = draw_report(analysis.signals, analysis.report, COLUMN)
    assert figure.get_figwidth() == COLUMN
    for ax in figure.axes:
        spans = [patch.get_bbox().intervalx for patch in ax.patches]
        np.testing.assert_allclose(spans, [[0.0, 100.0], [119.8, 140.2]], atol=1e-9)
    assert [text.get_text() for text in figure.axes[0].texts] == ['y unseen']


def test_what_was_changed_is_a_line():
    from eventreg_ros import simulate

    run = simulate('exact', 20.0, at=['5:controller.k:=3', '5:plant.k:=2', '12:controller.k:=2'])
    for ax in run.plot().axes:
        marks = [line.get_xdata()[0] for line in ax.lines if line.get_label() == 'change']
        assert marks == [5.0, 12.0]


# Which bag, and what of it -----------------------------------------------------------------------


def test_the_last_bag_is_the_one_written_last(make_bag, monkeypatch, capsys, refused, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert 'no bag of eventreg run is in' in refused('analyze', '--last')
    for i, name in enumerate(('b', 'a', 'foreign')):
        bag = make_bag(name, w=W, y=[130 + i], u=W, text=None if name == 'foreign' else 'plant: {}')
        for file in bag.iterdir():
            os.utime(file, (1000 + i, 1000 + i))
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'empty' / 'made.scenario.yaml').write_text('')
    assert main(['analyze', '--last', '--json', 'out.json', '--scenario', 'exact']) == 1
    assert 'analyzing a\n' in capsys.readouterr().err
    report = json.loads((tmp_path / 'out.json').read_text())
    assert report['signals']['y']['events'] == pytest.approx([131.0], abs=1e-6)
    assert 'drop one' in refused('analyze', 'b', '--last')
    assert 'give its path, or --last' in refused('analyze')


def test_signals_may_be_named_by_topic(make_bag, loop_signals, stamped, tmp_path, capsys, refused):
    signals = loop_signals(w=W, y=[], u=W)
    renamed = {'arm/membrane': signals['y'], 'generator': signals['w']}
    write_bag(tmp_path / 'bag', stamped(renamed), 'made', None)
    bag, out = str(tmp_path / 'bag'), tmp_path / 'out.json'
    topics = ['--topic', 'y:=/arm/membrane', '--topic', 'w:=/generator']
    assert main(['analyze', bag, *topics, '--json', str(out)]) == 0
    assert list(json.loads(out.read_text())['signals']) == ['w', 'y']
    capsys.readouterr()
    assert 'has no number velocity[2]' in refused(
        'analyze', bag, '--topic', 'y:=/arm/membrane:velocity[2]'
    )
    assert 'a topic must be SIGNAL:=TOPIC' in refused('analyze', bag, '--topic', 'y=/arm')


def test_the_time_may_be_chosen_and_is_said(make_bag, capsys, refused):
    bag = make_bag(w=W, y=[], u=W)
    for time in ('log', 'publish'):
        assert main(['analyze', str(bag), '--time', time]) == 0
        assert f'by the {time} times of the messages' in capsys.readouterr().out
    assert 'time header needs messages with a header' in refused('analyze', bag, '--time', 'header')
