# SPDX-License-Identifier: Apache-2.0
"""The links of lanes against those of a single run: the same samples at every step."""

import numpy as np
import pytest

from eventreg_ros.simulation import lane_links
from eventreg_ros.simulation.impairment import Impairment, received
from eventreg_ros.simulation.lane_links import LANES, Links

SIGNALS, STEPS, H = ('w', 'y', 'w'), 90, 0.05
LAWS = {
    'delay': {'delay': 0.2},
    'loss': {'loss': 0.7},
    'jitter': {'jitter': 0.4},
    'all': {'delay': 0.13, 'loss': 0.3, 'jitter': 1.7},
    'less than a step': {'jitter': 0.04},
    'nothing': {},
    'all lost': {'loss': 1.0},
    'later than the run': {'delay': 7.0, 'jitter': 3.0},
}


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    monkeypatch.setattr(lane_links, '_compiled', lambda: lane_links.arrive)


def received_in(links, lane, link, n):
    """What a lane has received at step n, by the formulas of the kernel: newest, previous."""
    at = n - links.lags[lane // LANES, link * LANES + lane % LANES]
    table = links.tables[lane // LANES, lane % LANES]
    place = table + link * links.span + min(max(at, 0), links.span - 1)
    newest = at - links.newest[place]
    return (newest, max(newest - links.previous[place], -1)) if newest >= 0 else (-1, -1)


def assert_same(each):
    links = Links.scattered(SIGNALS, STEPS, H, each)
    oldest = 0
    for lane, impairment in enumerate(each):
        newest, previous, _ = received(SIGNALS, STEPS, H, impairment)
        for link in range(len(SIGNALS)):
            found = [received_in(links, lane, link, n) for n in range(STEPS)]
            assert found == list(zip(newest[link], previous[link], strict=True))
            n = np.arange(STEPS)
            needed = np.where(previous[link] >= 0, previous[link], newest[link])
            oldest = max(oldest, (n - needed)[needed >= 0].max(initial=0))
    assert links.reach >= oldest


@pytest.mark.parametrize('law', LAWS.values(), ids=LAWS)
@pytest.mark.parametrize('on', [None, frozenset('y')])
def test_lanes_receive_what_a_run_receives(law, on):
    assert_same([Impairment(**law, seed=seed, on=on) for seed in range(3)])


def test_lanes_of_all_kinds_side_by_side():
    each = [Impairment(**law, seed=seed) for law in LAWS.values() for seed in range(5)]
    assert len(each) > LANES
    assert_same(each)


def test_delays_share_a_table_and_need_none_without_loss_and_jitter():
    delays = [0.05 * i for i in range(20)]
    lossy = Links.scattered(SIGNALS, STEPS, H, [Impairment(delay, loss=0.5) for delay in delays])
    assert len(lossy.newest) == len(SIGNALS) * STEPS
    assert len(Links.scattered(SIGNALS, STEPS, H, list(map(Impairment, delays))).newest) == 3


def test_a_loop_in_which_nobody_listens_has_no_links():
    assert Links.scattered((), STEPS, H, [Impairment(loss=0.5)]).lags.shape == (1, 0)
