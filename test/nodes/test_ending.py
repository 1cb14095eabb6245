# SPDX-License-Identifier: Apache-2.0
"""What a foreign plant sees of a controller that stops, however it is stopped."""

import os
import signal
from functools import partial

import pytest
from std_msgs.msg import Float64

from eventreg_ros.models.roles import ROLES
from eventreg_ros.nodes import ros
from eventreg_ros.nodes.block import BlockNode
from eventreg_ros.nodes.ending import Ending


@pytest.fixture
def u(bench):
    """The actions that a foreign plant was given, as they came; it sends no y at all."""
    return bench.heard(Float64, 'u')


def acts(u):
    """Whether the oscillation has begun: u is not 0 by chance."""
    return len(u) > 20 and u[-1].data != 0.0


@pytest.mark.parametrize('name', ['SIGINT', 'SIGTERM', 'SIGHUP'])
def test_a_controller_whose_process_is_ended_sends_a_last_0(bench, launch, u, name):
    process = launch('controller')
    bench.until(lambda: acts(u))
    process.send_signal(getattr(signal, name))
    process.send_signal(signal.SIGTERM)  # a second one must not break into it
    bench.until(lambda: process.poll() is not None)
    assert (process.returncode, process.stderr.read()) == (0, '')
    bench.until(lambda: u[-1].data == 0.0)
    assert [m.data for m in u].count(0.0) == 1


def test_a_controller_that_is_killed_sends_nothing_more(bench, launch, u):
    """The last action stays what it was: a plant must notice the silence by itself."""
    process = launch('controller')
    bench.until(lambda: acts(u))
    process.kill()
    process.wait()
    n = 0
    while len(u) > n:
        n = len(u)
        bench.spin(0.1)  # what is still on its way
    assert u[-1].data != 0.0


def test_our_own_plant_takes_a_killed_controller_for_0_after_input_timeout(bench, launch):
    plant = bench.add(partial(BlockNode, 'plant'), 'input_timeout:=0.05')
    process = launch('controller')
    i = plant.inputs.signals.index('u')
    bench.until(lambda: plant.inputs.samples[i].received > 20)
    process.kill()
    process.wait()
    bench.until(lambda: 'u' in plant.inputs.quiet)
    taken = []
    step = plant.step
    plant.step = lambda n, lines: taken.append(lines.base[i]) or step(n, lines)
    bench.until(lambda: len(taken) > 5)
    assert set(taken) == {0.0}


@pytest.mark.parametrize('stop', ['trigger_deactivate', 'trigger_shutdown', 'fail'])
def test_a_controller_that_is_deactivated_or_at_fault_sends_a_last_0(bench, u, stop):
    node = bench.add(partial(BlockNode, 'controller'))
    bench.until(lambda: acts(u))
    getattr(node, stop)(*(['for a test'] if stop == 'fail' else []))
    assert node.stage == ('inactive' if stop == 'trigger_deactivate' else 'unconfigured')
    bench.until(lambda: u[-1].data == 0.0)
    assert [m.data for m in u].count(0.0) == 1


@pytest.mark.parametrize('role', [role for role in ROLES if role != 'controller'])
def test_what_others_measure_ends_with_their_last_sample(bench, role):
    """A recorder that is still there would take a last 0 for a sample of the run."""
    x0 = '[1.0, 0.0, -1.0, 0.0]' if role == 'exosystem' else '[0.5, 0.0]'
    node = bench.add(partial(BlockNode, role), f'x0:={x0}')
    heard = bench.heard(Float64, node.values['output'])
    bench.until(lambda: len(heard) > 20)
    last = node.block.y
    assert last != 0.0
    node.close()
    bench.nodes.remove(node)
    bench.spin(0.1)
    assert heard[-1].data == last


@pytest.mark.parametrize(
    ('came', 'woken'),
    [(['SIGUSR1'], 0), (['SIGALRM', 'SIGTERM'], 1), (['SIGINT', 'SIGHUP'], 2)],
)
def test_signals_that_a_block_of_ones_own_handles_do_not_end_its_process(came, woken):
    """Python writes the number of every signal that has a handler to the same pipe."""
    reader, writer = os.pipe()
    os.write(writer, bytes(getattr(signal, name) for name in came))
    os.close(writer)
    ending, calls = Ending.__new__(Ending), []
    ending.asked = False
    ending.call(lambda: calls.append(ending.asked))
    ending._listen(reader)
    os.close(reader)
    assert ending.asked == bool(woken)
    assert calls == [True] * woken


def test_what_a_node_raises_as_it_is_closed_stops_no_other_and_is_no_traceback(capsys):
    """Python would end with 1, which is a verdict, and the others would send no last 0."""
    closed = []

    class Node:
        def __init__(self, kind, error=None):
            self.kind, self.error = kind, error

        def close(self):
            closed.append(self.kind)
            if self.error is not None:
                raise self.error

    nodes = [Node('plant', OSError('the motor is gone')), Node('controller'), Node('recorder')]
    assert ros._close(nodes) == 70
    assert closed == ['recorder', 'plant', 'controller']
    (line,) = capsys.readouterr().err.splitlines()
    assert 'OSError: the motor is gone' in line
    assert ros._close(nodes[1:]) == 0
