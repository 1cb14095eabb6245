# SPDX-License-Identifier: Apache-2.0
"""Sweeps, borders and searches in words."""

from __future__ import annotations

from collections.abc import Sequence

from .border import Border
from .followed import NEAR, Followed
from .plan import Plan
from .sweep import Sweep
from .worst import Worst
from .yields import AtMargin, Index, Yield


def sweep_words(
    sweep: Sweep,
    share: Yield | None = None,
    margins: Sequence[AtMargin] = (),
    found: Sequence[Index] = (),
) -> str:
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
    if sweep.bad:
        lines.append(f'the first without a verdict: {next(filter(None, sweep["reason"]))}')
    if share is not None:
        lines.append(
            f'yield {100.0 * share.share:.2f} %, 95 % interval '
            f'{100.0 * share.low:.2f} to {100.0 * share.high:.2f} %'
        )
    lines += [
        f'with y - y_r below {each.level:g}: {100.0 * each.share:.2f} %, '
        f'{100.0 * each.low:.2f} to {100.0 * each.high:.2f} %'
        for each in margins
    ]
    lines += [
        f'{each.quantity:14} {each.parameter:24} alone {each.first:6.3f} +- {each.first_within:.3f}'
        f'   in all {each.total:6.3f} +- {each.total_within:.3f}'
        for each in found
    ]
    return '\n'.join(lines)


def border_words(plan: Plan, border: Border, followed: Followed) -> str:
    """Return what came of the search for a border, and of following it."""
    share = border.runs / border.grid
    length = sum(len(curve) for curve in border.places)
    found = (
        f'{_pieces(len(border.places))} of {length} points'
        if border.places
        else 'no border: the verdict is the same all over the coarse grid'
    )
    lines = [
        f'{plan.name}: border between rejected and not over {" and ".join(border.names)}',
        f'{found}; {border.runs} runs, {100.0 * share:.1f} % of a grid of {border.grid}',
    ]
    if border.undecided or border.bad:
        lines.append(
            f'{border.undecided} of the runs undecided and {border.bad} without a verdict: '
            f'they count as not rejected'
        )
    if border.bad:
        lines.append(f'the first without a verdict: {border.why}')
    if border.places:
        lines += _followed_words(border, followed, plan.subject.criteria.threshold)
    return '\n'.join(lines)


def _followed_words(border: Border, followed: Followed, threshold: float) -> list[str]:
    if not followed.pieces:
        return [f'not followed as a periodic orbit: {followed.reason}']
    lines = [
        f'followed as the orbit whose largest y is {threshold:g}: {_pieces(len(followed.pieces))} '
        f'of {followed.points} points, at most {followed.apart:.2g} steps of the grid from its '
        f'border; two runs differ within {followed.within:.2g} of a step on either side of each'
    ]
    if followed.apart > NEAR:
        lines.append('what is far from it lies between the points that the grid was tried at')
    whole, lacks = sum(len(places) for places in border.places), list[str]()
    if followed.missed:
        lacks.append(
            f"{followed.missed} of {whole} points of the grid's border have no such curve nearby"
        )
    if followed.dropped:
        lacks.append(f'{followed.dropped} points of the curve are left out')
    if lacks:
        lines.append(f'not everywhere: {", and ".join(lacks)}: {followed.reason}')
    return lines


def _pieces(count: int) -> str:
    return f'{count} curve{"s" if count != 1 else ""}'


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
