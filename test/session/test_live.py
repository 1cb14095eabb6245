# SPDX-License-Identifier: Apache-2.0
"""A run from Python: what it leaves as it was, and where it may be called."""

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from eventreg_ros import run

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
