# SPDX-License-Identifier: Apache-2.0
"""A run from Python: what it leaves as it was, and where it may be called."""

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from eventreg_ros import load, run
from eventreg_ros.errors import EventregError
from eventreg_ros.session import live
from eventreg_ros.session.observer import Observer
from eventreg_ros.session.session import Session

pytest.importorskip('rclpy')


def test_a_run_in_another_thread_leaves_the_environment_as_it_was(tmp_path, monkeypatch):
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)
    monkeypatch.delenv('FASTDDS_BUILTIN_TRANSPORTS', raising=False)
    before = dict(os.environ)
    settings = {'duration': 2.0, 'bag': tmp_path / 'bag', 'lockstep': True, 'composed': True}
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(run, 'exact', **settings).result()
    assert found.troubles == []
    assert len(found.t) == 2.0 * found.scenario.rate + 1
    assert dict(os.environ) == before


class Heard(Observer):
    def __init__(self):
        self.lines = []

    def warned(self, line):
        self.lines.append(line)


@pytest.mark.parametrize(
    ('scenario', 'setting', 'words'),
    [
        (
            'exact', {'controller.adapt': 0.2},
            ['controller learns with adapt 0.2, and above 0.08 it need not converge'],
        ),
        (
            'quiescent', {'controller.adapt': 0.04},
            ['controller has no generator to learn tau of; without w tau runs'],
        ),
        ('exact', {'controller.adapt': 0.04}, []),
        ('late', {'plant.lead': 3}, ['controller.lead is 2 and plant.lead is 3 of model time']),
        ('late', {'/**.lead': 3}, []),
        ('exact', {'plant.lead': 3}, []),
    ],
)  # fmt: skip
def test_what_cannot_go_well_is_said_before_it_begins(
    tmp_path, monkeypatch, scenario, setting, words
):
    def perform(session):
        raise EventregError('begins')

    monkeypatch.setattr(Session, 'perform', perform)
    heard = Heard()
    with pytest.raises(EventregError, match='begins'):
        live.run(load(scenario, setting), bag=tmp_path / 'bag', observer=heard)
    assert [line[: len(word)] for line, word in zip(heard.lines, words, strict=True)] == words
