# SPDX-License-Identifier: Apache-2.0
"""What the Tab key offers, asked as bash asks argcomplete."""

import io
import os

import pytest

from eventreg_ros.cli.main import VERBS
from eventreg_ros.paper import FIGURES
from eventreg_ros.scenario import shipped
from eventreg_ros.scenario.names import KINDS

argcomplete = pytest.importorskip(
    'argcomplete', reason="needs the extra: pip install '.[completion]'"
)
END = '\013'
BREAKS = ' \t\n"\'><=;|&(:'
"""Where bash begins a new word."""


def asked(line):
    """Return the environment in which bash calls a command to complete a line."""
    return {
        '_ARGCOMPLETE': '1',
        '_ARGCOMPLETE_IFS': END,
        '_ARGCOMPLETE_COMP_WORDBREAKS': BREAKS,
        'COMP_LINE': line,
        'COMP_POINT': str(len(line)),
    }


@pytest.fixture
def offered(monkeypatch, tmp_path):
    """Return what may stand at the end of a line."""
    from eventreg_ros.cli.completion import parser

    monkeypatch.chdir(tmp_path)

    def ask(line):
        for name, value in asked(line).items():
            monkeypatch.setenv(name, value)
        out = io.StringIO()
        # It would take descriptor 9 for its own, and close it: pytest or a worker may have it.
        with monkeypatch.context() as patch:
            patch.setattr(os, 'fdopen', _refused)
            with pytest.raises(SystemExit):
                argcomplete.autocomplete(parser(line), exit_method=_exit, output_stream=out)
        return {word.strip() for word in out.getvalue().split(END)} - {''}

    return ask


def _refused(*arguments):
    raise OSError


def _exit(code):
    raise SystemExit(code)


def test_commands_and_options(offered):
    assert offered('eventreg s') == {name for name in VERBS if name.startswith('s')}
    assert offered('eventreg simulate exact --sam') == {'--sampled'}
    assert set(VERBS) <= offered('eventreg nonsense ')


def test_scenarios_and_files(offered, tmp_path):
    (tmp_path / 'mine.yaml').touch()
    (tmp_path / 'mine.txt').touch()
    assert offered('eventreg simulate mi') == {'mismatch', 'mine.yaml'}
    assert set(shipped()) <= offered('eventreg run ')
    assert offered('eventreg analyze --scenario op') == {'open'}


@pytest.mark.parametrize('quote', ['', "'", '"'])
def test_parameters_of_the_scenario_on_the_line(offered, quote):
    found = offered(f'eventreg simulate exact -p {quote}controller.ta')
    assert found == {'controller.tau:=', 'controller.tau_min:=', 'controller.tau_max:='}
    assert offered('eventreg simulate uncontrolled -p controller.') == set()
    assert offered('eventreg simulate nowhere.yaml -p controller.') == set()


def test_values_signals_nodes_and_figures(offered):
    assert offered('eventreg simulate exact -p plant.hold:=') == {'zero', 'linear'}
    assert offered('eventreg simulate exact -p plant.lockstep:=t') == {'true'}
    assert offered('eventreg simulate exact --on w,') == {'w,y', 'w,u'}
    assert offered('eventreg node ') >= set(KINDS)
    assert offered('eventreg figures ') >= set(FIGURES)
    assert 'controller.tau' in offered('eventreg set controller.')
    assert 'controller.x0' not in offered('eventreg set controller.')


def test_the_command_answers_the_shell(eventreg, tmp_path):
    answer = tmp_path / 'answer'
    environment = {**os.environ, '_ARGCOMPLETE_STDOUT_FILENAME': str(answer)}
    result = eventreg(env={**environment, **asked('eventreg simulate mism')})
    assert (result.stdout, result.stderr) == ('', '')
    assert answer.read_text().strip() == 'mismatch'
