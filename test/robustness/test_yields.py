# SPDX-License-Identifier: Apache-2.0
"""Yields and searches against what is known of them."""

import math

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets
from eventreg_ros.robustness.sweep import run_sweep
from eventreg_ros.robustness.worst import search
from eventreg_ros.robustness.yields import (
    indices,
    worst_of,
    worst_set,
    yield_of,
    yield_of_sweep,
    yields_at_margins,
)

RATE = '/**.rate:=50'


@pytest.mark.slow
@pytest.mark.parametrize(('k', 'n'), [(0, 10), (3, 10), (95, 100), (1000, 1000)])
def test_the_interval_is_wilsons(k, n):
    z, p = 1.959963984540054, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    found = yield_of(k, n)
    assert found.share == p
    assert found.low == pytest.approx(middle - half, abs=1e-12)
    assert found.high == pytest.approx(middle + half, abs=1e-12)


def test_the_worst_set_has_most_wrong_events_then_the_largest_residual():
    columns = {
        'verdict': np.array([None, 'rejected', 'not rejected', 'not rejected'], dtype=object),
        'spurious': np.array([9, 0, 2, 2]),
        'missed': np.array([9, 0, 1, 1]),
        'residual_max_abs': np.array([np.nan, 5.0, 1.0, 1.5]),
    }
    assert worst_of(columns) == 3
    assert worst_of({name: values[:1] for name, values in columns.items()}) is None


def test_the_worst_set_of_a_sweep_has_its_values():
    sweep = run_sweep(Plan.of(load('exact'), ['controller.k:={2,0.5,1}', RATE]))
    assert worst_set(sweep) == [sweep['controller.k'][int(np.argmax(sweep['residual_max_abs']))]]
    assert worst_set(run_sweep(Plan.of(load('exact'), ['controller.k:={-1,-2}', RATE]))) is None


def test_the_yield_at_a_margin_is_of_sets_that_keep_clear_of_the_threshold():
    ranges = ['controller.k:=-0.2..2', 'spike_monitor.reset:=-1', RATE]
    sweep = run_sweep(Plan.of(load('exact'), ranges, sets=40, sampling='random'))
    assert 0 < sweep.bad < sweep.rejected
    found = yields_at_margins(sweep)
    assert [each.level for each in found] == [0.8, 0.5, 0.0]
    for each in found:
        clear = sum(
            verdict == 'rejected' and peak <= each.level
            for verdict, peak in zip(sweep['verdict'], sweep['peak'], strict=True)
        )
        assert (each.share, each.low, each.high) == yield_of(clear, 40)
    assert found[0].share > found[2].share == 0.0


@pytest.mark.parametrize('budget', [5, 7, 65, 100, 127])
def test_the_search_keeps_to_its_budget(budget):
    plan = Plan.of(load('exact'), ['controller.k:=1..2', RATE], sets=1, duration=20.0, settle=5.0)
    assert budget - 1 <= search(plan, budget).runs <= budget


def test_the_search_finds_an_event_where_few_sets_have_one():
    """With 1/tau_w within 9.25 to 13.25 k 0.7 rejects: only the edge of the range does not."""
    pytest.importorskip('numba')
    ranges = ['exosystem.tau:=0.0704..0.11', 'controller.k:=0.7..3', 'plant.k:=0.9..1', RATE]
    plan = Plan.of(load('exact'), ranges, sets=1, sampling='random')
    chance = run_sweep(Plan.of(load('exact'), ranges, sets=512))
    worst = search(plan, 512)
    assert chance.not_rejected / 512 < 0.02
    assert worst.found
    assert worst.runs == 512
    again = Sets(plan).run([np.array([value]) for value in worst.values]).rows[0]
    assert again['spurious'] == worst.spurious > 0
    assert search(plan, 512) == worst
    assert search(Plan.of(load('exact'), ranges, sets=1, seed=1), 512) != worst


def test_what_does_not_act_explains_nothing():
    pytest.importorskip('numba')
    pytest.importorskip('SALib')
    ranges = ['controller.tau:=0.05..0.1', 'exosystem.k:=1..3', RATE]
    sweep = run_sweep(Plan.of(load('exact'), ranges, sets=64, sampling='saltelli'))
    assert sweep.sets == 64 * 4
    found = {(index.quantity, index.parameter): index for index in indices(sweep)}
    assert (
        yield_of_sweep(sweep).share
        == (sweep['verdict'] == 'rejected').reshape(64, 4)[:, [0, 3]].mean()
    )
    tau, k = (found['residual_rms', name] for name in ('controller.tau', 'exosystem.k'))
    assert tau.first > 0.9
    assert abs(k.total) < 0.01  # k_w changes nothing in antiphase
