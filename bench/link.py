# SPDX-License-Identifier: Apache-2.0
"""How precise the link node is: what it adds to the delay that it was asked for.

A process publishes u, the link relays it, and the process takes both: the difference of the two
source time stamps, less the delay, is what the link added.

Run ``PYTHONPATH=. python bench/link.py`` (a minute); prints the table of docs/links.md.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from eventreg_ros.session.domain import loopback_domain
from eventreg_ros.session.processes import node_command

CASES = ((200.0, 0.0), (200.0, 0.001), (200.0, 0.02), (1000.0, 0.0), (1000.0, 0.02))
"""Samples per second, delay in seconds."""

SECONDS = 10.0


def measure(rate: float, delay: float) -> tuple[np.ndarray, float]:
    """Return the added delays in microseconds and the link's share of a core."""
    import rclpy
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    from eventreg_ros.nodes.ros import make_executor, with_info

    node = rclpy.create_node('sender')
    executor = make_executor()
    executor.add_node(node)
    stamps: dict[str, dict[float, int]] = {'u': {}, 'u_link': {}}

    def hear(topic: str) -> None:
        take = with_info(lambda m, info: stamps[topic].update({m.data: info['source_timestamp']}))
        node.create_subscription(Float64, topic, take, QoSProfile(depth=1000))

    for topic in stamps:
        hear(topic)
    publisher = node.create_publisher(Float64, 'u', 100)
    options = ['-p', 'input:=u', '-p', 'output:=u_link', '-p', f'delay:={delay}']
    link = subprocess.Popen(node_command('link', options))
    try:
        while publisher.get_subscription_count() < 2:
            executor.spin_once(timeout_sec=0.05)
        spin(executor, 1.0)
        before = cpu(link.pid)
        count = iter(range(10**9))
        node.create_timer(1.0 / rate, lambda: publisher.publish(Float64(data=float(next(count)))))
        spin(executor, SECONDS)
        share = (cpu(link.pid) - before) / SECONDS
    finally:
        link.terminate()
        link.wait()
        node.destroy_node()
    entered, left = stamps['u'], stamps['u_link']
    both = [n for n in left if n in entered]
    return np.array([(left[n] - entered[n]) * 1e-3 - delay * 1e6 for n in both]), share


def spin(executor: object, seconds: float) -> None:
    """Let messages come in for a while."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        executor.spin_once(timeout_sec=left)  # type: ignore[attr-defined]


def cpu(pid: int) -> float:
    """Return the seconds of processor time that a process has used."""
    words = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf('SC_CLK_TCK')


def main() -> int:
    """Print the table."""
    import rclpy

    with loopback_domain(os.environ) as environment:
        os.environ.update(environment)
        rclpy.init()
        print('| rate Hz | delay ms | added us p50 | p99 | max | of a core | load |')
        print('|---:|---:|---:|---:|---:|---:|---:|')
        for rate, delay in CASES:
            added, share = measure(rate, delay)
            p50, p99 = np.percentile(added, [50, 99])
            print(
                f'| {rate:g} | {delay * 1e3:g} | {p50:.0f} | {p99:.0f} | {added.max():.0f} '
                f'| {share:.1%} | {os.getloadavg()[0]:.1f} |',
                flush=True,
            )
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
