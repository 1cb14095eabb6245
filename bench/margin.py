# SPDX-License-Identifier: Apache-2.0
"""Processor time of `eventreg margin exact` in a process of its own, and of other quick commands.

Run ``PYTHONPATH=. python bench/margin.py`` from the top of the repository (half a minute). Each
command runs first with an empty cache, where its code is compiled and kept, and then again some
times: the median, and how many functions were compiled then. Needs numba.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

COMMANDS = {
    'margin exact': '2 s',
    'margin exact --plot margin.svg': '',
    'sweep exact -p controller.k:=0.5..4/60 --out {}': '',
    'simulate exact': '',
    'simulate exact --sampled --duration 20000': '',
}
"""What is run, and in how much processor time it shall be done."""

IMPORTS = 'import numba, eventreg_ros.cli.margin, eventreg_ros.robustness.margins'


def used(arguments: list[str], scratch: Path) -> tuple[float, int]:
    """Return the processor time (s) of Python with these arguments, and how much it compiled."""
    own = {
        'NUMBA_CACHE_DIR': str(scratch),
        'NUMBA_DEBUG_CACHE': '1',
        'PYTHONPYCACHEPREFIX': str(scratch / 'bytes'),
        'OPENBLAS_NUM_THREADS': '1',  # as the commands have it
        'PYTHONDONTWRITEBYTECODE': '',  # what is installed has its byte code beside it
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *arguments], env={**os.environ, **own}, cwd=scratch, check=False,
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, done.stdout.count('[cache] data saved to')


def row(command: str, goal: str, scratch: Path, times: int) -> str:
    """Return the line of one command: the first time, then the median of so many."""
    words = [
        ['-m', 'eventreg_ros', *command.format(f'sweep_{i}').split()] for i in range(times + 1)
    ]
    first, compiled = used(words[0], scratch)
    again = [used(each, scratch) for each in words[1:]]
    seconds = statistics.median(time for time, _ in again)
    later = sum(count for _, count in again)
    name = f'eventreg {command.format("DIR")}'
    return f'| {name} | {first:.2f} | {compiled} | {seconds:.2f} | {later} | {goal} |'


def main() -> None:
    """Run everything and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--times', type=int, default=5)
    args = parser.parse_args()
    os.environ['PYTHONPATH'] = os.pathsep.join(filter(None, sys.path))
    print(f'load average {os.getloadavg()[0]:.2f}')
    print('| command | first, s | compiled | then, s | compiled | goal |')
    print('|---|---:|---:|---:|---:|---:|')
    with tempfile.TemporaryDirectory() as scratch:
        for command, goal in COMMANDS.items():
            print(row(command, goal, Path(scratch), args.times), flush=True)
        own = ['-c', IMPORTS]
        imports = statistics.median(used(own, Path(scratch))[0] for _ in range(args.times))
    print(f'| of it imports, margin | | | {imports:.2f} | | |')
    print(f'load average {os.getloadavg()[0]:.2f}')


if __name__ == '__main__':
    main()
