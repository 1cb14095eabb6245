# SPDX-License-Identifier: Apache-2.0
"""What the client of a run says when a node refuses what it is asked."""

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from rcl_interfaces.msg import SetParametersResult

from eventreg_ros.errors import EventregError
from eventreg_ros.session.client import ACTIVATE, DEACTIVATE, Client


@pytest.fixture
def answering(monkeypatch):
    """Make a client whose nodes refuse, in a state, for a reason."""

    def make(label='', number=0, reason=''):
        answers = {
            'change_state': SimpleNamespace(success=False),
            'get_state': SimpleNamespace(current_state=SimpleNamespace(id=number, label=label)),
            'set_parameters': SimpleNamespace(
                results=[SetParametersResult(successful=False, reason=reason)]
            ),
        }
        monkeypatch.setattr(
            Client,
            '_call',
            lambda self, service, name, requests, _: dict.fromkeys(requests, answers[name]),
        )
        return Client(lambda: None)

    return make


@pytest.mark.parametrize(
    ('transition', 'words'), [(ACTIVATE, 'be activated'), (DEACTIVATE, 'be deactivated')]
)
def test_a_node_that_refuses_a_transition_is_named_with_its_state(answering, transition, words):
    client = answering('unconfigured', 1)
    with pytest.raises(EventregError, match=f'^plant refuses to {words} and is unconfigured; its'):
        client.transition(['plant'], transition)


def test_a_refusal_of_a_state_that_is_reached_is_none(answering):
    answering('active', 3).transition(['plant'], ACTIVATE)


@pytest.mark.parametrize(
    ('reason', 'line'),
    [
        ('plant.k must be >= 0, got -1', 'plant.k must be >= 0, got -1'),
        ("plant has no parameter 'k'", "plant has no parameter 'k'"),
        ('out of range', 'plant.k: out of range'),
    ],
)
def test_a_parameter_is_named_once(answering, reason, line):
    with pytest.raises(EventregError) as caught:
        answering(reason=reason).set_parameter('plant', 'k', 1.0)
    assert str(caught.value) == line
