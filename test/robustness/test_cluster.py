# SPDX-License-Identifier: Apache-2.0
"""A sweep on a Dask cluster of processes, one of which dies, against the same sweep here."""

import os
import signal
import sys
from types import SimpleNamespace

import pytest

from eventreg_ros import load
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness import cluster, sweep
from eventreg_ros.robustness.cluster import on_cluster
from eventreg_ros.robustness.outcome import Outcomes, nothing
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.store import Stretch
from eventreg_ros.robustness.sweep import run_sweep

PARAMETERS = [
    'controller.k:=-0.1..2/60',
    'links.loss:={0,0.1}',
    'links.seed:={1,2}',
    '/**.rate:=50',
]


def plan():
    return Plan.of(load('exact'), PARAMETERS, duration=200.0, settle=60.0)


def test_a_cluster_that_loses_a_worker_gives_the_same_table(tmp_path, monkeypatch):
    distributed = pytest.importorskip('distributed')
    monkeypatch.setattr(sweep, 'FIRST', 5)
    monkeypatch.setattr(sweep, 'MOST', 5)
    here = run_sweep(plan(), tmp_path / 'here.csv')
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as workers:
        with distributed.Client(workers) as client:
            pids = list(client.run(os.getpid).values())
        done = []

        def progress(count, total):
            done.append(count)
            if len(done) == 3:  # two pieces are done
                os.kill(pids[0], signal.SIGKILL)

        there = run_sweep(
            plan(), tmp_path / 'there.csv', on_cluster(workers.scheduler_address), progress
        )
    assert len(set(pids)) == 2
    assert len(done) > 40
    assert there.sets == here.sets == 240
    tables = [(tmp_path / name / 'sweep.csv').read_bytes() for name in ('here.csv', 'there.csv')]
    assert tables[0] == tables[1]


def test_without_a_scheduler_there_is_one_line(tmp_path, monkeypatch):
    pytest.importorskip('distributed')
    monkeypatch.setattr(cluster, 'PATIENCE', 0.1)
    with pytest.raises(EventregError, match=r'no Dask scheduler answers at nowhere:1'):
        run_sweep(plan(), tmp_path / 'a.csv', on_cluster('nowhere:1'))


def test_without_distributed_the_error_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(EventregError, match=r"pip install '\.\[cluster\]'"):
        run_sweep(plan(), tmp_path / 'a.csv', on_cluster(None))


def test_a_scheduler_without_workers_is_refused(tmp_path, monkeypatch):
    distributed = pytest.importorskip('distributed')
    monkeypatch.setattr(cluster, 'PATIENCE', 2.0)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as nobody,
        pytest.raises(EventregError, match='has no workers; start some: dask worker '),
    ):
        run_sweep(plan(), tmp_path / 'a.csv', on_cluster(nobody.scheduler_address))


def test_what_a_cluster_fails_of_is_one_line():
    class Lost:
        def result(self):
            raise ModuleNotFoundError("No module named 'eventreg_ros'")

    with pytest.raises(EventregError, match="failed: ModuleNotFoundError: No module named 'even"):
        cluster._result(Lost())


class Queue(list):
    """Futures that are done in the order in which they were added."""

    add = list.append

    def __iter__(self):
        while self:
            yield self.pop(0)


def test_pieces_grow_with_the_pace_and_are_small_in_the_end(monkeypatch):
    """The first piece of a worker, which compiles, says nothing; at most so many sets are lost."""
    monkeypatch.setitem(sys.modules, 'distributed', SimpleNamespace(as_completed=Queue))
    monkeypatch.setattr(cluster, 'first_piece', lambda sets: 10)
    sizes = []

    def submit(function, plan, stretch, pure):
        count = stretch[1] - stretch[0]
        pace = 1e9 if sizes else None
        sizes.append(count)
        done = Stretch(*stretch), Outcomes(nothing(count), {}), pace
        return SimpleNamespace(result=lambda: done)

    client = SimpleNamespace(nthreads=lambda: {'a': 1, 'b': 1}, submit=submit)
    done = list(cluster._all(client, plan(), [Stretch(0, 3000), Stretch(5000, 8000)]))
    covered = [n for each in done for n in range(*each.stretch)]
    assert sorted(covered) == [*range(3000), *range(5000, 8000)]
    assert sizes[:9] == [10] * 6 + [10, 40, 160]
    assert max(sizes) < 6000 / 6
    assert sizes[-1] <= 10


def test_the_first_piece_of_a_worker_has_no_pace():
    cluster._sets.cache_clear()
    paces = [cluster.run_piece(plan(), (at, at + 1)).pace for at in range(3)]
    assert paces[0] is None
    assert all(pace > 0.0 for pace in paces[1:])
