# SPDX-License-Identifier: Apache-2.0
import json
import re
import subprocess
import sys

import pytest

from eventreg_ros.cli.main import main

QUICK = ['--duration', '200', '--seeds', '2', '--rate', '100']
COARSE = ['--duration', '200', '--seeds', '2', '--rate', '20']


def run(*words):
    return main(['margin', *map(str, words)])


def limits_of(hold):
    """The limits of one hold in the JSON by the names that the table gives them."""
    alone = {f'delay of {signal}': limit for signal, limit in hold['delay_of'].items()}
    return {**{name: hold[name] for name in ('delay', 'loss', 'jitter')}, **alone}


def test_the_table_and_the_json_say_the_same(tmp_path, capsys):
    file = tmp_path / 'm.json'
    assert run('linear', *QUICK, '-p', '/**.time_scale:=5', '--json', file) == 0
    out, err = capsys.readouterr()
    # Where compiling takes long, the progress shows.
    assert all(re.match(r'\d+ of 12 searches', line) for line in err.splitlines())
    report = json.loads(file.read_text())
    assert report.pop('holds').keys() == {'zero', 'linear'}
    assert report == {
        'scenario': 'linear', 'time_scale': 5.0, 'duration': 200.0, 'settle': 100.0,
        'window': 5.0, 'seeds': 2,
    }  # fmt: skip
    holds = json.loads(file.read_text())['holds']
    zero = holds['zero']['delay']
    assert zero['h'] == zero['resolution'] == 0.05
    assert zero['milliseconds'] == pytest.approx(1000.0 * zero['largest'] / 5.0)
    assert holds['zero']['loss']['milliseconds'] is None
    rows = {line[:12].strip(): line[12:] for line in out.splitlines()[2:] if line[0] != '>'}
    assert list(rows) == ['delay', 'loss', 'jitter', 'delay of w', 'delay of y', 'delay of u']
    for name, row in rows.items():
        for hold in holds.values():
            assert f'{limits_of(hold)[name]["largest"]:g}' in row.split()
    assert f'({zero["milliseconds"]:g} ms)' in rows['delay']


@pytest.mark.slow
def test_runs_and_their_pictures_are_the_same_twice(tmp_path, capsys):
    found = []
    for name in ('a', 'b'):
        picture, file = tmp_path / f'{name}.svg', tmp_path / f'{name}.json'
        assert (
            run('linear', *COARSE, '-p', '/**.time_scale:=4', '--plot', picture, '--json', file)
            == 0
        )
        found.append((picture.read_bytes(), file.read_text(), capsys.readouterr().out))
    assert found[0] == found[1]
    shown = json.loads(found[0][1])['map']
    assert set(shown) == {'rate', 'h', 'delays', 'losses', 'rejected'}
    for share in shown['rejected'].values():
        assert len(share) == len(shown['losses'])
        assert {len(row) for row in share} == {len(shown['delays'])}
        assert share[0][0] == 1.0


@pytest.mark.slow
@pytest.mark.parametrize('kind', ['png', 'pdf'])
def test_the_suffix_is_the_format(tmp_path, kind, monkeypatch):
    monkeypatch.setattr('eventreg_ros.simulation.jit.compiles', lambda: False)  # the smaller map
    file = tmp_path / f'm.{kind}'
    assert run('uncontrolled', *COARSE, '--plot', file) == 0
    assert file.read_bytes()[:4] == {'png': b'\x89PNG', 'pdf': b'%PDF'}[kind]


def test_no_margin_is_an_answer(tmp_path, capsys):
    file = tmp_path / 'm.json'
    assert run('uncontrolled', *QUICK, '--json', file) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1].startswith('none: the verdict is not rejected even without')
    holds = json.loads(file.read_text())['holds']
    assert {x['largest'] for hold in holds.values() for x in limits_of(hold).values()} == {None}


@pytest.mark.slow
def test_a_loop_that_tolerates_all_that_is_tried(capsys):
    # a plant that hears nothing does not spike, however late it hears it
    assert run('uncontrolled', *COARSE, '-p', 'plant.excitatory:=[]') == 0
    rows = capsys.readouterr().out.splitlines()
    assert '>= 2 (200 ms)' in rows[2]
    assert rows[-1] == '>=: nothing failed as far as was searched'


def test_progress_is_one_line_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setattr('sys.stderr.isatty', lambda: True)
    run('uncontrolled', *QUICK)
    err = capsys.readouterr().err
    assert '\n' not in err
    assert 'zero hold, delay 0: not rejected' in err
    assert err.split('\r')[-1] == '\x1b[K'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('words', 'says'),
    [
        (['quiescent'], 'scenario quiescent has no verdict'),
        (['exact', '--duration', '120'], 'take a longer --duration'),
        (['exact', '--seeds', '0'], 'must be a whole number >= 1'),
        (['exact', '--rate', '0'], 'must be a finite number > 0'),
        (['exact', '--rate', '1e9'], 'shorter duration'),
        (['exact', '--plot', 'x.gif'], '--plot must end in .pdf, .svg, .png'),
        (['exact', '--plot', 'png'], '--plot must end in'),
        (['exact', '--plot', '/nowhere/x.png'], 'cannot write /nowhere/x.png'),
        (['exact', '-p', 'plant.rate:=50'], 'must have the same rate'),
        (['lonely.yaml'], 'has no plant'),
        (['uncontrolled', *QUICK, '--json', '/nowhere/x.json'], 'cannot write /nowhere/x.json'),
        (['nonsense'], 'no scenario'),
    ],
)
def test_bad_input_is_one_line_and_2(words, says, refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'lonely.yaml').write_text('exosystem: {ros__parameters: {}}')
    assert says in refused('margin', *words)


@pytest.mark.slow
def test_it_imports_neither_ros_nor_what_it_does_not_use():
    code = (
        'import sys; from eventreg_ros.cli.main import main; '
        "main(['margin', 'uncontrolled', '--duration', '200', '--rate', '100']); "
        "sys.exit(bool({'rclpy', 'matplotlib'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, '-c', code], stdout=subprocess.DEVNULL, check=False)
    assert result.returncode == 0
