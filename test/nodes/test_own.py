# SPDX-License-Identifier: Apache-2.0
"""Blocks of one's own whose code raises: the node goes through its fault state, and lives on."""

import pytest

from eventreg_ros.nodes.own import OwnBlock, Parameter, run


class Failing(OwnBlock):
    """Divides by zero at its third step."""

    def start(self):
        self.left = 3
        return 0.0

    def advance(self, inputs, h):
        self.left -= 1
        return 1.0 / self.left


class Startless(OwnBlock):
    """Has forgotten to return its first output."""

    def start(self):
        return None


@pytest.mark.parametrize(
    ('block', 'words'),
    [
        (Failing, 'Failing.advance failed at step 3: ZeroDivisionError: float division by zero'),
        (Startless, 'Startless.start failed at step 0: TypeError'),
    ],
)
def test_an_exception_becomes_the_fault_of_the_node(bench, block, words):
    node = bench.add(block)
    bench.until(lambda: node.fault is not None)
    assert words in node.fault
    bench.until(lambda: node.stage == 'unconfigured')


class Wordy(Failing):
    """Raises what cannot be put into words, or at great length."""

    words = 'x' * 1000

    def advance(self, inputs, h):
        raise WordyError(self.words)


class WordyError(Exception):
    def __str__(self):
        return {'': None}.get(self.args[0], self.args[0])


class Wordless(Wordy):
    words = ''


@pytest.mark.parametrize('block', [Wordy, Wordless])
def test_a_fault_is_one_line_whatever_the_exception_says(bench, block, monkeypatch):
    lines = []
    logger = type(bench.peer.get_logger())
    monkeypatch.setattr(logger, 'error', lambda self, line: lines.append(line))
    node = bench.add(block)
    bench.until(lambda: node.stage == 'unconfigured')
    (line,) = lines
    assert f'{block.__name__}.advance failed at step 1: WordyError' in line
    assert line.endswith("configure' and 'activate'")
    assert len(line) <= 300


class Leaking(Failing):
    """A tank that leaks."""

    parameters = (Parameter('leak', 'double', 0.1, 'outflow per level', low=0.0),)


def test_help_says_what_it_is_and_lists_its_parameters_and_those_of_every_block(capsys):
    assert run(Leaking, ['tank', '--help']) == 0
    out = capsys.readouterr().out
    assert 'usage: tank' in out
    assert '  leak = 0.1: outflow per level (a finite number >= 0)' in out
    assert all(f'  {name} = ' in out for name in ('rate', 'time_scale', 'excitatory', 'output'))
