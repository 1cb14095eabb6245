# SPDX-License-Identifier: Apache-2.0
"""How fast the simulations are: the closed loop `exact`, T = 1000, beside others and a C loop.

Run ``PYTHONPATH=. python bench/simulate.py`` from the top of the repository. Needs scipy; numba and
a C compiler for their rows; ``pip install pathsim`` for its own. Prints the table of docs/speed.md.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from eventreg_ros import scenario
from eventreg_ros.simulation.continuous import simulate
from eventreg_ros.simulation.impairment import Impairment
from eventreg_ros.simulation.sampled import SampledLoop

T, H = 1000.0, 0.01
STEPS = round(T / H)
K_W, TAU_W, K_P, TAU_P = 2.0, 1 / 12, 1.0, 1 / 11


@dataclass
class Row:
    """One line of the table: seconds, and the largest error of y on the grid of the loop."""

    what: str
    seconds: float | None = None
    error: float | None = None
    goal: str = ''
    note: str = ''


def best(run: Callable[[], np.ndarray], repeat: int) -> tuple[float, np.ndarray]:
    """Return the shortest of ``repeat`` times, in seconds, and what ``run`` gave."""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        y = run()
        times.append(time.perf_counter() - start)
    return min(times), y


def equations(t: float, x: np.ndarray) -> list[float]:
    """Return x' of the whole loop, as one would write it down for scipy."""
    w1, w2, w3, w4, p1, p2, c1, c2, c3, c4 = x.tolist()
    return [
        w1 - w1 * w1 * w1 / 3.0 - w2 + K_W * (-w3 - w1),
        TAU_W * (w1 - w2),
        w3 - w3 * w3 * w3 / 3.0 - w4 + K_W * (-w1 - w3),
        TAU_W * (w3 - w4),
        p1 - p1 * p1 * p1 / 3.0 - p2 + K_P * (w1 - c1 - p1),
        TAU_P * (p1 - p2),
        c1 - c1 * c1 * c1 / 3.0 - c2 + K_W * (p1 - c3 - c1),
        TAU_W * (c1 - c2),
        c3 - c3 * c3 * c3 / 3.0 - c4 + K_W * (-c1 - c3),
        TAU_W * (c3 - c4),
    ]


X0 = [1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.5, 0.0, -0.5, 0.0]


def scipy_y(method: str, rtol: float, atol: float) -> np.ndarray:
    """Return y on the grid from scipy's solve_ivp."""
    from scipy.integrate import solve_ivp

    t = np.linspace(0.0, T, STEPS + 1)
    return solve_ivp(equations, (0.0, T), X0, method, t, rtol=rtol, atol=atol).y[4]


def ours(hold: str) -> SampledLoop:
    """Return the scenario `exact` at h = 0.01 with the given hold."""
    return SampledLoop(scenario.load('exact').loop.sampled_at(10.0 / H, hold))


def c_rows(truth: np.ndarray) -> list[Row]:
    """Compile and time loop.c, the limit."""
    compiler = shutil.which('cc')
    if compiler is None:
        return [Row('C loop', note='skipped: no C compiler (cc)')]
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for level in ('-O2', '-O3'):
            library = Path(scratch) / f'loop{level}.so'
            source = Path(__file__).with_name('loop.c')
            subprocess.run([compiler, level, '-fPIC', '-shared', '-o', library, source], check=True)
            loaded = ctypes.CDLL(str(library))
            seconds, y = best(lambda lib=loaded: c_y(lib), 9)
            rows.append(
                Row(f'C loop, cc {level}, zero hold', seconds, error(y, truth), 'the limit')
            )
    return rows


def c_y(library: ctypes.CDLL) -> np.ndarray:
    """Return y of the C loop."""
    w, y, u = (np.empty(STEPS + 1) for _ in range(3))
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (w, y, u)]
    library.loop(ctypes.c_size_t(STEPS), ctypes.c_double(H), *pointers)
    return y


def sampled_rows(truth: np.ndarray) -> list[Row]:
    """Time the sampled simulation, compiled and warm, and plain."""
    cases = [
        ('zero', {}),
        ('linear', {}),
        ('zero', {'delay': 0.1, 'loss': 0.1}),
        ('linear', {'delay': 0.1, 'loss': 0.1, 'jitter': 0.05}),
    ]
    rows = []
    if find_spec('numba') is None:
        rows.append(Row('sampled, compiled', note="skipped: no numba (pip install '.[fast]')"))
    else:
        first, _ = best(lambda: ours('zero').run(H, compiled=True).t, 1)
        rows.append(Row('compiling, once per process', first))
        for hold, impairments in cases:
            seconds, y = best(lambda a=hold, b=impairments: sampled_y(a, True, b), 9)
            what = ', '.join(f'{name} {value:g}' for name, value in impairments.items())
            what = f'sampled, compiled, {hold} hold' + (f', {what}' if what else '')
            rows.append(Row(what, seconds, error(y, truth), '<= 3 x C'))
    for hold in ('zero', 'linear'):
        seconds, y = best(lambda a=hold: sampled_y(a, False, {}), 1)
        rows.append(Row(f'sampled, plain Python, {hold} hold', seconds, error(y, truth)))
    return rows


def sampled_y(hold: str, compiled: bool, impairments: dict[str, float]) -> np.ndarray:
    """Return y of our sampled simulation, the network built anew."""
    return ours(hold).run(T, Impairment(**impairments), compiled=compiled).signals['y']


def continuous_rows(truth: np.ndarray) -> list[Row]:
    """Time the continuous simulation beside scipy on equations written by hand."""
    loop = scenario.load('exact').loop
    seconds, y = best(lambda: simulate(loop, T, H).signals['y'], 2)
    rows = [Row('continuous (DOP853, rtol 1e-10)', seconds, error(y, truth))]
    for method, rtol, atol in (
        ('DOP853', 1e-10, 1e-12),
        ('RK45', 1e-10, 1e-12),
        ('RK45', 1e-6, 1e-9),
    ):
        seconds, y = best(lambda a=(method, rtol, atol): scipy_y(*a), 2)
        rows.append(Row(f'scipy {method}, rtol {rtol:g}, by hand', seconds, error(y, truth)))
    return rows


def pathsim_rows(truth: np.ndarray) -> list[Row]:
    """Time pathsim: three ODE blocks, wired, RK4 with h = 0.01."""
    if find_spec('pathsim') is None:
        return [Row('pathsim RK4', note='skipped: not installed (pip install pathsim)')]
    seconds, y = best(pathsim_y, 1)
    return [Row('pathsim RK4, three ODE blocks', seconds, error(y, truth))]


def pathsim_y() -> np.ndarray:
    """Return y from pathsim, which solves the blocks as one continuous system."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import ODE, Scope
    from pathsim.solvers import RK4

    def oscillator(x: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
        (a, b, c, d), drive = x.tolist(), float(u[0])
        return np.array([
            a - a * a * a / 3.0 - b + K_W * (drive - c - a),
            TAU_W * (a - b),
            c - c * c * c / 3.0 - d + K_W * (-a - c),
            TAU_W * (c - d),
        ])  # fmt: skip

    def neuron(x: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
        (a, b), drive = x.tolist(), float(u[0]) - float(u[1])
        return np.array([a - a * a * a / 3.0 - b + K_P * (drive - a), TAU_P * (a - b)])

    exo, plant = ODE(oscillator, np.array(X0[:4])), ODE(neuron, np.array(X0[4:6]))
    control, scope = ODE(oscillator, np.array(X0[6:])), Scope()
    wires = [
        Connection(exo[0], plant[0]),
        Connection(control[0], plant[1]),
        Connection(plant[0], control[0], scope[0]),
    ]
    loop = Simulation([exo, plant, control, scope], wires, dt=H, Solver=RK4, log=False)
    loop.run(T)
    t, y = scope.read()
    return np.interp(np.linspace(0.0, T, STEPS + 1), t, y[0])


def shell_rows() -> list[Row]:
    """Time the command from the shell, T = 400."""
    rows = []
    top = str(Path(__file__).resolve().parents[1])
    for extra in ([], ['--sampled']):
        command = [sys.executable, '-m', 'eventreg_ros', 'simulate', 'exact', *extra]
        environment = {**os.environ, 'PYTHONPATH': top}

        def run(command: list[str] = command, env: dict[str, str] = environment) -> np.ndarray:
            subprocess.run(command, check=True, env=env, stdout=subprocess.DEVNULL)
            return np.empty(0)

        seconds, _ = best(run, 5)
        rows.append(Row(' '.join(['eventreg simulate exact', *extra]), seconds, goal='< 1 s'))
    return rows


def error(y: np.ndarray, truth: np.ndarray) -> float:
    """Return the largest difference between two signals on the grid."""
    return float(np.max(np.abs(y - truth)))


def show(rows: list[Row]) -> None:
    """Print the table as Markdown; ratios are to the first row that was timed, the C loop."""
    limit = next((row.seconds for row in rows if row.seconds is not None), None)
    print('| what | seconds | times the C loop | goal | largest error of y |')
    print('|---|---:|---:|---|---:|')
    for row in rows:
        if row.seconds is None:
            print(f'| {row.what} | {row.note} | | | |')
            continue
        wrong = '' if row.error is None else f'{row.error:.1e}'
        print(
            f'| {row.what} | {row.seconds:.4f} | {row.seconds / limit:.1f} | {row.goal} | {wrong} |'
        )


def main() -> None:
    """Measure everything in one run and print the table."""
    truth = scipy_y('DOP853', 1e-12, 1e-13)
    rows = c_rows(truth) + sampled_rows(truth) + continuous_rows(truth)
    show(rows + pathsim_rows(truth) + shell_rows())


if __name__ == '__main__':
    main()
