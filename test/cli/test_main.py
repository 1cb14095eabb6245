"""The command itself: verbs, one-line errors, exit codes, what it imports."""

import os
import signal
import subprocess
import sys

import pytest

from eventreg_ros.cli import main as command
from eventreg_ros.cli.main import VERBS, build_parser, fail, main
from eventreg_ros.errors import EventregError


@pytest.mark.parametrize('verb', VERBS)
def test_every_verb_has_arguments_and_help(capsys, verb):
    with pytest.raises(SystemExit) as end:
        main([verb, '--help'])
    assert end.value.code == 0
    words = ' '.join(capsys.readouterr().out.split())
    assert VERBS[verb][1:].split(':')[0] in words


def test_help_names_every_verb(capsys):
    with pytest.raises(SystemExit) as end:
        main(['--help'])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert set(VERBS) <= {line.split()[0] for line in text.splitlines() if line.startswith('    ')}


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['nonsense'], "no command 'nonsense'"),
        (['analyze'], 'required: BAG; see eventreg analyze --help'),
        (['analyze', 'bag', '--nonsense'], 'unrecognized arguments: --nonsense'),
        (['analyze', 'bag', '--sett', '1'], 'unrecognized arguments: --sett 1'),
        (['analyze', 'bag', '--settle', 'soon'], "a finite number >= 0, got 'soon'"),
        (['analyze', 'bag', '--settle', 'nan'], "a finite number >= 0, got 'nan'"),
        (['analyze', 'bag', '--settle', '-1'], "a finite number >= 0, got '-1'"),
        (['analyze', 'bag', '--window', 'inf'], "a finite number >= 0, got 'inf'"),
        (['run', 'exact', '--duration', '0'], "a finite number > 0, got '0'"),
        (['run', 'exakt'], "no scenario 'exakt'; shipped are"),
        (['run', 'exact', '-p', 'nonsense'], '-p must be NODE.PARAM:=VALUE'),
        (['run', 'exact', '-p', 'controller.tau:=-1'], 'tau must be a finite number > 0, got -1'),
        (['run', 'none.yaml'], "scenario file 'none.yaml' does not exist; check the path"),
    ],
)
def test_bad_arguments_are_one_line(refused, arguments, words):
    assert words in refused(*arguments)


def test_errors_of_several_lines_are_told_in_one(capsys):
    assert fail('one\n  two\tthree') == 2
    assert capsys.readouterr().err == 'eventreg: one two three\n'


class Verb:
    """A verb that ends as it is told."""

    def __init__(self, end):
        self.end = end

    def add_arguments(self, parser):
        pass

    def main(self, args):
        if isinstance(self.end, BaseException):
            raise self.end
        return self.end


@pytest.mark.parametrize(
    ('end', 'code', 'words'),
    [
        (0, 0, ''),
        (1, 1, ''),
        (3, 3, ''),
        (EventregError('bad\ninput'), 2, 'eventreg: bad input\n'),
        (PermissionError(13, 'Permission denied', 'f'), 2, "Permission denied: 'f'"),
        (KeyboardInterrupt(), 130, ''),
    ],
)
def test_how_a_verb_ends_is_how_the_command_ends(capsys, monkeypatch, end, code, words):
    monkeypatch.setattr(command, 'module', lambda name: Verb(end))
    assert main(['analyze']) == code
    error = capsys.readouterr().err
    assert words in error
    assert error.count('\n') == bool(words)


def test_a_bug_is_not_hidden(monkeypatch):
    monkeypatch.setattr(command, 'module', lambda name: Verb(RuntimeError('bug')))
    with pytest.raises(RuntimeError, match='bug'):
        main(['analyze'])


def test_only_the_verb_that_is_run_is_imported():
    build_parser(None)
    assert build_parser('analyze').parse_args(['analyze', 'bag']).verb == 'analyze'


# As a process -------------------------------------------------------------------------------------


def test_as_a_module(eventreg):
    result = eventreg('analyze', '/no/such/bag')
    assert result.returncode == 2
    assert result.stdout == ''
    assert result.stderr == 'eventreg: bag /no/such/bag does not exist; check the path\n'


def test_without_arguments(eventreg):
    result = eventreg()
    assert (result.returncode, result.stderr) == (2, '')
    assert 'usage: eventreg' in result.stdout


def test_a_reader_that_goes_away_is_no_error(make_bag):
    bag = make_bag(w=[110, 150, 190], y=[], u=[])
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, '-m', 'eventreg_ros', 'analyze', str(bag)]
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    environment.pop('PYTHONUNBUFFERED', None)
    result = subprocess.run(
        command, stdout=write, stderr=subprocess.PIPE, env=environment, check=False
    )
    os.close(write)
    assert result.stderr == b''
    assert result.returncode == 128 + signal.SIGPIPE
