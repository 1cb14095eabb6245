# SPDX-License-Identifier: Apache-2.0
"""Requests to a node's parameter services that rclpy itself stumbles over: refused one by one."""

from functools import partial

import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically

from eventreg_ros.nodes.block import BlockNode

GOOD = Parameter(
    name='k', value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=2.5)
)
UNKNOWN = Parameter(name='tau', value=ParameterValue(type=77))


@pytest.fixture
def asked(bench):
    """Ask a plant to set parameters; return the response and the plant."""

    def ask(service, name, *parameters):
        plant = bench.add(partial(BlockNode, 'plant'))
        client = bench.peer.create_client(service, f'/plant/{name}')
        bench.until(client.service_is_ready)
        future = client.call_async(service.Request(parameters=parameters))
        bench.until(future.done)
        return future.result(), plant

    return ask


def test_a_value_of_no_type_is_refused_by_itself(asked):
    response, plant = asked(SetParameters, 'set_parameters', UNKNOWN, GOOD, UNKNOWN)
    assert [result.successful for result in response.results] == [False, True, False]
    assert 'cannot be read: ValueError: 77 is not a valid' in response.results[0].reason
    assert (plant.values['k'], plant.stage) == (2.5, 'active')


def test_together_all_of_them_are_refused(asked):
    response, plant = asked(SetParametersAtomically, 'set_parameters_atomically', GOOD, UNKNOWN)
    assert not response.result.successful
    assert (plant.values['k'], plant.stage) == (1.0, 'active')


REFUSED = [
    ('k', 'DOUBLE', -1.0, 'plant.k must be a finite number >= 0, got -1.0'),
    ('k', 'STRING', 'abc', "plant.k must be a finite number >= 0, got 'abc'"),
    ('tua', 'DOUBLE', 1.0, "plant has no parameter 'tua'; did you mean 'tau'?"),
]


@pytest.mark.parametrize(('name', 'kind', 'value', 'words'), REFUSED)
@pytest.mark.parametrize(
    ('service', 'path'),
    [(SetParameters, 'set_parameters'), (SetParametersAtomically, 'set_parameters_atomically')],
)
def test_what_is_refused_is_refused_in_our_words(asked, service, path, name, kind, value, words):
    field = {f'{kind.lower()}_value': value, 'type': getattr(ParameterType, f'PARAMETER_{kind}')}
    response, plant = asked(service, path, Parameter(name=name, value=ParameterValue(**field)))
    (result,) = response.results if service is SetParameters else [response.result]
    assert (result.successful, result.reason) == (False, words)
    assert plant.values['k'] == 1.0
