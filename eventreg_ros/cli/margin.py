# SPDX-License-Identifier: Apache-2.0
"""``eventreg margin``: how much delay, loss and jitter the loop tolerates. Needs no ROS.

docs/json.md says what ``--json F`` writes. The exit code is 0 whatever the margin is, and 2 for bad
input; a scenario whose verdict is undecided is that, too.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..files import need_writable, writing
from ..scenario.criteria import SEEDS
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
from .progress import Count, say_if_slow

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
        '--duration', type=positive, metavar='T', help='of a run, model time (300 after settling)'
    )
    parser.add_argument(
        '--seeds', type=whole(1), default=SEEDS, metavar='N',
        help=f'runs that must all be rejected ({SEEDS})',
    )  # fmt: skip
    parser.add_argument(
        '--rate', type=positive, metavar='R',
        help="steps per second (the scenario's; for delays so many that h is at most 0.01)",
    )  # fmt: skip
    parser.add_argument(
        '--plot', type=Path, metavar='F', help='draw verdicts over delay and loss: .png .svg .pdf'
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
    asked = {
        name: getattr(args, name) for name in ('duration', 'settle', 'window', 'seeds', 'rate')
    }
    setting = Setting.of(scenario, **asked)
    found: Map | None = None
    say_if_slow('this takes minutes in plain Python, seconds with it')
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
