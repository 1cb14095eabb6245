# SPDX-License-Identifier: Apache-2.0
"""Sweeps, borders and searches in words."""

from __future__ import annotations

from collections.abc import Sequence

from .border import Border
from .plan import Plan
from .sweep import Sweep
from .worst import Worst
from .yields import Index, Yield


def sweep_words(sweep: Sweep, share: Yield | None, found: Sequence[Index]) -> str:
    """Return what came of a sweep, a few lines."""
    plan = sweep.plan
    varied = ', '.join(axis.name for axis in plan.axes) or 'nothing varied'
    pace = sweep.sets / sweep.seconds if sweep.seconds > 0.0 else 0.0
    lines = [
        f'{plan.name}: {sweep.sets} sets of {varied}; {plan.duration:g} model time units each, '
        f'counted after {plan.subject.criteria.settle:g}',
        f'rejected {sweep.rejected}, not rejected {sweep.not_rejected}, '
        f'undecided {sweep.undecided}, without a verdict {sweep.bad}',
        f'{sweep.seconds:.1f} s, {pace:.0f} sets a second'
        + (f'; table in {sweep.out}' if sweep.out else '; nothing kept, --out DIR keeps the table'),
    ]
    if share is not None:
        lines.append(
            f'yield {100.0 * share.share:.2f} %, 95 % interval '
            f'{100.0 * share.low:.2f} to {100.0 * share.high:.2f} %'
        )
    lines += [
        f'{each.quantity:14} {each.parameter:24} alone {each.first:6.3f} +- {each.first_within:.3f}'
        f'   in all {each.total:6.3f} +- {each.total_within:.3f}'
        for each in found
    ]
    return '\n'.join(lines)


def border_words(plan: Plan, border: Border) -> str:
    """Return what came of the search for a border."""
    share = border.runs / border.grid
    length = sum(len(curve) for curve in border.curves)
    found = (
        f'{len(border.curves)} curve{"s" if len(border.curves) != 1 else ""} of {length} points'
        if border.curves
        else 'no border: the verdict is the same all over the coarse grid'
    )
    return (
        f'{plan.name}: border between rejected and not over {" and ".join(border.names)}\n'
        f'{found}; {border.runs} runs, {100.0 * share:.1f} % of a grid of {border.grid}'
    )


def worst_words(plan: Plan, worst: Worst) -> str:
    """Return what came of the search for the worst set."""
    values = ', '.join(
        f'{axis.name} {value:g}' if isinstance(value, float) else f'{axis.name} {value}'
        for axis, value in zip(plan.axes, worst.values, strict=True)
    )
    return (
        f'{plan.name}: the worst of {worst.runs} sets has {values}\n'
        f'spurious {worst.spurious}, missed {worst.missed}, largest residual '
        f'{worst.residual_max_abs:.3g}, largest y - y_r {worst.peak:.3g}\n'
        f'verdict: {worst.verdict}'
    )
