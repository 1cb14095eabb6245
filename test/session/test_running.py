# SPDX-License-Identifier: Apache-2.0
"""Who runs here: announced while it goes on, forgotten when it was killed."""

import json
import os

import pytest

from eventreg_ros.errors import EventregError
from eventreg_ros.session.running import announced, of_domain, runs, the_run

ENVIRONMENT = {'ROS_DOMAIN_ID': '7', 'FASTDDS_X': 'a', 'HOME': '/nowhere'}


@pytest.fixture(autouse=True)
def alone(monkeypatch, tmp_path):
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path))
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)


def test_a_run_is_there_while_it_goes_on():
    assert the_run() is None
    with announced('exact', ('plant', 'controller'), ENVIRONMENT):
        run = the_run()
        assert (run.pid, run.scenario, run.nodes) == (os.getpid(), 'exact', ('plant', 'controller'))
        assert run.environment == {'ROS_DOMAIN_ID': '7', 'FASTDDS_X': 'a'}
    assert runs() == []


def test_runs_that_were_killed_and_other_files_are_removed(tmp_path):
    home = tmp_path / f'eventreg_runs_{os.getuid()}'
    home.mkdir()
    (home / '4194305.json').write_text(json.dumps({'scenario': 'x'}))  # beyond the largest pid
    (home / f'{os.getpid()}.json').write_text('{')
    assert runs() == []
    assert list(home.iterdir()) == []


def test_who_looks_while_a_run_is_being_announced_does_not_take_it_away(monkeypatch):
    dumps, seen = json.dumps, []

    def looked_at(data):
        seen.append(runs())
        return dumps(data)

    monkeypatch.setattr(json, 'dumps', looked_at)
    with announced('exact', ('plant',), ENVIRONMENT):
        assert seen == [[]]
        assert the_run() is not None


def test_several_runs_must_be_chosen_from(tmp_path):
    with announced('exact', ('plant',), ENVIRONMENT):
        home = tmp_path / f'eventreg_runs_{os.getuid()}'
        text = (home / f'{os.getpid()}.json').read_text()
        (home / f'{os.getppid()}.json').write_text(text)
        with pytest.raises(EventregError, match='export its ROS_DOMAIN_ID'):
            the_run()


def test_a_domain_that_is_given_needs_no_run(monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', '3')
    with announced('exact', ('plant',), ENVIRONMENT):
        assert the_run() is None


def test_the_run_of_a_domain_is_named():
    with announced('exact', ('plant',), ENVIRONMENT):
        assert of_domain('7') == 'exact on ROS_DOMAIN_ID=7'
        assert of_domain('8') == 'ROS_DOMAIN_ID=8'


def test_a_directory_that_others_may_write_to_is_not_believed(tmp_path):
    home = tmp_path / f'eventreg_runs_{os.getuid()}'
    home.mkdir()
    with announced('exact', ('plant',), ENVIRONMENT):
        (text,) = (file.read_text() for file in home.iterdir())
    home.mkdir()
    home.chmod(0o777)
    (home / f'{os.getpid()}.json').write_text(text)
    assert runs() == []
    with announced('exact', ('plant',), ENVIRONMENT):
        assert [file.read_text() for file in home.iterdir()] == [text]  # not written to either
