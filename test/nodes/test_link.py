# SPDX-License-Identifier: Apache-2.0
"""The link node: what it relays, when, and what it says of it."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from std_msgs.msg import Float64

from eventreg_ros.errors import ParameterError
from eventreg_ros.nodes.link import LinkNode, impairment
from eventreg_ros.runtime.relay import Relay

MS = 1_000_000


class Line:
    """A link between the bench's publisher of u and its subscription of u_late."""

    def __init__(self, bench, *parameters):
        self.bench = bench
        self.node = bench.add(LinkNode, 'input:=u', 'output:=u_late', *parameters)
        self.entered = bench.heard_with_stamps(Float64, 'u')
        self.left = bench.heard_with_stamps(Float64, 'u_late')
        self.publisher = bench.peer.create_publisher(Float64, 'u', 100)
        bench.until(lambda: self.publisher.get_subscription_count() == 2)
        bench.until(lambda: self.node.publisher.get_subscription_count() == 1)
        bench.until(lambda: self.node.sources['u'].get_publisher_count() == 1)

    def send(self, values):
        """Send ``values`` a few at a time, so that no queue overflows, and wait until all left."""
        values = [float(value) for value in values]
        for start in range(0, len(values), 50):
            batch = values[start : start + 50]
            wanted = self.node.wire.received + len(batch)
            for value in batch:
                self.publisher.publish(Float64(data=value))
            self.bench.until(lambda n=wanted: self.node.wire.received == n)
        wire = self.node.wire
        self.bench.until(lambda: wire.in_flight == 0 and len(self.left) >= wire.sent)
        return [value for _, value in self.left]


@pytest.fixture
def line(bench):
    return lambda *parameters: Line(bench, *parameters)


def test_it_relays_every_value_to_the_bit_and_in_order(line):
    values = [0.1, -2.5e-17, 1e300, 5e-324, -0.0, math.inf]
    found = line().send(values)
    assert found == values
    assert math.copysign(1.0, found[4]) == -1.0


def test_a_sample_leaves_no_earlier_than_its_delay_and_with_a_new_stamp(line):
    relay = line('delay:=0.05')
    relay.send(range(20))
    entered = {value: stamp for stamp, value in relay.entered}
    assert len(relay.left) == 20
    for stamp, value in relay.left:
        assert stamp - entered[value] >= 50 * MS


def test_the_timer_is_set_anew_when_a_later_sample_is_due_earlier(line):
    relay = line('delay:=30.0', 'order:=any')
    relay.publisher.publish(Float64(data=1.0))
    relay.bench.until(lambda: relay.node.wire.in_flight == 1)
    relay.node.set_parameters([Parameter('delay', value=0.02)])
    relay.publisher.publish(Float64(data=2.0))
    relay.bench.until(lambda: relay.left)
    assert [value for _, value in relay.left] == [2.0]
    assert relay.node.wire.in_flight == 1


def test_losses_and_duplicates_are_those_of_the_wire_with_the_same_seed(line):
    relay = line('loss:=0.3', 'duplicate:=0.2', 'seed:=7')
    found = relay.send(range(400))
    wire = Relay(impairment(relay.node.values), '7 /u')
    for n in range(400):
        wire.push(n, float(n))
    expected = [departure.item for departure in wire.pop(400)]
    assert found == expected
    assert relay.node.wire.dropped == wire.dropped > 0
    assert relay.node.wire.duplicated == wire.duplicated > 0


def test_links_with_the_same_seed_on_other_signals_drop_other_samples(bench):
    nodes = {
        s: bench.add(LinkNode, f'input:={s}', f'output:={s}_late', 'loss:=0.5') for s in ('u', 'w')
    }
    sent = {s: bench.peer.create_publisher(Float64, s, 100) for s in nodes}
    left = {s: bench.heard(Float64, f'{s}_late') for s in nodes}
    bench.until(lambda: all(p.get_subscription_count() == 1 for p in sent.values()))
    bench.until(lambda: all(n.publisher.get_subscription_count() == 1 for n in nodes.values()))
    for n in range(60):
        for publisher in sent.values():
            publisher.publish(Float64(data=float(n)))
    bench.until(lambda: all(node.wire.received == 60 for node in nodes.values()))
    bench.until(lambda: all(len(left[s]) == nodes[s].wire.sent for s in nodes))
    assert [m.data for m in left['u']] != [m.data for m in left['w']]


def test_impairments_change_while_it_runs_and_a_bad_one_changes_nothing(line):
    relay = line()
    relay.send(range(10))
    relay.node.set_parameters([Parameter('loss', value=1)])  # a whole number is a double
    relay.send(range(10, 20))
    assert (relay.node.wire.sent, relay.node.wire.dropped) == (10, 10)
    for name, value, word in [
        ('loss', 1.5, 'range'),
        ('delay', -0.1, 'range'),
        ('jitter', math.nan, 'range'),
        ('order', 'none', 'newest, fifo, any'),
        ('input', 'w', 'unconfigured'),
    ]:
        result = relay.node.set_parameters([Parameter(name, value=value)])[0]
        assert not result.successful
        assert word in result.reason
    relay.node.set_parameters([Parameter('loss', value=0.0)])
    assert relay.send(range(20, 30)) == [float(n) for n in (*range(10), *range(20, 30))]


def test_a_new_seed_begins_anew(line):
    relay = line('loss:=0.5', 'seed:=1')
    relay.send(range(40))
    relay.node.set_parameters([Parameter('seed', value=2)])
    relay.node.set_parameters([Parameter('seed', value=1)])
    assert relay.node.wire.received == 0
    first = [value for _, value in relay.left]
    relay.left.clear()
    assert relay.send(range(40)) == first


def test_deactivated_it_is_silent_and_loses_what_is_in_flight(line):
    relay = line('delay:=30.0')
    relay.publisher.publish(Float64(data=1.0))
    relay.bench.until(lambda: relay.node.wire.in_flight == 1)
    relay.node.trigger_deactivate()
    relay.node.set_parameters([Parameter('delay', value=0.0)])
    relay.publisher.publish(Float64(data=2.0))
    relay.bench.until(lambda: len(relay.entered) == 2)
    relay.bench.spin(0.1)
    relay.node.trigger_activate()
    assert relay.send([3.0]) == [3.0]


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        (['input:=u', 'output:=u'], 'different signals'),
        (['input:=no topic'], 'link.input must name relative topics'),
        (['delay:=-1'], 'link.delay must be a finite number >= 0'),
        (['duplicate:=2.0'], 'link.duplicate must be a finite number >= 0 and <= 1'),
        (['seed:=-1'], 'link.seed must be a whole number >= 0'),
    ],
)
def test_bad_parameters_are_refused(bench, parameters, words):
    with pytest.raises(ParameterError, match=words):
        bench.add(LinkNode, *parameters)


def test_remapped_and_in_a_namespace(bench):
    arguments = ['-r', '__ns:=/lab', '-r', 'in:=u', '-r', 'out:=u_delayed', '-r', '__node:=link_u']
    bench.add(LinkNode, arguments=arguments)
    heard = bench.heard(Float64, '/lab/u_delayed')
    publisher = bench.peer.create_publisher(Float64, '/lab/u', 10)
    bench.until(lambda: publisher.get_subscription_count() == 1)
    bench.until(lambda: publisher.publish(Float64(data=1.0)) or heard)
    assert ('link_u', '/lab') in bench.peer.get_node_names_and_namespaces()


def test_the_diagnostics_say_what_it_did(line):
    relay = line('delay:=0.02', 'loss:=0.5', 'duplicate:=0.5')
    said = relay.bench.heard(DiagnosticArray, '/diagnostics')
    relay.send(range(60))
    wire = relay.node.wire

    def reported():
        found = [{v.key: v.value for v in s.values} for a in said for s in a.status]
        return [values for values in found if values.get('sent') == str(wire.sent)]

    relay.bench.until(reported)
    values = reported()[0]
    counts = ('received', 'dropped', 'duplicated', 'overtaken', 'in_flight')
    assert {name: int(values[name]) for name in counts} == {
        'received': 60,
        'dropped': wire.dropped,
        'duplicated': wire.duplicated,
        'overtaken': 0,
        'in_flight': 0,
    }
    assert values['u.publishers'] == values['u_late.subscribers'] == '1'
    delays = [float(values[f'delay_p{p}']) for p in (50, 99) if values[f'delay_p{p}'] != '-']
    errors = [float(values[f'error_p{p}']) for p in (50, 99) if values[f'error_p{p}'] != '-']
    assert all(delay >= 0.02 for delay in delays)
    assert errors == pytest.approx([delay - 0.02 for delay in delays], abs=2e-6)
