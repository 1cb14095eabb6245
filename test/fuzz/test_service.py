# SPDX-License-Identifier: Apache-2.0
"""What anybody may ask of a running node through its parameter services: it takes it or refuses it.

A refusal is one line and changes nothing; what was taken is what the node answers and computes
with. Its output stays finite, and it lives on.
"""

import math

import pytest

pytest.importorskip('rclpy')

import rclpy
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.context import Context
from rclpy.parameter import Parameter as RosParameter
from rclpy.parameter import parameter_value_to_python
from std_msgs.msg import Float64

from eventreg_ros.errors import LONGEST
from eventreg_ros.nodes.composed import make
from eventreg_ros.nodes.ros import make_executor

pytestmark = pytest.mark.ros

NODES = ('exosystem', 'plant', 'controller', 'stimulus', 'spike_monitor', 'recorder', 'link_u')

NUMBERS = (0.0, -0.0, 0.5, 2.0, -1.0, 1e-9, 5e-324, 1e9, 1e308, math.nan, math.inf, -math.inf)
WHOLE = (0, 1, 2, -1, 2**31, 2**63 - 1, -(2**63))
WORDS = ('', 'y', 'w', 'zero', 'neuron', 'oscillator', '../x', '/etc/hostname', 'a b', 'ü', '\n',
         'x' * 100_000)  # fmt: skip
FIELDS = {
    ParameterType.PARAMETER_NOT_SET: ('', (None,)),
    ParameterType.PARAMETER_BOOL: ('bool_value', (True, False)),
    ParameterType.PARAMETER_INTEGER: ('integer_value', WHOLE),
    ParameterType.PARAMETER_DOUBLE: ('double_value', NUMBERS),
    ParameterType.PARAMETER_STRING: ('string_value', WORDS),
    ParameterType.PARAMETER_BYTE_ARRAY: ('byte_array_value', ([], [b'\x00'])),
    ParameterType.PARAMETER_BOOL_ARRAY: ('bool_array_value', ([], [True])),
    ParameterType.PARAMETER_INTEGER_ARRAY: ('integer_array_value', ([], [1, 2], [0] * 20_000)),
    ParameterType.PARAMETER_DOUBLE_ARRAY: (
        'double_array_value', ([], [0.5, 0.0], [math.nan, 0.0], [0.1] * 4, [0.0] * 100_000),
    ),
    ParameterType.PARAMETER_STRING_ARRAY: (
        'string_array_value', ([], [''], ['w'], ['w', 'w'], ['y', 'u'], ['a b'], ['s'] * 20_000),
    ),
    77: ('', (None,)),
}  # fmt: skip
"""The field of a type, and what may stand in it."""


def a_value(draw, present):
    """A value of the parameter's own type, or of any."""
    kind = present.type if draw.random() < 0.6 else draw.choice(list(FIELDS))
    field, values = FIELDS[kind]
    value = ParameterValue(type=kind)
    if field:
        setattr(value, field, draw.choice(values))
    return value


class Peer:
    """Another node, which asks."""

    def __init__(self, context, asked):
        self.executor = make_executor(context)
        self.node = rclpy.create_node('peer', context=context)
        for node in (asked, self.node):
            self.executor.add_node(node)
        self.heard = []
        self._clients = {}

    def call(self, service, request, name):
        """Return the response to a request of the node called ``name``."""
        if (service, name) not in self._clients:
            words = {SetParameters: 'set_parameters', GetParameters: 'get_parameters',
                     SetParametersAtomically: 'set_parameters_atomically'}  # fmt: skip
            client = self.node.create_client(service, f'/{name}/{words[service]}')
            assert client.wait_for_service(20.0)
            self._clients[service, name] = client
        future = self._clients[service, name].call_async(request)
        for _ in range(2000):
            self.executor.spin_once(timeout_sec=0.05)
            if future.done():
                return future.result()
        raise AssertionError(f'{name} does not answer')

    def listen(self, topic):
        self.node.create_subscription(Float64, topic, lambda m: self.heard.append(m.data), 100)

    def get(self, name, parameters):
        """Return what the node answers, as messages."""
        return self.call(GetParameters, GetParameters.Request(names=parameters), name).values


@pytest.fixture(params=NODES)
def running(request, domain, tmp_path, monkeypatch):
    """A running node and its peer."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    name, context = request.param, Context()
    given = ['-p', 'input:=u', '-p', 'output:=u_link'] if name == 'link_u' else []
    given += ['-p', "path:='bag'", '-p', 'signals:=[w]'] if name == 'recorder' else []
    words = ['--ros-args', '--log-level', 'FATAL', *given]
    context.init(words, domain_id=domain)
    node = make(name, context=context)
    peer = Peer(context, node)
    peer.listen(f'/{node.values.get("output", "nothing")}')
    node.bring_up()
    yield node, peer
    node.close()
    peer.node.destroy_node()
    context.try_shutdown()


def test_requests(running, fuzz, limited):
    node, peer = running
    name = node.get_name()
    defaults = dict(node.values)
    known = [*node.table, 'use_sim_time']

    def case(draw):
        names = draw.sample(known, draw.choice([1, 1, 1, 2, 3]))
        if draw.random() < 0.1:
            names.append(draw.choice(['nobody', '', 'x' * 10_000, 'k.k', 'qos_overrides./y.depth']))
        values = peer.get(name, known)
        before = dict(zip(known, values, strict=True))
        empty = ParameterValue()
        asked = [
            Parameter(name=n, value=a_value(draw, before.get(n, empty)))
            for n in names if n != 'use_sim_time'
        ]  # fmt: skip
        with limited():
            results = sent(draw, peer, name, asked)
        wrong = [r.reason for r in results if not r.successful and not _fine(r.reason)]
        assert not wrong, (asked, wrong)
        if node.stage != 'active':
            restart(node, defaults)
            return 'diverged'
        after = dict(zip(known, peer.get(name, known), strict=True))
        if not any(result.successful for result in results):
            changed = [n for n in known if repr(before[n]) != repr(after[n])]
            assert not changed, (changed, before[changed[0]], after[changed[0]], asked)
        for parameter in node.table:
            answer = parameter_value_to_python(after[parameter])
            ours = node.values[parameter]
            assert repr(_plain(answer)) == repr(ours), (parameter, answer, ours)
        assert all(map(math.isfinite, peer.heard))
        peer.heard.clear()
        return all(result.successful for result in results)

    fuzz(8, case)


def restart(node, defaults):
    """Start a node anew that stopped, which only one that diverged may do."""
    assert 'stopped being finite' in node.fault, (node.stage, node.fault)
    rows = [row for row in node.table.values() if row.type.startswith('double')]
    node.set_parameters([RosParameter(r.name, value=defaults[r.name]) for r in rows])
    node.bring_up()
    assert node.stage == 'active', node.fault


def sent(draw, peer, name, asked):
    if draw.random() < 0.7:
        return peer.call(SetParameters, SetParameters.Request(parameters=asked), name).results
    request = SetParametersAtomically.Request(parameters=asked)
    return [peer.call(SetParametersAtomically, request, name).result]


def _fine(reason):
    return 0 < len(reason) <= LONGEST and reason.isprintable()


def _plain(value):
    return list(value) if hasattr(value, 'tolist') else value
