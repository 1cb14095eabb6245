"""``eventreg margin``: how much delay, loss and jitter the loop bears. Needs no ROS.

``--json F`` writes ``{"scenario", "time_scale", "duration", "settle", "window", "seeds", "holds":
{"zero": {"delay": LIMIT, "loss": LIMIT, "jitter": LIMIT, "delay_at_rate": LIMIT, "delay_of":
{SIGNAL: LIMIT, ...}}, "linear": ...}}``: the same on every link; then the delay at the rate of loss
and jitter, the scenario's own; then the delay of one signal alone. A LIMIT is ``{"rate",
"h", "resolution", "largest", "fails_at", "scanned_to", "rejected_again", "milliseconds"}``: delay
and jitter in model time, loss as a probability; ``largest`` is the most at which the verdict is
rejected, null where it is not even at 0; ``milliseconds`` the same as a time at the scenario's
time_scale (null for loss); ``fails_at`` the least beyond it that was seen to fail, null when
nothing failed up to ``scanned_to``; ``rejected_again`` the values of the coarse scan beyond
``fails_at`` that do not fail. With ``--plot`` there is also ``"map": {"rate", "h", "delays",
"losses", "rejected": {"zero": ROWS, "linear": ROWS}}``, one row per loss and in it, per delay, the
part of the seeds that are rejected.

The exit code is 0 whatever the margin is, and 2 for bad input, of which is a scenario whose verdict
is undecided.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import EventregError
from .arguments import (
    add_json,
    add_scenario,
    add_window,
    load_scenario,
    need_writable,
    positive,
    whole,
    write_json,
    writing,
)

if TYPE_CHECKING:
    from ..robustness.evaluator import Setting
    from ..robustness.margins import Limit, Map
    from ..scenario import Scenario

SMALLER = {'columns': 8, 'rows': 10}
"""The size of the picture's map without numba, where a run takes a hundred times as long."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg margin``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, default=400.0, metavar='T', help='of a run, model time (400)'
    )
    parser.add_argument(
        '--seeds', type=whole(1), default=5, metavar='N',
        help='random runs that must all be rejected (5)',
    )  # fmt: skip
    parser.add_argument(
        '--rate', type=positive, metavar='R',
        help="steps per second (the scenario's for loss and jitter; for the delay, which is "
        'rounded to steps, so many that one is at most 0.01 of model time)',
    )  # fmt: skip
    parser.add_argument(
        '--plot',
        type=Path,
        metavar='F',
        help='draw the verdict over delay and loss: .png .svg .pdf',
    )
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Search and print the margins, draw the picture if asked for, and return 0."""
    from ..robustness.evaluator import Setting
    from ..robustness.margins import delay_and_loss, margins, reach
    from ..simulation.jit import compiles

    check_plot(args.plot)
    need_writable(args.json)
    scenario = load_scenario(args)
    setting = Setting(args.duration, args.settle, args.window, args.seeds, args.rate)
    found: Map | None = None
    line = Line()
    try:
        limits = margins(scenario, setting, line.show)
        if args.plot is not None:
            size = {} if compiles() else SMALLER
            found = delay_and_loss(scenario, reach(limits), setting, line.show, **size)
    finally:
        line.clear()
    print(table(scenario, setting, limits), flush=True)
    write_json(args.json, result(scenario, setting, limits, found))
    if found is not None:
        draw(args.plot, found, scenario, setting)
    return 0


class Line:
    """A line on standard error that is written over; nothing where that is not a terminal."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()

    def show(self, words: str) -> None:
        """Show ``words`` in place of what was shown before."""
        if self._terminal:
            print(f'\r\x1b[K{words}', end='', file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Leave an empty line."""
        self.show('')


def check_plot(path: Path | None) -> None:
    """Raise EventregError, before any work is done, unless a picture can be written to ``path``."""
    from ..plots.style import METADATA

    if path is None:
        return
    if path.suffix.removeprefix('.') not in METADATA or not path.suffix:
        raise EventregError(
            f'--plot must end in .{", .".join(METADATA)}, got {str(path)!r}; name another file'
        )
    need_writable(path)


def draw(path: Path, found: Map, scenario: Scenario, setting: Setting) -> None:
    """Draw the map and write it to ``path``. Raises EventregError when it cannot."""
    from ..plots.margin_map import draw_map
    from ..plots.style import save

    title = (
        f'{scenario.name}: verdict at {found.rate:g} samples per second (h = {found.h:g}), '
        f'{setting.seeds} seeds, {setting.duration:g} model time units'
    )
    picture = draw_map(found.delays, found.losses, found.rejected, title, scenario.time_scale)
    with writing(path):
        save(picture, path)


def result(
    scenario: Scenario, setting: Setting, limits: list[Limit], found: Map | None
) -> dict[str, Any]:
    """Return what --json writes."""
    holds: dict[str, dict[str, Any]] = {}
    for limit in limits:
        entry = asdict(limit)
        kind, hold, on = (entry.pop(key) for key in ('kind', 'hold', 'on'))
        entry['milliseconds'] = milliseconds(limit, scenario)
        of_hold = holds.setdefault(hold, {})
        if on is not None:
            of_hold.setdefault(f'{kind}_of', {})[on] = entry
        else:
            of_hold[kind if kind not in of_hold else f'{kind}_at_rate'] = entry
    for of_hold in holds.values():
        of_hold.setdefault('delay_at_rate', of_hold['delay'])
    report: dict[str, Any] = {
        'scenario': scenario.name,
        'time_scale': scenario.time_scale,
        'duration': setting.duration,
        'settle': setting.settle,
        'window': setting.window,
        'seeds': setting.seeds,
        'holds': holds,
    }
    if found is not None:
        report['map'] = {
            'rate': found.rate,
            'h': found.h,
            'delays': [round(delay, 12) for delay in found.delays.tolist()],
            'losses': [round(loss, 12) for loss in found.losses.tolist()],
            'rejected': {hold: share.tolist() for hold, share in found.rejected.items()},
        }
    return report


def milliseconds(limit: Limit, scenario: Scenario) -> float | None:
    """Return the largest delay or jitter as a time at the scenario's time_scale."""
    if limit.largest is None or limit.kind == 'loss':
        return None
    return round(1000.0 * limit.largest / scenario.time_scale, 9)


def table(scenario: Scenario, setting: Setting, limits: list[Limit]) -> str:
    """Return the limits as a short plain table, one row per impairment, one column per hold."""
    holds = list(dict.fromkeys(limit.hold for limit in limits))
    lines = [
        f'{scenario.name}: still rejected with, on every link or those of one signal '
        f'(time_scale {scenario.time_scale:g}, {setting.duration:g} model time units, '
        f'counted after {setting.settle:g}, {setting.seeds} seeds)',
        f'{"":12}' + ''.join(f'{f"hold {hold}":>20}' for hold in holds) + f'{"resolution":>12}  at',
    ]
    for name, rate in dict.fromkeys((limit.name, limit.rate) for limit in limits):
        row = [limit for limit in limits if (limit.name, limit.rate) == (name, rate)]
        cells = ''.join(f'{words(limit, scenario):>20}' for limit in row)
        at = f'{row[0].rate:g} samples per second (h = {row[0].h:g})'
        lines.append(f'{name:12}{cells}{row[0].resolution:>12g}  {at}')
    return '\n'.join([*lines, *notes(limits)])


def words(limit: Limit, scenario: Scenario) -> str:
    """Return the cell of one limit."""
    if limit.largest is None:
        return 'none'
    text = f'{limit.largest:g}' if limit.fails_at is not None else f'>= {limit.largest:g}'
    time = milliseconds(limit, scenario)
    return text if time is None else f'{text} ({time:g} ms)'


def notes(limits: list[Limit]) -> list[str]:
    """Return what must be said about single limits, one line each."""
    lines = [
        f'{limit.name}, hold {limit.hold}: rejected again at '
        f'{", ".join(f"{value:g}" for value in limit.rejected_again)}: the verdict is not monotone'
        for limit in limits
        if limit.rejected_again
    ]
    if any(limit.largest is None for limit in limits):
        lines.append('none: the verdict is not rejected even without delay, loss and jitter')
    if any(limit.fails_at is None for limit in limits):
        lines.append('>=: nothing failed as far as was searched')
    return lines
