# SPDX-License-Identifier: Apache-2.0
"""The sets of bench/sweep.py by Brian2's C++ standalone mode, a neuron of ten states a set.

Run ``python bench/brian_sweep.py SETS`` with Brian2 2.9 or later and a C++ compiler; it prints the
CPU seconds of the run alone, without those of compiling, on one thread. The states are continuous:
it knows no links and no verdict, and counts the events of y after 100.
"""

from __future__ import annotations

import resource
import sys
import tempfile

import numpy as np

EQUATIONS = """
dv1/dt = (v1 - v1*v1*v1/3 - r1 + 2*(-v2 - v1))/second : 1
dr1/dt = (v1 - r1)/12/second : 1
dv2/dt = (v2 - v2*v2*v2/3 - r2 + 2*(-v1 - v2))/second : 1
dr2/dt = (v2 - r2)/12/second : 1
dy/dt = (y - y*y*y/3 - r + v1 - u1 - y)/second : 1
dr/dt = (y - r)/11/second : 1
du1/dt = (u1 - u1*u1*u1/3 - s1 + k*(y - u2 - u1))/second : 1
ds1/dt = tau*(u1 - s1)/second : 1
du2/dt = (u2 - u2*u2*u2/3 - s2 + k*(-u1 - u2))/second : 1
ds2/dt = tau*(u2 - s2)/second : 1
k : 1
tau : 1
"""
DURATION, H, SETTLE = 400.0, 0.05, 100.0


def run(sets: int) -> float:
    """Return the CPU seconds that so many sets take, and print how many of them are rejected."""
    import brian2

    with tempfile.TemporaryDirectory() as scratch:
        brian2.set_device('cpp_standalone', directory=scratch, build_on_run=False)
        brian2.defaultclock.dt = H * brian2.second
        group = brian2.NeuronGroup(
            sets, EQUATIONS, method='rk4', threshold='y >= 1', refractory='y > 0'
        )
        rng = np.random.default_rng(0)
        group.k, group.tau = rng.uniform(0.5, 4.0, sets), rng.uniform(0.04, 0.2, sets)
        group.v1, group.v2, group.u1, group.u2 = 1.0, -1.0, 0.5, -0.5
        brian2.run(SETTLE * brian2.second)
        seen = brian2.SpikeMonitor(group, record=False)
        brian2.run((DURATION - SETTLE) * brian2.second)
        brian2.device.build(directory=scratch, compile=True, run=False)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        brian2.device.run(scratch, with_output=False, run_args=[])
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        rejected = int((np.asarray(seen.count[:]) == 0).sum())
        print(f'{rejected} of {sets} sets have no event of y after {SETTLE:g}', file=sys.stderr)
        return used


if __name__ == '__main__':
    print(f'{run(int(sys.argv[1])):.2f}')
