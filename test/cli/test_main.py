# SPDX-License-Identifier: Apache-2.0
"""The command itself: verbs, one-line errors, exit codes, what it imports."""

import json
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
        (['analyze'], 'analyze needs a bag: give its path, or --last'),
        (['analyze', 'bag', '--nonsense'], '--nonsense; see eventreg analyze --help'),
        (['analyze', 'bag', '--sett', '1'], 'unrecognized arguments: --sett 1'),
        (['analyze', 'bag', '--settle', 'soon'], "a finite number >= 0, got 'soon'"),
        (['analyze', 'bag', '--settle', 'nan'], "a finite number >= 0, got 'nan'"),
        (['analyze', 'bag', '--settle', '-1'], "a finite number >= 0, got '-1'"),
        (['analyze', 'bag', '--window', 'inf'], "a finite number >= 0, got 'inf'"),
        (['run', 'exact', '--duration', '0'], "a finite number > 0, got '0'"),
        (['run', 'exakt'], "no scenario 'exakt'; did you mean 'exact'"),
        (['run', 'exact', '-p', 'nonsense'], 'an override must be NODE.PARAM:=VALUE'),
        (['run', 'exact', '-p', 'controller.tau:=-1'], 'tau must be a finite number > 0, got -1'),
        (['set', 'plant', '3'], "set takes NODE.PARAM VALUE (controller.tau 0.0625), got 'plant'"),
        (['run', 'none.yaml'], "scenario file 'none.yaml' does not exist; check the path"),
    ],
)
def test_bad_arguments_are_one_line(refused, arguments, words):
    assert words in refused(*arguments)


def test_errors_of_several_lines_are_reported_in_one(capsys):
    assert fail('one\n  two\tthree') == 2
    assert capsys.readouterr().err == 'eventreg: one two three\n'


class Verb:
    """A verb that ends in a given way."""

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
        (BrokenPipeError(), 141, ''),
        (MemoryError(), 2, 'eventreg: out of memory; take a shorter duration'),
    ],
)
def test_how_a_verb_ends_is_how_the_command_ends(capsys, monkeypatch, end, code, words):
    monkeypatch.setattr(command, 'module', lambda name: Verb(end))
    assert main(['analyze']) == code
    error = capsys.readouterr().err
    assert words in error
    assert error.count('\n') == bool(words)


@pytest.mark.parametrize('bug', [RuntimeError('bug'), RecursionError('bug'), ValueError('bug')])
def test_a_bug_has_an_exit_code_that_is_no_verdict(monkeypatch, capsys, bug):
    monkeypatch.setattr(command, 'module', lambda name: Verb(bug))
    monkeypatch.delenv('EVENTREG_DEBUG', raising=False)
    assert main(['analyze']) == 70
    line = capsys.readouterr().err
    assert line.count('\n') == 1
    assert f'fault of its own, please report it: {type(bug).__name__}: bug' in line
    monkeypatch.setenv('EVENTREG_DEBUG', '1')
    assert main(['analyze']) == 70
    assert 'Traceback (most recent call last)' in capsys.readouterr().err


def test_a_package_that_exits_gives_no_verdict(monkeypatch, capsys):
    monkeypatch.setattr(command, 'module', lambda name: Verb(SystemExit(0)))
    assert main(['analyze']) == 70
    assert 'something called sys.exit(0)' in capsys.readouterr().err


def test_only_the_verb_that_is_run_is_imported():
    build_parser(None)
    assert build_parser('analyze').parse_args(['analyze', 'bag']).verb == 'analyze'


def test_a_long_error_loses_its_middle_and_keeps_place_and_remedy(capsys):
    fail(f'bag here/{"x" * 100_000}: fix it')
    line = capsys.readouterr().err
    assert len(line) == 301
    assert line.startswith('eventreg: bag here/xxx')
    assert line.endswith('xxx: fix it\n')
    assert ' [...] ' in line


def test_an_error_prints_nothing_that_a_terminal_obeys(capsys):
    fail('no file \x1b[2Jgone\x07 \u202e')
    assert capsys.readouterr().err == 'eventreg: no file \\x1b[2Jgone\\x07 \\u202e\n'


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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize('closed', ['>&-', '2>&-', '<&- >&- 2>&-'])
def test_a_closed_stream_changes_nothing(tmp_path, closed):
    """What is written must not land in a file that got the number of the stream."""
    out = tmp_path / 'x.json'
    arguments = ['simulate', 'exact', '--duration', '5', '--json', out]
    command = ' '.join(map(str, [sys.executable, '-m', 'eventreg_ros', *arguments, closed]))
    result = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert result.returncode == 3  # undecided: it is short
    assert result.stderr == ''
    assert json.loads(out.read_text())['verdict'] == 'undecided'


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists('/dev/full'), reason='no /dev/full')
def test_a_full_disk_under_the_output_is_one_line():
    with open('/dev/full', 'w') as full:
        result = subprocess.run(
            [sys.executable, '-m', 'eventreg_ros', 'simulate', 'exact', '--duration', '5'],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert (result.returncode, result.stderr.count('\n')) == (2, 1)
    assert result.stderr == 'eventreg: output: no space left on device; send it elsewhere\n'


@pytest.mark.slow
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_two_signals_end_a_command_with_130_and_without_a_word(spawn, number):
    code = (
        'import sys, time, eventreg_ros.__main__ as start\n'
        'from eventreg_ros.cli import main\n'
        'class Verb:\n'
        '  def add_arguments(parser): pass\n'
        '  def main(args):\n'
        '    try:\n'
        '      print("at it", flush=True); time.sleep(60)\n'
        '    finally:\n'
        '      print("cleaning", flush=True); time.sleep(0.3); print("done", flush=True)\n'
        'main.module = lambda name: Verb\n'
        'sys.argv = ["eventreg", "analyze"]\n'
        'sys.exit(start.main())\n'
    )
    process = spawn('-c', code)
    assert process.stdout.readline() == 'at it\n'
    process.send_signal(number)
    assert process.stdout.readline() == 'cleaning\n'
    process.send_signal(number)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out, err) == (130, 'done\n', '')


@pytest.mark.parametrize(('verb', 'code'), [('analyze', 130), ('node', 0)])
def test_a_signal_while_it_imports_ends_it_quietly(spawn, verb, code):
    program = (
        'import sys, time\n'
        'class Slow:\n'
        '  def find_spec(self, name, path=None, target=None):\n'
        '    if name == "eventreg_ros.cli.main": print("import", flush=True); time.sleep(60)\n'
        'import eventreg_ros.__main__ as start\n'
        'sys.meta_path.insert(0, Slow())\n'
        f'sys.argv = ["eventreg", "{verb}", "plant"]\n'
        'sys.exit(start.main())\n'
    )
    process = spawn('-c', program)
    assert process.stdout.readline() == 'import\n'
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out, err) == (code, '', '')
