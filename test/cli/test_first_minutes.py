# SPDX-License-Identifier: Apache-2.0
"""list, new, set, activate, deactivate, --version, and what a typing error gets."""

import os
import re
from pathlib import Path

import pytest

from eventreg_ros import __version__
from eventreg_ros.cli.main import VERBS, main
from eventreg_ros.scenario import load, shipped

ROOT = Path(__file__).resolve().parents[2]


def test_the_version_and_the_help(capsys):
    with pytest.raises(SystemExit) as end:
        main(['--version'])
    assert end.value.code == 0
    assert capsys.readouterr().out == f'eventreg_ros {__version__}\n'
    assert main([]) == 2
    out = capsys.readouterr().out
    assert all(verb in out for verb in VERBS)


@pytest.mark.parametrize('verb', VERBS)
def test_every_help_begins_with_a_verb_and_shows_examples_that_parse(verb, capsys):
    with pytest.raises(SystemExit) as end:
        main([verb, '--help'])
    assert end.value.code == 0
    assert 'usage: eventreg' in capsys.readouterr().out
    assert VERBS[verb].split()[0].islower()


def test_a_misspelt_command_gets_the_nearest(refused):
    assert "did you mean 'simulate'?" in refused('simluate', 'exact')


def test_list_names_every_scenario_with_a_sentence(capsys):
    assert main(['list']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[: len(shipped())]] == shipped()
    assert all(line.rstrip().endswith('.') for line in lines[: len(shipped())])


@pytest.mark.parametrize('source', ['mismatch', 'open'])
def test_new_writes_a_scenario_that_loads(tmp_path, capsys, refused, source):
    file = tmp_path / 'mine.yaml'
    assert main(['new', str(file), '--from', source]) == 0
    capsys.readouterr()
    assert load(str(file)).nodes == load(source).nodes
    assert file.read_text().startswith('# A scenario')
    assert 'exists already' in refused('new', file)
    assert 'must end in .yaml' in refused('new', tmp_path / 'mine')


@pytest.mark.ros
def test_set_and_switch_reach_the_run_of_this_machine(spawn, tmp_path):
    rclpy = pytest.importorskip('rclpy', reason='needs ROS 2: pip install eventreg_ros[ros]')
    assert rclpy
    environment = {**os.environ, 'TMPDIR': str(tmp_path), 'PYTHONPATH': str(ROOT)}
    environment.pop('ROS_DOMAIN_ID', None)

    def eventreg(*words):
        process = spawn('-m', 'eventreg_ros', *words, env=environment, cwd=tmp_path)
        out, err = process.communicate(timeout=60)
        return process.returncode, out, err

    code, _, err = eventreg('set', 'controller.k', '3')
    assert code == 2
    assert 'start one with eventreg run' in err
    run = spawn(
        '-m', 'eventreg_ros', 'run', 'exact', '--duration', '600', '--bag', 'bag',
        env=environment, cwd=tmp_path,
    )  # fmt: skip
    began = ''
    for line in run.stdout:
        began += line
        if 'events:' in line:
            break

    def said(*words):
        code, out, _ = eventreg(*words)
        found = re.fullmatch(r'(.*) in exact on ROS_DOMAIN_ID=(\d+)\n', out)
        assert code == 0
        assert f'ROS_DOMAIN_ID={found[2]} ' in began
        return found[1]

    assert said('set', 'controller.k', '3') == 'controller.k is 3'
    code, _, err = eventreg('set', 'controller.tau', '0')
    assert code == 2
    assert 'controller.tau must be a finite number > 0' in err
    assert "did you mean 'controller'" in eventreg('deactivate', 'controler')[2]
    assert said('deactivate', 'controller') == 'controller is inactive'
    assert said('activate', 'controller') == 'controller is active'
    run.terminate()
    assert run.wait(60) in (0, 1, 3)
    assert not list(tmp_path.glob('eventreg_runs_*/*.json'))
