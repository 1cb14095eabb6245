# SPDX-License-Identifier: Apache-2.0
"""The command sweep: words, JSON, files, and what it refuses."""

import json

import pytest

from eventreg_ros.cli.main import main

QUICK = ('-p', '/**.rate:=50', '--duration', '250', '--settle', '60')
GRID = ('-p', 'controller.k:=0.5..2/6', '-p', 'controller.tau:=0.05..0.1/5log')


@pytest.mark.slow
def test_a_grid(tmp_path, capsys):
    files = [tmp_path / name for name in ('f.json', 'f.svg', 'f.html')]
    code = main(
        ['sweep', 'exact', *GRID, *QUICK, '--out', str(tmp_path / 'a.csv'), '--json', str(files[0]),
         '--plot', str(files[1]), '--report', str(files[2])]
    )  # fmt: skip
    assert code == 0
    found = json.loads(files[0].read_text())
    assert found['parameters'] == {
        'controller.k': '0.5..2/6', 'controller.tau': '0.05..0.1/5log'
    }  # fmt: skip
    assert found['sets'] == 30 == found['rejected'] + found['not_rejected']
    assert found['out'] == str(tmp_path / 'a.csv')
    captured = capsys.readouterr()
    assert 'exact: 30 sets of controller.k, controller.tau' in captured.out
    assert files[1].read_text().startswith('<?xml')
    page = files[2].read_text()
    assert '<svg' in page
    assert '0.5..2/6' in page


@pytest.mark.slow
def test_random_sets_have_a_yield_and_a_worst_scenario(tmp_path, capsys):
    out = tmp_path / 'a.csv'
    ranges = ('-p', 'controller.k:=0.7~20%', '-p', 'links.delay:=0..0.4')
    arguments = [*ranges, *QUICK, '--sets', '40', '--seed', '3', '--out', str(out)]
    code = main(['sweep', 'exact', *arguments, '--json', str(tmp_path / 'f.json')])
    assert code == 0
    found = json.loads((tmp_path / 'f.json').read_text())
    assert found['yield']['low'] < found['yield']['share'] <= found['yield']['high']
    assert 'yield' in capsys.readouterr().out
    command = (out / 'worst.yaml').read_text().splitlines()[0].split()
    assert command[:3] == ['#', 'eventreg', 'simulate']
    again = [str(out / 'worst.yaml'), *command[4:]]
    assert main(['simulate', *again]) in (0, 1)


@pytest.mark.slow
def test_a_border(tmp_path, capsys):
    out, file = tmp_path / 'b', tmp_path / 'f.json'
    ranges = ('-p', 'exosystem.tau:=0.04..0.2/40', '-p', 'controller.k:=0.5..2/40')
    code = main(
        ['sweep', 'exact', *ranges, *QUICK, '--border', 'exosystem.tau,controller.k',
         '--out', str(out), '--json', str(file), '--plot', str(tmp_path / 'f.svg')]
    )  # fmt: skip
    assert code == 0
    found = json.loads(file.read_text())
    assert found['border'] == ['exosystem.tau', 'controller.k']
    assert found['runs'] < found['grid'] == 1600
    assert found['curves']
    assert (out / 'border.csv').read_text().startswith('curve,exosystem.tau,controller.k\n')
    words = capsys.readouterr().out
    assert f'{found["runs"]} runs' in words
    assert found['undecided'] > found['bad'] == 0  # a slow generator has fewer than three events
    assert f'{found["undecided"]} of the runs undecided and 0 without a verdict' in words
    orbit = found['orbit']
    lines = (out / 'border_orbit.csv').read_text().splitlines()
    assert lines[0] == 'curve,exosystem.tau,controller.k,off,within'
    assert len(lines) == 1 + sum(map(len, orbit['curves'])) == 1 + orbit['points'] > 10
    assert orbit['curves'][0][0] == list(map(float, lines[1].split(',')[1:3]))
    assert orbit['apart'] < 0.75
    assert f'followed as the orbit whose largest y is 1: {len(orbit["curves"])} curves of ' in words


@pytest.mark.slow
def test_a_border_that_is_no_orbit(tmp_path, capsys):
    out, file = tmp_path / 'b', tmp_path / 'f.json'
    ranges = ('-p', 'links.delay:=0..0.8/9', '-p', 'controller.k:=0.5..2/9')
    code = main(
        ['sweep', 'exact', *ranges, *QUICK, '--border', 'links.delay,controller.k',
         '--out', str(out), '--json', str(file), '--plot', str(tmp_path / 'f.svg')]
    )  # fmt: skip
    assert code == 0
    words = capsys.readouterr().out
    assert 'not followed as a periodic orbit: links.delay is not in the equations' in words
    assert (out / 'border_orbit.csv').read_text() == 'curve,links.delay,controller.k,off,within\n'
    found = json.loads(file.read_text())
    assert found['curves']
    assert found['orbit']['curves'] == []
    assert found['orbit']['reason'] == 'links.delay is not in the equations'


@pytest.mark.slow
def test_the_worst_set(tmp_path, capsys):
    ranges = ('-p', 'controller.k:=0.7..3', '-p', 'exosystem.tau:=0.07..0.1')
    file, plot = tmp_path / 'f.json', tmp_path / 'f.svg'
    code = main(
        ['sweep', 'exact', *ranges, *QUICK, '--worst', '64', '--json', str(file),
         '--plot', str(plot), '--out', str(tmp_path / 'w')]
    )  # fmt: skip
    assert code == 0
    found = json.loads(file.read_text())
    assert set(found['worst']) == {'controller.k', 'exosystem.tau'}
    assert f'verdict: {found["verdict"]}' in capsys.readouterr().out
    assert plot.stat().st_size > 1000
    assert main(['simulate', str(tmp_path / 'w' / 'worst.yaml'), '--sampled']) in (0, 1)


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['-p', 'controller.k:=1..2'], '--sets N, or write controller.k:=A..B/N'),
        (['-p', 'controller.k:=1..2/5', '--indices'], '--indices draws sets'),
        (['--sets', '5'], 'none is varied'),
        (['-p', 'links.delay:=-1'], 'delay must be >= 0'),
        (['-p', 'controller.k:=1..2/5', '--border', 'a,b', '--sets', '3'], 'one at a time'),
        (['-p', 'controller.k:=1..2/5', '--border', 'a,b'], '--border X,Y takes'),
        (['-p', 'controller.k:=1..2/5', '--plot', 'f.txt'], '--plot must end in'),
        (['-p', 'controller.k:=1..2/5', '--on', 'z'], "no block listens to 'z'"),
        (['-p', 'controller.k:=1..2/5', '--on', ','], 'must name signals'),
        (['-p', 'controller.k:=1', 'controller.k:=2'], "list in quotes, 'NODE.PARAM:={1,2}'"),
        (['-p', 'controller.k:=1..2/5', '-p', '/**.k:=2'], 'controller.k is varied already'),
        (['-p', 'plant.k:=1..2/5', '-p', '/**.k:=1..2/3'], 'plant.k is varied already'),
        (['-p', 'plant.k[0]:=1..2/5'], 'plant.k is no list; leave out [0]'),
        (['-p', 'plant.x0[2]:=1..2/5'], 'plant.x0 has 2 entries'),
        (['-p', 'plat.x0[1]:=1'], "no node 'plat'"),
        (['-p', 'controller.k:=1..2/5', '--sobol'], '--sobol draws sets'),
        (['-p', 'controller.k:=1..2', '--worst', '9', '--sets', '3'], 'one at a time'),
        (['-p', 'controller.k:=1..2', '--worst', '9', '--engine', 'dask'], 'on this machine'),
        (['-p', 'controller.k:=1..2/5', '--scheduler', 'tcp://a:1'], 'add --engine dask'),
    ],
)
def test_what_is_refused(refused, arguments, words):
    assert words in refused('sweep', 'exact', *arguments)
