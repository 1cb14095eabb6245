# SPDX-License-Identifier: Apache-2.0
"""How fast lockstep is: the loop `exact`, beside a bare loop of three minimal rclpy nodes.

Run ``PYTHONPATH=. python bench/lockstep.py`` from the top of the repository; needs ROS 2. The bare
loop is the limit: exosystem, plant and controller without lifecycle, parameters, clock, recorder
or checks, each stepping when it has the next sample. Prints the table of docs/time.md.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from realtime import cpu_seconds

from eventreg_ros import scenario as scenarios
from eventreg_ros.session.domain import loopback_domain
from eventreg_ros.session.processes import Processes, node_command

ROLES = ('exosystem', 'plant', 'controller')
GOALS = {'processes': 0.8, 'composed': 0.6}
WARM_UP = 2000
"""Steps of the bare loop before its time is taken."""


# The bare loop ----------------------------------------------------------------------------------


def bare(roles: list[str], steps: int) -> None:
    """Run minimal nodes in one executor until the plant has made ``steps``; it prints the speed."""
    import rclpy
    from rclpy.experimental.events_executor import EventsExecutor
    from rclpy.task import Future

    rclpy.init(args=[])
    executor, done = EventsExecutor(), Future()
    running = list(roles)
    begun = 0.0

    def warm() -> None:
        nonlocal begun
        begun = begun or time.process_time()

    def finished() -> None:
        running.pop()
        if not running:
            print('cpu', (time.process_time() - begun) / (steps - WARM_UP), flush=True)
            done.set_result(None)

    nodes = [bare_node(role, steps, warm, finished) for role in roles]
    for node in nodes:
        executor.add_node(node)
    executor.spin_until_future_complete(done, 600.0)
    time.sleep(0.2)  # the last samples are still on their way to the others
    rclpy.try_shutdown()


def bare_node(role: str, steps: int, warm: Callable[[], None], finished: Callable[[], None]):
    """Return a node that publishes sample n + 1 when it has sample n of each of its inputs.

    The exosystem has none, so y paces it.
    """
    from collections import deque

    import rclpy
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Float64

    from eventreg_ros.simulation.step import make_step

    spec = scenarios.load('exact').blocks[role]
    step, params, h = make_step(spec.model.rhs, spec.model.dimension), spec.params, spec.h
    inputs = [(s, sign) for s, sign in spec.inputs if s in ('w', 'y', 'u')] or [('y', 0.0)]
    queues = [deque() for _ in inputs]
    signs = [sign for _, sign in inputs]
    node = rclpy.create_node(f'bare_{role}')
    qos = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publish = node.create_publisher(Float64, spec.output, qos).publish
    x, n, begun = spec.x0, 0, 0.0

    def go() -> None:
        nonlocal x, n, begun
        while all(queues):
            drive = sum([s * q.popleft() for s, q in zip(signs, queues, strict=True)])
            x = step(x, drive, drive, drive, params, h)
            n += 1
            publish(Float64(data=x[0]))
            if n == WARM_UP:
                begun = time.perf_counter()
                warm()
            if n == steps:
                print(role, (n - WARM_UP) / (time.perf_counter() - begun), flush=True)
                finished()

    def receiver(queue):
        def receive(message: Float64) -> None:
            queue.append(message.data)
            go()

        return receive

    for (signal, _), queue in zip(inputs, queues, strict=True):
        node.create_subscription(Float64, signal, receiver(queue), qos)
    publish(Float64(data=x[0]))
    return node


Speed = tuple[float, float]
"""Steps per second, and seconds of CPU per step, all processes together."""


def bare_speed(composed: bool, seconds: float) -> Speed:
    """Return the speed of the bare loop."""
    steps = WARM_UP + int(seconds * (15000 if composed else 3500))
    with loopback_domain(os.environ) as environment:
        groups = [list(ROLES)] if composed else [[role] for role in ROLES]
        started = [
            subprocess.Popen(
                [sys.executable, __file__, '--bare', *group, '--steps', str(steps)],
                env=environment,
                stdout=subprocess.PIPE,
                text=True,
            )
            for group in groups
        ]
        try:
            said = [process.communicate(timeout=60)[0] for process in started]
        finally:
            for process in started:
                process.kill()
                process.wait()
    words = [line.split() for line in ''.join(said).splitlines()]
    used = sum(float(value) for what, value in words if what == 'cpu')
    return next(float(value) for what, value in words if what == 'plant'), used


# The real loop ----------------------------------------------------------------------------------


def real_speed(composed: bool, seconds: float) -> Speed:
    """Return the speed of the nodes in lockstep, from the clock's diagnostics."""
    with tempfile.TemporaryDirectory() as scratch, loopback_domain(os.environ) as environment:
        nodes, file = prepared(Path(scratch))
        with running(nodes, file, environment, composed) as processes:
            pids = [process.pid for process in processes.running.values()]
            return observed(environment, seconds, lambda: sum(map(cpu_seconds, pids)))


def prepared(scratch: Path) -> tuple[list[str], Path]:
    """Return the names of the nodes and their parameter file; the spike monitor is left out."""
    exact = scenarios.load('exact')
    loop = exact.with_recorder(str(scratch / 'bag'), str(scratch / 'exact.yaml'))
    loop.given.pop('spike_monitor')
    loop.nodes.pop('spike_monitor')
    (scratch / 'exact.yaml').write_text(loop.to_yaml())
    whole = loop.in_lockstep(1e5)
    (scratch / 'parameters.yaml').write_text(whole.to_yaml())
    return list(whole.nodes), scratch / 'parameters.yaml'


@contextmanager
def running(
    nodes: list[str], file: Path, environment: dict[str, str], composed: bool
) -> Iterator[Processes]:
    """Run the nodes, as processes or composed."""
    arguments = ['--params-file', str(file), '--log-level', 'WARN']
    processes = Processes()
    try:
        if composed:
            processes.start('nodes', node_command('composed', arguments, nodes), environment)
        else:
            for node in nodes:
                processes.start(node, node_command(node, arguments), environment)
        yield processes
    finally:
        processes.stop()


def observed(environment: dict[str, str], seconds: float, used: Callable[[], float]) -> Speed:
    """Return the speed that the clock node reports, over about ``seconds``."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.context import Context

    from eventreg_ros.nodes.ros import make_executor

    os.environ.update({k: environment[k] for k in environment if k.startswith(('ROS', 'FAST'))})
    context = Context()
    context.init(args=[], domain_id=int(environment['ROS_DOMAIN_ID']))
    node = rclpy.create_node('bench', context=context)
    executor = make_executor(context)
    executor.add_node(node)
    seen: list[tuple[float, int, float]] = []

    def on_diagnostics(message: DiagnosticArray) -> None:
        for status in message.status:
            values = {v.key: v.value for v in status.values}
            if status.name == '/clock: clock' and int(values.get('step', 0)) > WARM_UP:
                stamp = message.header.stamp
                seen.append((stamp.sec + stamp.nanosec * 1e-9, int(values['step']), used()))

    node.create_subscription(DiagnosticArray, '/diagnostics', on_diagnostics, 10)
    try:
        end = time.monotonic() + 20.0 + 3.0 * seconds
        while not seen or seen[-1][0] - seen[0][0] < seconds - 0.5:
            if time.monotonic() > end:
                raise RuntimeError('the loop did not run')
            executor.spin_once(timeout_sec=0.5)
    finally:
        node.destroy_node()
        context.try_shutdown()
        os.environ.pop('ROS_DOMAIN_ID', None)
    (begun, first, before), (ended, last, after) = seen[0], seen[-1]
    return (last - first) / (ended - begun), (after - before) / (last - first)


# The table --------------------------------------------------------------------------------------


def main() -> None:
    """Measure everything in one run, alternating, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--repeat', type=int, default=3)
    parser.add_argument('--seconds', type=float, default=5.0, help='per measurement')
    parser.add_argument('--bare', nargs='+', choices=ROLES, help=argparse.SUPPRESS)
    parser.add_argument('--steps', type=int, default=20000, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.bare:
        bare(args.bare, args.steps)
        return
    found: dict[tuple[str, str], list[Speed]] = {}
    for _ in range(args.repeat):
        for how in GOALS:
            for what, speed in (('bare', bare_speed), ('real', real_speed)):
                found.setdefault((how, what), []).append(speed(how == 'composed', args.seconds))
    show(found)


def show(found: dict[tuple[str, str], list[Speed]]) -> None:
    """Print the table: medians, in brackets the best; CPU is that of all processes together."""
    print(f'load average {os.getloadavg()[0]:.2f}')
    print('| how | what | steps/s (best) | CPU per step, us (best) | ratio | CPU ratio | goal |')
    print('|---|---|---:|---:|---:|---:|---:|')
    for how, goal in GOALS.items():
        bare, real = (list(zip(*found[how, what], strict=True)) for what in ('bare', 'real'))
        for what, (speeds, used) in (('bare', bare), ('real', real)):
            cells = f'{median(speeds):.0f} ({max(speeds):.0f}) '
            cells += f'| {1e6 * median(used):.0f} ({1e6 * min(used):.0f})'
            if what == 'bare':
                print(f'| {how} | bare | {cells} | 1 | 1 | |')
                continue
            faster = f'{median(speeds) / median(bare[0]):.2f} ({max(speeds) / max(bare[0]):.2f})'
            costlier = f'{median(bare[1]) / median(used):.2f} ({min(bare[1]) / min(used):.2f})'
            print(f'| {how} | real | {cells} | {faster} | {costlier} | {goal} |')


if __name__ == '__main__':
    main()
