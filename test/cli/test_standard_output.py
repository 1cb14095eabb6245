# SPDX-License-Identifier: Apache-2.0
"""Where F is -: the file alone on standard output, everything else on standard error."""

import csv
import io
import json
import os
from xml.etree import ElementTree

import pytest

from eventreg_ros.cli.main import main

W = [110, 150, 190, 230]


@pytest.fixture
def split(capsys):
    """Run the command in this process: (exit code, output, errors)."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def bag(make_bag):
    return make_bag(w=W, y=[], u=W)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('option', 'read'),
    [
        ('--json', lambda text: json.loads(text)['verdict']),
        ('--junit', lambda text: ElementTree.fromstring(text).get('tests')),
        ('--plot', lambda text: ElementTree.fromstring(text).tag),
        ('--report', lambda text: text.index('<!DOCTYPE html>')),
    ],
)
def test_the_file_is_all_that_is_on_standard_output(split, bag, tmp_path, option, read):
    code, out, err = split('analyze', bag, option, '-')
    assert code == 0
    assert read(out) in ('rejected', '1', '{http://www.w3.org/2000/svg}svg', 0)
    assert 'verdict: rejected' in err
    if option == '--json':
        split('analyze', bag, option, tmp_path / 'file')
        assert out == (tmp_path / 'file').read_text(encoding='utf-8')


def test_signals_go_there_as_csv(split):
    code, out, err = split('simulate', 'exact', '--duration', '20', '--settle', 5, '--out', '-')
    rows = list(csv.reader(io.StringIO(out)))
    assert rows[0] == ['t', 'w', 'y', 'u']
    assert len(rows) == 402
    assert code == 3
    assert 'verdict: undecided' in err


def test_the_same_for_verbs_without_a_verdict(split, bag):
    code, out, err = split('compare', bag, bag, '--json', '-')
    assert (code, json.loads(out)['runs']) == (0, ['bag', 'bag (2)'])
    assert 'verdict' in err


@pytest.mark.slow
def test_as_a_process_with_any_output(eventreg, bag, tmp_path):
    result = eventreg('analyze', bag, '--json', '-')
    assert json.loads(result.stdout)['verdict'] == 'rejected'
    assert 'verdict: rejected' in result.stderr


def test_two_files_are_not_mixed(refused, bag):
    words = refused('analyze', bag, '--json', '-', '--junit', '-')
    assert 'only one file can go to standard output, got --json - and --junit -' in words


def test_a_verb_that_fails_prints_nothing(refused, tmp_path):
    assert 'does not exist' in refused('analyze', tmp_path / 'none', '--json', '-')


def test_no_file_of_that_name_is_made_and_nothing_is_left(split, bag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('TMPDIR', str(tmp_path))
    monkeypatch.setattr('tempfile.tempdir', None)
    before = sorted(os.listdir(tmp_path))
    split('analyze', bag, '--json', '-')
    assert sorted(os.listdir(tmp_path)) == before


def test_children_write_to_standard_error(python):
    code = (
        'import os, subprocess, sys\n'
        'from eventreg_ros.cli.standard_output import _children_redirected\n'
        'with _children_redirected(): subprocess.run(["echo", "a child"])\n'
        'subprocess.run(["echo", "another"])\n'
    )
    result = python('-c', code)
    assert (result.stdout, result.stderr) == ('another\n', 'a child\n')
