# SPDX-License-Identifier: Apache-2.0
"""The closed loop, step by step as the nodes take it, while a sensor says anything at all of y."""

import math

import numpy as np
import pytest

from eventreg_ros import load
from eventreg_ros.analysis.events import EventDetector
from eventreg_ros.runtime.stamped_input import StampedInput
from eventreg_ros.runtime.tick_grid import SECOND
from eventreg_ros.simulation.block import Block

BAD = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1000.0, -101.0, 60.0, -7.5, 8.0)
PERIOD = 37.547
"""Of the generator, in model time (truth/trajectories.json: 71.7138 - 34.1671)."""


class Loop:
    """Exact parameters, the default rate; ``spoil(t, y)`` is what the controller is given."""

    def __init__(self, spoil):
        scenario = load('exact')
        self.blocks = {spec.output: Block(spec) for spec in scenario.blocks.values()}
        self.limit = scenario.nodes['controller']['input_limit']
        self.inputs = {
            (output, name): StampedInput()
            for output, block in self.blocks.items()
            for name, _ in block.spec.inputs
        }
        for samples in self.inputs.values():
            samples.limit = self.limit
        self.spoil = spoil

    def run(self, until):
        """Return t, u and y, all of shape (n,)."""
        (h,) = {block.spec.h for block in self.blocks.values()}
        period, rows = SECOND / 200.0, []
        for n in range(round(until / h)):
            start, value = round(n * period), {s: b.y for s, b in self.blocks.items()}
            rows.append((n * h, value['u'], value['y']))
            for (output, name), samples in self.inputs.items():
                seen = value.get(name)
                if (output, name) == ('u', 'y'):
                    seen = self.spoil(n * h, seen)
                if seen is not None:
                    samples.push(start, seen)
            for output, block in self.blocks.items():
                lines = [
                    self.inputs[output, name].over(start, period, 0.5 * SECOND, block.spec.horizon)
                    or (0.0, 0.0)
                    for name, _ in block.spec.inputs
                ]
                block.advance([b for b, _ in lines], [s for _, s in lines])
        return np.array(rows).T


def patterns(seed):
    """Return (begin, end, what) of some faults, and ``spoil``: what replaces y at a time, if so."""
    rng = np.random.default_rng(seed)
    begins = [110.0, 180.0, 260.0]
    faults = [(b, b + rng.choice([0.1, 1.0, 8.0, 30.0]), rng.choice(['all', 'some', 'mixed']))
              for b in begins + rng.uniform(0.0, 15.0, 3)]  # fmt: skip
    one = float(rng.choice(BAD))

    def spoil(t, y):
        for begin, end, what in faults:
            if begin <= t < end and (what != 'some' or rng.random() < 0.5):
                value = float(rng.choice(BAD)) if what == 'mixed' else one
                # Two in a row within the limit are a jump, which is believed: not what is tried.
                return value if abs(value) > 100.0 or not abs(value) < math.inf else math.nan
        return y

    return faults, spoil


@pytest.mark.parametrize('seed', range(8))
def test_u_stays_bounded_and_y_is_regulated_again_within_one_period(seed):
    faults, spoil = patterns(seed)
    t, u, y = Loop(spoil).run(340.0)
    assert np.isfinite(u).all()
    assert np.abs(u).max() < 2.5  # alone, the oscillator reaches 2.2
    detector = EventDetector(1.0, 0.0)
    events = [at for at in map(detector.push, t.tolist(), y.tolist()) if at is not None]
    late = [at for at in events if at > 100.0]
    near = [at for at in late if not any(b <= at <= e + PERIOD for b, e, _ in faults)]
    assert near == []


@pytest.mark.parametrize('bad', [60.0, -7.5, 8.0, 1000.0, math.nan])
def test_lone_outliers_at_any_instant_change_u_by_no_more_than_a_lost_sample(bad):
    rng = np.random.default_rng(3)
    hit = set((2 * rng.choice(np.arange(500, 1900), 60, replace=False)).tolist())

    def instead(value):
        return lambda t, y: value if round(t / 0.05) in hit else y

    _, u, _ = Loop(instead(bad)).run(200.0)
    _, without, _ = Loop(instead(None)).run(200.0)
    assert np.abs(u - without).max() < 1e-12


@pytest.mark.parametrize('bad', [60.0, -60.0, 99.9, -99.9])
def test_what_stays_within_input_limit_for_any_time_leaves_u_bounded(bad):
    """It is believed: at rest x - x^3/3 + 99.9 = 0 at x = 6.8, which the first step overshoots."""
    _, u, _ = Loop(lambda t, y: bad if 50.0 < t < 110.0 else y).run(200.0)
    assert np.abs(u).max() < 20.0
    assert np.abs(u[-1000:]).max() < 2.5
