# SPDX-License-Identifier: Apache-2.0
"""Does a long run stay flat? Memory and open handles of every node, minute by minute.

Run ``PYTHONPATH=. python bench/soak.py`` (an hour; ``--minutes`` for less) from the top of the
repository; needs ROS 2 and Linux (it reads /proc). Prints one row per node: what it held after the
first tenth of the run and at the end, with the limit beside it.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from eventreg_ros import scenario as scenarios
from eventreg_ros.session.observer import Observer
from eventreg_ros.session.session import Session

GROWTH = 2.0
"""MiB per hour that a process may grow."""

HEAD = '| node | MiB after a tenth | MiB at the end | MiB per hour | limit | handles | at the end |'


class Watcher(Observer):
    """Looks at the processes of a session once a minute at most."""

    def __init__(self, every: float) -> None:
        self.session: Session | None = None
        self.rows: dict[str, list[tuple[float, float, int]]] = {}
        self._every, self._next = every, 0.0

    def progressed(self, elapsed: float, counts: Mapping[str, int], last: bool = False) -> None:
        """Note memory and handles of every process."""
        if elapsed < self._next or self.session is None:
            return
        self._next = elapsed + self._every
        for name, process in self.session.processes.running.items():
            if (found := held(process.pid)) is not None:
                self.rows.setdefault(name, []).append((elapsed, *found))


def held(pid: int) -> tuple[float, int] | None:
    """Return MiB of resident memory and the number of open handles of a process."""
    try:
        status = Path(f'/proc/{pid}/status').read_text()
        handles = len(list(Path(f'/proc/{pid}/fd').iterdir()))
    except OSError:
        return None
    kib = next(int(line.split()[1]) for line in status.splitlines() if line.startswith('VmRSS'))
    return kib / 1024, handles


def main() -> int:
    """Run and print the table; 1 when a process grew beyond the limit."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument('--minutes', type=float, default=60.0)
    parser.add_argument('--scenario', default='exact')
    args = parser.parse_args()
    seconds = 60.0 * args.minutes
    watcher = Watcher(max(seconds / 60.0, 1.0))
    with tempfile.TemporaryDirectory(prefix='eventreg_soak_') as scratch:
        scenario = scenarios.load(args.scenario)
        watcher.session = Session(scenario, Path(scratch) / 'bag', seconds, observer=watcher)
        began = time.monotonic()
        watcher.session.perform()
        print(f'{args.scenario} for {(time.monotonic() - began) / 60:.1f} minutes\n')
    print(f'{HEAD}\n|---|---:|---:|---:|---:|---:|---:|')
    worst = 0.0
    for name, rows in watcher.rows.items():
        (t0, before, handles), (t1, after, still) = rows[len(rows) // 10], rows[-1]
        growth = (after - before) / max(t1 - t0, 1.0) * 3600.0
        worst = max(worst, growth)
        print(f'| {name} | {before:.1f} | {after:.1f} | {growth:.2f} | {GROWTH:g} | {handles} | '
              f'{still} |')  # fmt: skip
    return int(worst > GROWTH)


if __name__ == '__main__':
    raise SystemExit(main())
