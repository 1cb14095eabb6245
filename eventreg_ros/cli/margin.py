# SPDX-License-Identifier: Apache-2.0
"""``eventreg margin``: how much delay, loss and jitter the loop tolerates. Needs no ROS.

``--json F`` writes ``{"scenario", "time_scale", "duration", "settle", "window", "seeds", "holds":
{"zero": {"delay": LIMIT, "loss": LIMIT, "jitter": LIMIT, "delay_at_rate": LIMIT, "delay_of":
{SIGNAL: LIMIT, ...}}, "linear": ...}}``: the same on every link; then the delay at the rate of loss
and jitter, the scenario's own; then the delay of one signal alone. Of a loop that predicts,
``delay`` is of the links ``on`` to the controller and from it, with the lead set to the delay,
``delay_at_lead`` the same with the scenario's lead, and every LIMIT has a ``lead``: "delay", or the
lead. A LIMIT is ``{"rate",
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
from pathlib import Path
from typing import TYPE_CHECKING

from ..files import need_writable, writing
from .arguments import (
    add_json,
    add_scenario,
    add_window,
    check_plot,
    load_scenario,
    positive,
    whole,
    write_json,
)
from .progress import Count

if TYPE_CHECKING:
    from ..robustness.evaluator import Setting
    from ..robustness.margins import Map
    from ..scenario import Scenario

SMALLER = {'columns': 8, 'rows': 10}
"""The size of the picture's map without numba, where a run takes a hundred times as long."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg margin``."""
    add_scenario(parser)
    parser.add_argument(
        '--duration', type=positive, metavar='T',
        help='of a run, model time (400, or 300 after settling)',
    )  # fmt: skip
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
    from ..robustness.margin_words import result, table
    from ..robustness.margins import delay_and_loss, margins, reach
    from ..simulation.jit import compiles

    check_plot(args.plot)
    need_writable(args.json)
    scenario = load_scenario(args)
    setting = Setting.of(
        scenario,
        duration=args.duration,
        settle=args.settle,
        window=args.window,
        seeds=args.seeds,
        rate=args.rate,
    )
    found: Map | None = None
    count = Count('searches')
    try:
        limits = margins(scenario, setting, count.show)
        if args.plot is not None:
            size = {} if compiles() else SMALLER
            count = Count('rows of the picture')
            found = delay_and_loss(scenario, reach(limits), setting, count.show, **size)
    finally:
        count.clear()
    print(table(scenario, setting, limits), flush=True)
    write_json(args.json, result(scenario, setting, limits, found))
    if found is not None:
        draw(args.plot, found, scenario, setting)
    return 0


def draw(path: Path, found: Map, scenario: Scenario, setting: Setting) -> None:
    """Draw the map and write it to ``path``. Raises EventregError when it cannot."""
    from ..plots.margin_map import draw_map
    from ..plots.style import save

    title = (
        f'{scenario.name}: verdict at {found.rate:g} samples per second (h = {found.h:g}), '
        f'{setting.seeds} seeds, {setting.duration:g} model time units'
    )
    picture = draw_map(found.delays, found.losses, found.rejected, title, scenario.time_scale)
    with writing(path) as file:
        save(picture, file)
