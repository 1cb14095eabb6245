# SPDX-License-Identifier: Apache-2.0
"""How fast a sweep is: many sets of `exact` over (k, tau) of the controller, beside a C kernel.

Run ``PYTHONPATH=. python bench/sweep.py`` from the top of the repository (a minute; ``--sets
1000000`` for the figures of docs/sweeps.md). T = 400, h = 0.05, linear hold, a verdict and the
residual for each set. Needs numba and a C compiler for their rows. ``--same 1000`` compares so many
random sets of five scenarios with simulate --sampled, bit by bit.
"""

from __future__ import annotations

import argparse
import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

from eventreg_ros import load, simulate
from eventreg_ros.errors import EventregError
from eventreg_ros.robustness.outcome import VERDICTS
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.robustness.sets import Sets
from eventreg_ros.robustness.sweep import cores, run_sweep
from eventreg_ros.simulation.model_time import model_times

T, H, SETTLE = 400.0, 0.05, 100.0
STEPS = round(T / H)
LATE = model_times(STEPS, 10.0, 200.0)[round(SETTLE / H) :]
RANGES = ('controller.k:=0.5..4', 'controller.tau:=0.04..0.2')
PIECE = 4096
"""Sets that the C kernel is given at a time."""


class Row(NamedTuple):
    """One line of the table: how many sets in how many seconds, on how many processors."""

    what: str
    sets: int
    seconds: float
    threads: int
    goal: str = ''

    def __str__(self) -> str:
        pace = self.sets / self.seconds
        steps = pace * STEPS / self.threads
        return (
            f'| {self.what} | {self.sets} | {self.seconds:.2f} | {1e6 / pace:.0f} | '
            f'{steps:.2g} | {self.goal} |'
        )


def timed(what: str, sets: int, threads: int, work: Callable[[], object], goal: str = '') -> Row:
    """Return the row of what ``work`` does, once."""
    start = time.perf_counter()
    work()
    return Row(what, sets, time.perf_counter() - start, threads, goal)


def plan(sets: int) -> Plan:
    """Return the random sets that all rows run."""
    return Plan.of(load('exact'), RANGES, sets=sets)


def c_library(scratch: str, lanes: int = 32) -> ctypes.CDLL | None:
    """Return the C kernel with so many sets side by side, None without a compiler."""
    compiler = shutil.which('cc')
    if compiler is None:
        return None
    library, source = Path(scratch) / f'lanes_{lanes}.so', Path(__file__).with_name('lanes.c')
    options = ['-O3', '-march=native', '-ffp-contract=off', '-fPIC', '-shared', f'-DLANES={lanes}']
    subprocess.run([compiler, *options, '-o', library, source, '-lm'], check=True)
    return ctypes.CDLL(str(library))


class Found(NamedTuple):
    """What the C kernel finds, shape (sets,) each."""

    verdict: np.ndarray
    largest: np.ndarray
    rms: np.ndarray


def c_sweep(library: ctypes.CDLL, sets: int, threads: int) -> Found:
    """Run all sets by the C kernel on so many threads; ``sets`` is a multiple of 32."""
    k, tau = (np.ascontiguousarray(column) for column in plan(sets).design.columns(0, sets))
    verdict, largest, rms = np.empty(sets, np.int32), np.empty(sets), np.empty(sets)

    length = np.diff(LATE)

    def piece(first: int) -> None:
        count = min(PIECE, sets - first)
        at = [ctypes.c_void_p(a[first:].ctypes.data) for a in (k, tau, verdict, largest, rms)]
        library.lanes(
            ctypes.c_size_t(count), *at[:2], ctypes.c_size_t(STEPS), ctypes.c_double(H),
            ctypes.c_size_t(STEPS + 1 - len(LATE)), ctypes.c_void_p(length.ctypes.data),
            ctypes.c_double(length.sum()), *at[2:],
        )  # fmt: skip

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(piece, range(0, sets, PIECE)))
    return Found(verdict, largest, rms)


def alternated(sets: int, library: ctypes.CDLL, rounds: int = 5) -> float:
    """Return the median of our pace over the C kernel's, one thread, turn by turn."""
    ours, columns = Sets(plan(sets)), plan(sets).design.columns(0, sets)
    ratios = []
    for _ in range(rounds):
        times = []
        for work in (lambda: c_sweep(library, sets, 1), lambda: ours.run(columns)):
            start = time.process_time()
            work()
            times.append(time.process_time() - start)
        ratios.append(times[0] / times[1])
    return float(np.median(ratios))


GROWTH = {
    'uncontrolled': 'exosystem.tau:=0.05..0.1',
    'exact': 'controller.k:=0.5..4',
    'open': 'controller.k:=0.5..4',
    'two_generators': 'controller.k:=0.5..4',
}
"""Scenarios of two blocks to five, and what is varied of them."""


def growth(sets: int) -> None:
    """Print what a set costs by the number of blocks, one thread, in processor time."""
    for name, varied in GROWTH.items():
        asked = Plan.of(load(name), [varied], sets=sets, duration=T, settle=SETTLE)
        ours, columns = Sets(asked), asked.design.columns(0, sets)
        ours.run(columns)  # compiles
        start = time.process_time()
        ours.run(columns)
        used = time.process_time() - start
        print(Row(f'{name}, {len(load(name).blocks)} blocks', sets, used, 1), flush=True)


def one_by_one(sets: int) -> None:
    """Run sets as `eventreg simulate --sampled` does it, compiled."""
    from eventreg_ros.simulation.sampled import simulate_sampled

    ours = Sets(plan(sets))
    for values in zip(*plan(sets).design.columns(0, sets), strict=True):
        simulate_sampled(ours.scenario(values).loop, T, compiled=True)


def scipy_sets(sets: int) -> None:
    """Integrate sets with scipy's RK45 at rtol 1e-6, equations by hand, as simulate.py does it."""
    import simulate as other
    from scipy.integrate import solve_ivp

    for _ in range(sets):
        solve_ivp(other.equations, (0.0, T), other.X0, 'RK45', rtol=1e-6, atol=1e-9)


VARIED = {
    'exact': ['controller.k:=0.3..4', 'controller.tau:=0.04..0.2', 'links.delay:=0..0.5'],
    'mismatch': ['controller.k:=0.3..4', 'controller.adapt:=0.01..0.1', 'plant.x0[0]:=-1..1'],
    'open': ['controller.k:=0.3..4', 'links.loss:=0..0.4', 'links.seed:={0,1,2}'],
    'linear': ['controller.gain[0]:=-1..3', 'controller.k_y:=-1..3', 'links.jitter:=0..1'],
    'single_neuron': ['controller.k:=0.3..4', 'noise.y:=0..0.3', 'plant.k:=1~20%'],
}
ALONE = {
    'late': ['controller.k:=0.5..2', 'links.delay:=0..2', 'noise.y:=0..0.1'],
    'mismatch': ['controller.k:=0.3..4', 'spike_monitor.refractory:={0,8}', 'noise.y:=0..0.3'],
    'exact': ['controller.k:=0.3..4', 'spike_monitor.min_width:={0,2}', 'noise.y:=0..0.3'],
    'morris_lecar': ['links.delay:=0..0.3', 'noise.y:=0..0.1'],
}
"""Scenarios and what is varied of them; those that go one by one, or by another model."""


def same_bits(sets: int, of: Mapping[str, list[str]]) -> int:
    """Return how many random sets differ from simulate --sampled, so many in all."""
    return sum(_differ(name, ranges, max(sets // len(of), 1)) for name, ranges in of.items())


def _differ(name: str, ranges: list[str], sets: int) -> int:
    ours, differ = Sets(Plan.of(load(name), ranges, sets=sets, duration=T)), 0
    columns = ours.plan.design.columns(0, sets)
    found = ours.run(columns)
    for i, values in enumerate(zip(*columns, strict=True)):
        links, noise = ours.imperfections(values)
        try:
            report = simulate(
                ours.scenario(values), T, sampled=True, delay=links.delay, loss=links.loss,
                jitter=links.jitter, seed=links.seed, noise=max(noise.sds, default=0.0),
            ).report  # fmt: skip
        except EventregError as error:
            differ += found.reasons.get(i) != str(error)
            continue
        row, rejection = found.rows[i], report.rejection
        differ += (
            VERDICTS[row['verdict']], row['spurious'], row['missed'], row['preserved'],
            row['disturbance_events'], row['residual_max_abs'], row['residual_rms'],
        ) != (
            report.verdict, rejection.spurious, rejection.missed, rejection.preserved,
            rejection.disturbance_events, *report.residual,
        )  # fmt: skip
    return differ


def main() -> None:
    """Measure everything in one run and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--sets', type=int, default=50000)
    parser.add_argument('--same', type=int, metavar='N')
    args = parser.parse_args()
    if args.same:
        print(f'{same_bits(args.same, VARIED)} of {args.same} sets differ from simulate --sampled')
        few = args.same // 10
        print(f'{same_bits(few, ALONE)} of {few} further sets, run one by one or of other models')
        return
    sets, threads = args.sets // 32 * 32, cores()
    run_sweep(plan(64))  # compiles
    print('| what | sets | seconds | us a set | loop steps a second and core | goal |')
    print('|---|---:|---:|---:|---:|---|')
    for count in (sets // 100, sets // 10, sets):
        goal = '60 s for 1,000,000 on 2 cores' if count == sets else ''
        work = lambda n=count: run_sweep(plan(n))  # noqa: E731
        print(timed('eventreg sweep', count, threads, work, goal), flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        library = c_library(scratch)
        if library is not None:
            work = lambda: c_sweep(library, sets, threads)  # noqa: E731
            print(timed('C in lanes, for this loop alone', sets, threads, work, 'the limit'))
            c, ours = (
                c_sweep(library, 1024, 1),
                Sets(plan(1024)).run(plan(1024).design.columns(0, 1024)),
            )
            same = np.array_equal(c.verdict, ours.rows['verdict'])
            same &= np.array_equal(c.largest, ours.rows['residual_max_abs'])
            same &= np.array_equal(c.rms, ours.rows['residual_rms'])
            alone, few = c_library(scratch, 1), sets // 50
            print(timed('C, one by one', few, 1, lambda: c_sweep(alone, few, 1)), flush=True)
            ratio = alternated(2048, library)
            print(f'| pace over the C kernel, one core | | | | {ratio:.2f} | >= 0.9 |')
            print(f'| the same verdicts and residuals as C, to the bit | 1024 | | | {same} | |')
    growth(2048)
    few = max(sets // 100, 100)
    one_by_one(1)  # compiles
    print(timed('one by one, compiled, without a verdict', few, 1, lambda: one_by_one(few)))
    print(timed('scipy RK45, rtol 1e-6, without a verdict', 2, 1, lambda: scipy_sets(2)))


if __name__ == '__main__':
    main()
