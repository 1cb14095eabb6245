# SPDX-License-Identifier: Apache-2.0
"""The questions of a sweep: every set, the border, the worst set; and their answers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import EventregError
from ..files import writing
from .arguments import write_text

if TYPE_CHECKING:
    from ..plots.comparison_plot import Shown
    from ..robustness.plan import Plan
    from ..robustness.sweep import Progress


class Found(NamedTuple):
    """What a sweep gives: words, JSON, and what draws it."""

    text: str
    result: dict[str, Any]
    draw: Callable[[], Any]


def plan_of(args: argparse.Namespace) -> Plan:
    """Return what is asked for. Raises EventregError for questions that do not go together."""
    from .. import scenario as scenarios
    from ..robustness.plan import Plan

    _check_questions(args)
    sampling = 'saltelli' if args.indices else 'sobol' if args.sobol else 'random'
    asked = args.worst is not None
    return Plan.of(
        scenarios.load(args.scenario),
        args.overrides,
        sets=1 if asked else args.sets,
        seed=args.seed,
        sampling=sampling if args.sets or asked else 'grid',
        on=None if args.on is None else tuple(args.on),
        duration=args.duration,
        settle=args.settle,
        window=args.window,
        question=f'border {args.border}' if args.border else f'worst {args.worst}' if asked else '',
    )


def _check_questions(args: argparse.Namespace) -> None:
    """Raise EventregError for options that do not go together, none is passed over."""
    other = '--border' if args.border else '--worst' if args.worst is not None else ''
    if (args.sets is not None) + bool(args.border) + (args.worst is not None) > 1:
        raise EventregError('--border, --sets and --worst are three questions; ask one at a time')
    for name in ('indices', 'sobol'):
        if getattr(args, name) and args.sets is None:
            raise EventregError(f'--{name} draws sets; say how many with --sets N, a power of 2')
    if other and args.engine == 'dask':
        raise EventregError(f'{other} runs on this machine; leave out --engine dask')
    if args.scheduler is not None and args.engine != 'dask':
        raise EventregError(f'--scheduler {args.scheduler} is of a Dask cluster; add --engine dask')


def table(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    """Run every set of a grid or of a draw; write the worst one of a draw."""
    from ..robustness.cluster import runner
    from ..robustness.sweep import run_sweep
    from ..robustness.sweep_words import sweep_words
    from ..robustness.yields import (
        indices,
        scenario_text,
        worst_set,
        yield_of_sweep,
        yields_at_margins,
    )

    sweep = run_sweep(plan, args.out, runner(args.engine, args.scheduler), progress)
    result = sweep.as_json()
    share = yield_of_sweep(sweep) if plan.sets else None
    margins = yields_at_margins(sweep) if plan.sets else []
    matters = indices(sweep) if args.indices else []
    if share is not None:
        result['yield'] = {**share._asdict(), 'margins': [each._asdict() for each in margins]}
        values = worst_set(sweep) if args.out else None
        if values is not None:
            write_text(args.out / 'worst.yaml', scenario_text(plan, values))
    if args.indices:
        result['indices'] = [index._asdict() for index in matters]

    def draw() -> Any:
        from ..plots.sweep_plot import draw_result

        return draw_result(sweep)

    return Found(sweep_words(sweep, share, margins, matters), result, draw)


def border(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    """Find the border between rejected and not, follow it, and write both."""
    from ..robustness.border import border_csv
    from ..robustness.evaluations import kept
    from ..robustness.followed import orbit_csv
    from ..session.bordered import border_of

    with kept(plan, args.out) as store:
        found = border_of(plan, args.border.split(','), progress, store)
        if args.out is not None:
            write_text(args.out / 'border.csv', border_csv(found.on_grid))
            write_text(args.out / 'border_orbit.csv', orbit_csv(found.on_grid, found.followed))
    return Found(str(found), found.as_json(), found.plot)


def worst(args: argparse.Namespace, plan: Plan, progress: Progress) -> Found:
    """Search the set that comes nearest to an event, and write it as a scenario."""
    from ..robustness.evaluations import kept
    from ..robustness.sweep_words import worst_words
    from ..robustness.worst import search
    from ..robustness.yields import scenario_text

    with kept(plan, args.out) as store:
        found = search(plan, args.worst, progress, store)
        if args.out is not None:
            write_text(args.out / 'worst.yaml', scenario_text(plan, found.values))

    def draw() -> Any:
        from ..plots.comparison_plot import draw_comparison

        return draw_comparison([_shown(plan, found.values)])

    named = {axis.name: v for axis, v in zip(plan.axes, found.values, strict=True)}
    plain = {name: v.item() if hasattr(v, 'item') else v for name, v in named.items()}
    result = {'worst': plain, **{k: v for k, v in found._asdict().items() if k != 'values'}}
    return Found(worst_words(plan, found), result, draw)


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


def draw(args: argparse.Namespace, plan: Plan, found: Found) -> None:
    """Draw what was found, and write the picture and the page that were asked for."""
    from ..plots.style import save
    from ..plots.sweep_page import render_sweep

    picture = found.draw()
    if args.plot is not None:
        with writing(args.plot) as file:
            save(picture, file)
    if args.report is not None:
        write_text(args.report, render_sweep(plan.name, plan.parameters, found.text, picture))
