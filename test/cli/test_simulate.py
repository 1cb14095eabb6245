# SPDX-License-Identifier: Apache-2.0
import csv
import json
import subprocess
import sys

import numpy as np
import pytest

from eventreg_ros import analyze, scenario
from eventreg_ros import simulate as simulate_run
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.cli.main import main
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import simulate_sampled


def run(*words):
    return main(['simulate', *map(str, words)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'code', 'verdict'),
    [
        ('exact', 0, 'rejected'),
        ('uncontrolled', 1, 'not rejected'),
        ('quiescent', 3, 'undecided'),
    ],
)
@pytest.mark.parametrize('how', [[], ['--sampled']], ids=['continuous', 'sampled'])
def test_the_verdict_is_printed_and_is_the_exit_code(name, code, verdict, how, capsys):
    assert run(name, '--duration', 200, *how) == code
    out, err = capsys.readouterr()
    assert out.splitlines()[-1] == f'verdict: {verdict}'
    assert not err


def test_settle_and_window_reach_the_verdict(tmp_path):
    file = tmp_path / 'r.json'
    code = run('open', '--duration', 130, '--settle', 20, '--window', 0.1, '--json', file)
    report = json.loads(file.read_text())
    # y spikes 0.27 and 0.30 after y_r (the truth's events): outside a window of 0.1
    assert (report['settle'], report['rejection']['missed'], code) == (20.0, 2, 1)


def test_a_continuous_run_has_the_truth_s_events(tmp_path):
    run('single_neuron', '--duration', 120, '--json', tmp_path / 'r.json')
    report = json.loads((tmp_path / 'r.json').read_text())
    # ../shared/truth/trajectories.json, single_neuron
    expected = {
        'w': [34.1671, 71.7138, 109.2605],
        'y': [1.7671, 34.8664, 72.4144, 109.9611],
        'u': [1.4942, 34.6796, 72.2276, 109.7743],
    }
    for signal, events in expected.items():
        assert report['signals'][signal]['events'] == pytest.approx(events, abs=1e-3)
    assert report['duration'] == 120.0


def test_npz_holds_t_and_the_signals(tmp_path):
    file = tmp_path / 'run.npz'
    run('open', '--duration', 70, '--out', file)
    setup = scenario.load('open')
    expected = simulate(setup.loop, 70.0)
    with np.load(file) as found:
        assert set(found) == {'t', 'w', 'v', 'y', 'y_r', 'u'}
        np.testing.assert_array_equal(found['t'], np.arange(1401) * 10.0 / 200.0)
        for signal, values in expected.signals.items():
            np.testing.assert_allclose(found[signal], values, rtol=0, atol=1e-7)


def test_csv_gives_the_same_floats(tmp_path):
    file = tmp_path / 'run.csv'
    impairments = {'delay': 0.1, 'loss': 0.2, 'jitter': 0.1, 'seed': 3}
    words = [word for name, value in impairments.items() for word in (f'--{name}', value)]
    run('exact', '--duration', 10, '--sampled', *words, '--out', file)
    expected = simulate_sampled(scenario.load('exact').loop, 10.0, Impairment(**impairments))
    with open(file, newline='') as lines:
        head, *rows = csv.reader(lines)
    columns = dict(zip(head, np.array(rows, dtype=float).T, strict=True))
    assert head[0] == 't'
    np.testing.assert_array_equal(columns.pop('t'), expected.t)
    assert set(columns) == set(expected.signals)
    for signal, values in expected.signals.items():
        np.testing.assert_array_equal(columns[signal], values)


def test_the_bag_holds_the_samples(tmp_path):
    run('exact', '--duration', 10, '--sampled', '--bag', tmp_path / 'bag')
    expected = simulate_sampled(scenario.load('exact').loop, 10.0)
    recording = read_bag(tmp_path / 'bag')
    found = recording.in_model_time(10.0)
    assert set(found) == set(expected.signals)
    for signal, values in expected.signals.items():
        np.testing.assert_array_equal(found[signal][1], values)
        np.testing.assert_allclose(found[signal][0], expected.t, rtol=0, atol=1e-8)
    assert recording.name == 'exact'


def test_the_bag_holds_what_was_changed(tmp_path):
    at = ['2.03:controller:deactivate', '4:controller:activate', '5:plant.k:=2',
          '6:controller.gain:=[3, 4]', '7:stimulus.amplitude:=2.25']  # fmt: skip
    words = [word for each in at for word in ('--at', each)]
    run('open', '--duration', 10, '--sampled', '--bag', tmp_path / 'bag', *words)
    found = read_bag(tmp_path / 'bag').changes
    assert [(c.node, c.what) for c in found] == [
        ('controller', 'deactivate'), ('controller', 'activate'), ('plant', 'k:=2'),
        ('controller', 'gain:=[3, 4]'), ('stimulus', 'amplitude:=2.25'),
    ]  # fmt: skip
    assert [c.stamp * 1e-9 for c in found] == pytest.approx([0.205, 0.4, 0.5, 0.6, 0.7], abs=1e-12)
    report = analyze(tmp_path / 'bag').report
    assert report.changes == simulate_run('open', 10.0, sampled=True, at=at).changes


def test_overrides_and_renamed_signals(tmp_path):
    file = tmp_path / 'run.npz'
    words = [
        '-p',
        'stimulus.output:=stim',
        '-p',
        'plant.excitatory:=[w, stim]',
        '-p',
        '/**.rate:=100',
    ]
    run('open', '--duration', 70, '--sampled', '--out', file, *words)
    with np.load(file) as found:
        assert set(found) == {'t', 'w', 'stim', 'y', 'y_r', 'u'}
        assert found['t'][1] == 0.1
        assert found['stim'].max() == 1.5


@pytest.mark.slow
@pytest.mark.parametrize(
    ('words', 'says'),
    [
        (['exact', '--delay', '0.1'], '--delay needs --sampled'),
        (['exact', '--seed', '0'], '--seed needs --sampled'),
        (['exact', '--sampled', '--loss', '1.5'], 'must be a probability'),
        (['exact', '--sampled', '--seed', '-1'], 'must be a whole number'),
        (['exact', '--duration', '0'], 'must be a finite number > 0'),
        (['exact', '--duration', '1e12'], 'shorter duration'),
        (['exact', '--out', 'x.mat'], 'must end in .npz or .csv or .parquet'),
        (['exact', '--duration', '5', '--out', '/nowhere/x.csv'], 'cannot write /nowhere/x.csv'),
        (['exact', '--bag', '/'], 'exists already'),
        (['nonsense'], 'no scenario'),
        (['exact', '-p', 'plant.rate:=50'], 'must have the same rate'),
        (
            ['exact', '-p', 'plant.output:=t', '--out', 'x.csv', '--duration', '5'],
            "must not be called 't'",
        ),
        (['linear', '-p', 'controller.gain:=[-5, 0]', '--duration', '2000'], 'stops being finite'),
    ],
)
def test_bad_input_is_one_line_and_2(words, says, refused):
    assert says in refused('simulate', *words)


@pytest.mark.slow
def test_a_short_run_imports_neither_numba_nor_ros():
    code = (
        'import sys; from eventreg_ros.cli.main import main; '
        "main(['simulate', 'exact', '--sampled', '--duration', '5']); "
        "sys.exit(bool({'numba', 'rclpy', 'matplotlib', 'scipy'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, '-c', code], stdout=subprocess.DEVNULL, check=False)
    assert result.returncode == 0


@pytest.mark.slow
def test_blind_reaches_verdict_and_bag(tmp_path):
    assert run('exact', '--blind', 0.01, '--bag', tmp_path / 'bag') == 3
    assert run('exact', '--blind', 0.3) == 0
    assert analyze(tmp_path / 'bag').criteria.blind == 0.01
