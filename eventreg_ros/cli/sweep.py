# SPDX-License-Identifier: Apache-2.0
"""``eventreg sweep``: the sampled loop over many sets of parameters. Needs no ROS.

``-p NODE.PARAM:=SPEC`` varies a parameter (:mod:`..robustness.axes` says how), ``-p
NODE.PARAM:=VALUE`` fixes one; ``links`` in the place of a node are all links, as --delay, --loss,
--jitter and --seed of ``eventreg simulate``; ``noise.SIGNAL`` is its --noise. The table has a row
per set; its columns beyond the contract's are ``peak``, ``settling``, ``latency``
(:data:`..robustness.outcome.ROW`) and ``reason``, why a set has no verdict.

``--json F`` writes ``{"parameters", "sets", "rejected", "not_rejected", "undecided", "bad",
"seconds", "out"}``, with ``--sets`` also ``"yield": {"share", "low", "high"}`` (Wilson, 95 %), with
``--indices`` also ``"indices"``. With ``--border``: ``{"border": [X, Y], "runs", "grid",
"curves"}``; with ``--worst``: ``{"worst": {PARAMETER: VALUE}, "verdict", "spurious", "missed",
"residual_max_abs", "peak", "runs"}``. The exit code is 0 whatever is found, 2 for bad input, 130
when it was stopped: the same command goes on.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import EventregError
from ..files import need_writable, writing
from .arguments import (
    add_json,
    add_scenario,
    add_window,
    check_plot,
    positive,
    whole,
    write_json,
    write_text,
)
from .progress import Count, say_if_slow

if TYPE_CHECKING:
    from ..plots.comparison_plot import Shown
    from ..robustness.plan import Plan
    from ..robustness.sweep import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg sweep``."""
    add_scenario(parser)
    parser.add_argument('--sets', type=whole(1), metavar='N', help='draw N sets at random')
    parser.add_argument('--seed', type=whole(0), default=0, metavar='S', help='of the draws (0)')
    parser.add_argument(
        '--sobol', action='store_true', help="draw from Sobol's sequence; N must be a power of 2"
    )
    parser.add_argument(
        '--indices', action='store_true',
        help='which parameter matters: N (parameters + 2) sets, variance-based indices by SALib',
    )  # fmt: skip
    parser.add_argument(
        '--border', metavar='X,Y',
        help='only the border between rejected and not over two ranges, X and Y of the -p',
    )  # fmt: skip
    parser.add_argument(
        '--worst', type=whole(5), metavar='N',
        help='search the ranges with N runs for the set that comes nearest to an event',
    )  # fmt: skip
    parser.add_argument('--on', metavar='SIGNAL,...', help='signals whose links are impaired (all)')
    parser.add_argument('--duration', type=positive, metavar='T', help='of a run, model time (400)')
    parser.add_argument(
        '--out', type=Path, metavar='DIR',
        help='keep the table (sweep.parquet, or sweep.csv where DIR ends in .csv), and go on there',
    )  # fmt: skip
    parser.add_argument(
        '--engine', choices=('local', 'dask'), default='local', help='where it runs (local)'
    )
    parser.add_argument(
        '--scheduler', metavar='ADDR', help='of a Dask cluster (none: a worker per processor here)'
    )
    parser.add_argument('--plot', type=Path, metavar='F', help='draw it: .png .svg .pdf')
    parser.add_argument('--report', type=Path, metavar='F.html', help='write a page')
    add_json(parser)
    add_window(parser)


def main(args: argparse.Namespace) -> int:
    """Run the sweep, print what came of it, write what was asked for, and return 0."""
    check_plot(args.plot)
    need_writable(args.json)
    need_writable(args.report)
    plan = _plan(args)
    say_if_slow('sets run one by one in plain Python, about a thousand times slower')
    count = Count()
    kind = _border if args.border else _worst if args.worst is not None else _table
    try:
        found = kind(args, plan, count.show)
    except KeyboardInterrupt:
        kept = f'; what is done is in {args.out}, the same command goes on' if args.out else ''
        count.clear()
        print(f'eventreg: stopped{kept}', file=sys.stderr)
        raise
    count.clear()
    print(found.text, flush=True)
    write_json(args.json, found.result)
    if args.plot is not None or args.report is not None:
        _draw(args, plan, found)
    return 0


class Found(NamedTuple):
    """What a sweep gives: words, JSON, and what draws it."""

    text: str
    result: dict[str, Any]
    draw: Callable[[], Any]


def _plan(args: argparse.Namespace) -> Plan:
    from .. import scenario as scenarios
    from ..robustness.plan import Plan

    if args.border and (args.sets or args.worst):
        raise EventregError('--border, --sets and --worst are three questions; ask one at a time')
    if args.indices and not args.sets:
        raise EventregError('--indices draws sets; say how many with --sets N, a power of 2')
    sampling = 'saltelli' if args.indices else 'sobol' if args.sobol else 'random'
    asked = args.worst is not None
    return Plan.of(
        scenarios.load(args.scenario),
        args.overrides,
        sets=1 if asked else args.sets,
        seed=args.seed,
        sampling=sampling if args.sets or asked else 'grid',
        on=None if args.on is None else tuple(filter(None, args.on.split(','))),
        duration=args.duration,
        settle=args.settle,
        window=args.window,
    )


def _table(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    from ..robustness.cluster import runner
    from ..robustness.sweep import run_sweep
    from ..robustness.sweep_words import sweep_words
    from ..robustness.yields import indices, scenario_text, worst_of, yield_of

    sweep = run_sweep(plan, args.out, runner(args.engine, args.scheduler), progress)
    result = sweep.as_json()
    share = yield_of(sweep.rejected, sweep.sets) if plan.sets else None
    matters = indices(sweep) if args.indices else []
    if share is not None:
        result['yield'] = share._asdict()
        at = worst_of(sweep.columns) if args.out else None
        if at is not None:
            values = [sweep[axis.name][at] for axis in plan.axes]
            write_text(args.out / 'worst.yaml', scenario_text(plan, values))
    if args.indices:
        result['indices'] = [index._asdict() for index in matters]

    def draw() -> Any:
        from ..plots.sweep_plot import draw_result

        return draw_result(sweep)

    return Found(sweep_words(sweep, share, matters), result, draw)


def _border(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    from ..robustness.border import border_csv, find_border
    from ..robustness.sweep_words import border_words

    border = find_border(plan, args.border.split(','), progress)
    if args.out is not None:
        args.out.mkdir(parents=True, exist_ok=True)
        write_text(args.out / 'border.csv', border_csv(border))

    def draw() -> Any:
        from ..plots.sweep_map import draw_border

        return draw_border(border.names, border.curves, border.points, plan.name)

    result = {
        'border': list(border.names),
        'runs': border.runs,
        'grid': border.grid,
        'curves': [curve.tolist() for curve in border.curves],
    }
    return Found(border_words(plan, border), result, draw)


def _worst(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    from ..robustness.sweep_words import worst_words
    from ..robustness.worst import search
    from ..robustness.yields import scenario_text

    worst = search(plan, args.worst, progress)
    if args.out is not None:
        args.out.mkdir(parents=True, exist_ok=True)
        write_text(args.out / 'worst.yaml', scenario_text(plan, worst.values))

    def draw() -> Any:
        from ..plots.comparison_plot import draw_comparison

        return draw_comparison([_shown(plan, worst.values)])

    named = {axis.name: v for axis, v in zip(plan.axes, worst.values, strict=True)}
    plain = {name: v.item() if hasattr(v, 'item') else v for name, v in named.items()}
    result = {'worst': plain, **{k: v for k, v in worst._asdict().items() if k != 'values'}}
    return Found(worst_words(plan, worst), result, draw)


def _shown(plan: Plan, values: Sequence[Any]) -> Shown:
    """Return one set as it is drawn."""
    from ..analysis.events import detect
    from ..analysis.signal import Signal
    from ..plots.comparison_plot import Shown
    from ..robustness.sets import Sets
    from ..simulation.sampled import simulate_sampled

    sets = Sets(plan)
    links, noise = sets.imperfections(values)
    loop = sets.scenario(values).loop
    run = simulate_sampled(loop, plan.duration, links, noise=noise)
    signals = {signal: Signal(run.t, x) for signal, x in run.signals.items()}
    found = {s: detect(t, x, *plan.subject.criteria.detector) for s, (t, x) in signals.items()}
    return Shown('worst', signals, found)


def _draw(args: argparse.Namespace, plan: Plan, found: Found) -> None:
    from ..plots.style import save
    from ..plots.sweep_page import render_sweep

    picture = found.draw()
    if args.plot is not None:
        with writing(args.plot) as file:
            save(picture, file)
    if args.report is not None:
        write_text(args.report, render_sweep(plan.name, plan.parameters, found.text, picture))
