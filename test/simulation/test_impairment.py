# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from eventreg_ros.simulation import impairment
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.impairment import received as received_on


def received(links, steps, **law):
    """With steps of length 1, so that delay and jitter are in steps."""
    return received_on(['s'] * links, steps, 1.0, Impairment(**law))


def mailbox(steps, link, *, delay, loss, jitter, seed):
    """The same by hand: at each step take what arrives, in order, and drop what is overtaken."""
    lost = np.random.default_rng((seed, link, 0)).random(steps)
    late = np.random.default_rng((seed, link, 1)).random(steps)
    newest = previous = -1
    rows = []
    for n in range(steps):
        for s in range(n + 1):
            arrival = s + delay + int(jitter * late[s])
            if arrival == n and lost[s] >= loss and s > newest:
                newest, previous = s, newest
        rows.append((newest, previous))
    return np.array(rows).T


@pytest.mark.parametrize('delay', [0, 3])
@pytest.mark.parametrize('loss', [0.0, 0.3, 1.0])
@pytest.mark.parametrize('jitter', [0.0, 0.6, 5.0])
def test_like_a_mailbox(delay, loss, jitter):
    impairments = {'delay': delay, 'loss': loss, 'jitter': jitter, 'seed': 7}
    have = received(2, 120, **impairments)
    for link in (0, 1):
        by_hand = mailbox(120, link, **impairments)
        np.testing.assert_array_equal(have.newest[link], by_hand[0])
        np.testing.assert_array_equal(have.previous[link], by_hand[1])


def test_loss_and_jitter_have_their_size():
    lossy = received(1, 20000, loss=0.25, seed=1).newest[0]
    fresh = np.mean(lossy == np.arange(20000))
    assert fresh == pytest.approx(0.75, abs=4 * np.sqrt(0.25 * 0.75 / 20000))
    late = np.arange(20000) - received(1, 20000, delay=5, jitter=4.0, seed=1).newest[0]
    assert late[10:].min() == 5
    assert late[10:].max() <= 9


def test_random_numbers_that_are_kept_are_those_that_are_not(monkeypatch):
    law = Impairment(delay=1.0, loss=0.2, jitter=3.0, seed=5)
    first = received_on('ab', 300, 1.0, law)
    again = received_on('ab', 300, 1.0, law, with_used=False)
    monkeypatch.setattr(impairment, 'SHORT', 299)
    drawn = received_on('ab', 300, 1.0, law)
    assert [each.tolist() for each in drawn] == [each.tolist() for each in first]
    assert [each.tolist() for each in again[:2]] == [each.tolist() for each in first[:2]]
    assert again.used.size == 0


def test_the_same_draws_whatever_else():
    short, long = received(2, 50, loss=0.3, seed=3), received(2, 80, loss=0.3, seed=3)
    np.testing.assert_array_equal(short.newest, long.newest[:, :50])
    few, many = received(1, 500, loss=0.2, seed=3), received(1, 500, loss=0.4, seed=3)
    assert (many.newest <= few.newest).all()
    assert (received(1, 500, loss=0.2, seed=4).newest != few.newest).any()
