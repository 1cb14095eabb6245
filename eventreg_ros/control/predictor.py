# SPDX-License-Identifier: Apache-2.0
"""Observer and prediction: a controller for loops whose links are late.

The controller lives in the plant's past. After sample m of y its state is that of time m: x, the
copy of the exosystem, and (p1, p2), a replica of the plant that hears what the plant heard,

    e(t) = y(t) - p1(t)
    x'   = the copy (eq. s.I, and how it learns) with the drive e
    p'   = the plant's model (eq. fhn) with the drive x1 - u + v,

where u is what the controller itself meant for time t, by its own record, and v as the plant hears
it: on the same lines between samples as there (:func:`..simulation.hold.line`). y answers w - u and
p1 answers x1 - u, so e answers w - x1 as in the paper without delay. Then the copy alone runs on
with e = 0 to the time at which the plant will play the sample to come, and that is u.

Sample s of u is meant for step s + lead. A lost sample of y is bridged by a straight line; one that
has not come when the next y is older than the lead and ``patience`` steps is skipped (e = 0).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from ..models import NEURON, Model, Params, State
from ..simulation.hold import line
from ..simulation.numbered import Advance, Own, Reader
from ..simulation.step import Compile, make_step, plain


class Foresight(NamedTuple):
    """The numbers of a predicting controller that may change from run to run.

    ``copy`` and ``plant`` are the parameters of the two models; ``lead`` and ``patience`` are in
    steps of the loop, ``coarse`` is that of the prediction in them. ``horizon`` is that of u as in
    :func:`..simulation.hold.line`, ``opens`` those of the measured inputs. ``held``: 1 where y
    stays as it is between samples, 0 where it goes straight from one to the next.
    """

    copy: Params
    plant: Params
    lead: int
    patience: int
    coarse: int
    horizon: float
    opens: tuple[float, ...]
    held: float


def at_start(x0: State, n: int) -> State:
    """Return the state of a predictor that begins at step ``n``.

    The copy (at ``x0``), the replica (at rest), the step m of both, y there, whether y is known
    there (0 or 1), and n, before which u has not been.
    """
    return (*x0, *(0.0,) * NEURON.dimension, float(n), 0.0, 0.0, float(n))


def make_predictor(
    model: Model, readers: Sequence[Reader], own: Own, compile: Compile = plain
) -> Advance:
    """Return ``step(n, x, foresight, h, past) -> (x, u)``, u being sample n + 1.

    ``x`` is as :func:`at_start` has it. The first of ``readers`` is that of y, of which it uses the
    samples up to n that are there; the others are those of the measured inputs. ``compile`` is
    applied to every function that it calls.
    """
    y, *opens = readers
    follow = _make_follow(model, opens, own, compile)
    foresee = make_foresee(model, compile)
    newest, last, value = (compile(each) for each in y)
    at = model.dimension + NEURON.dimension

    def step(n: int, x: State, foresight: Foresight, h: float, past: Any) -> tuple[State, float]:
        end = min(newest(n, past), n)
        for s in range(int(x[at]) + int(x[at + 2]), end + 1):
            if last(s, past) == s:
                x = follow(n, s, value(s, past), 1.0, x, foresight, h, past)
        skipped = n - foresight.lead - foresight.patience
        if x[at] < skipped:
            x = follow(n, skipped, 0.0, 0.0, x, foresight, h, past)
        return x, foresee(x, n + 1 + foresight.lead - int(x[at]), foresight, h)

    return compile(step)  # type: ignore[no-any-return]


def make_foresee(model: Model, compile: Compile = plain) -> Callable[..., float]:
    """Return ``foresee(x, steps, foresight, h) -> u``: the copy's output so many steps later.

    Where e = 0 nothing is learned, so that the copy may run on as the model that does not learn.
    """
    base, split = model.base or model, compile(model.split or _whole)
    own, n = model.own, model.dimension
    move = make_step(base.rhs, own, compile)
    output = compile(model.output)

    def foresee(x: State, steps: int, foresight: Foresight, h: float) -> float:
        learned, (x, p) = x[own:n], split(x[:n], foresight.copy)
        while steps >= foresight.coarse:
            x = move(x, 0.0, 0.0, 0.0, p, h * foresight.coarse)
            steps -= foresight.coarse
        while steps > 0:
            x = move(x, 0.0, 0.0, 0.0, p, h)
            steps -= 1
        return output(x + learned, 0.0, foresight.copy)  # type: ignore[no-any-return]

    return compile(foresee)  # type: ignore[no-any-return]


def _whole(x: State, p: Params) -> tuple[State, Params]:
    return x, p


def _make_follow(
    model: Model, opens: Sequence[Reader], own: Own, compile: Compile
) -> Callable[..., State]:
    """Return ``follow(n, s, ys, known, x, foresight, h, past)``: the state at sample s of y.

    In between y is the straight line to ``ys``, or the replica's own where that is not ``known``.
    """
    observe, confine = make_observer(model, compile), compile(model.confine)
    heard, size = _make_heard(opens, own, compile), model.dimension
    at = size + NEURON.dimension

    def follow(
        n: int, s: int, ys: float, known: float, x: State, foresight: Foresight, h: float,
        past: Any,
    ) -> State:  # fmt: skip
        z, m, y, gain, since = x[:at], int(x[at]), x[at + 1], x[at + 2] * known, x[at + 3]
        p, gap, rise = (foresight.copy, foresight.plant), float(s - m), ys - y
        for j in range(s - m):
            base, slope = heard(n, m + j, int(since), foresight, past)
            y0, y1 = y + rise * (j / gap), y + rise * ((j + 1.0) / gap)
            if foresight.held != 0.0:
                y0, y1 = y, y + (rise if j + 1 == s - m else 0.0)
            z = observe(z, gain, y0, y1, base, slope, p, h)
            z = confine(z[:size], foresight.copy) + z[size:]
        return z + (float(s), ys, known, since)  # noqa: RUF005 (numba joins tuples by +)

    return compile(follow)  # type: ignore[no-any-return]


def make_observer(model: Model, compile: Compile = plain) -> Callable[..., State]:
    """Return ``observe(z, gain, y0, y1, base, slope, p, h) -> z``, copy and replica one step on.

    y goes straight from ``y0`` to ``y1`` and counts with ``gain`` (0: e = 0); v - u is on the line
    (``base``, ``slope``). ``p`` are the parameters of both models.
    """
    size = model.dimension
    copy, plant = compile(model.rhs), compile(NEURON.rhs)

    def rhs(z: State, drive: Any, p: Any) -> State:
        x, replica = z[:size], z[size:]
        e = drive[0] * (drive[1] - replica[0])
        return copy(x, e, p[0]) + plant(replica, x[0] + drive[2], p[1])  # type: ignore[no-any-return]

    move = make_step(rhs, size + NEURON.dimension, compile)

    def observe(
        z: State, gain: float, y0: float, y1: float, base: float, slope: float, p: Any, h: float
    ) -> State:
        middle = (gain, y0 + 0.5 * (y1 - y0), base + 0.5 * slope)
        return move(z, (gain, y0, base), middle, (gain, y1, base + slope), p, h)  # type: ignore[arg-type]

    return compile(observe)  # type: ignore[no-any-return]


def _make_heard(
    opens: Sequence[Reader], own: Own, compile: Compile
) -> Callable[..., tuple[float, float]]:
    """Return ``heard(n, q, since, foresight, past)``: v - u over step q as the plant has it."""
    extend = compile(line)
    if opens:
        newest, last, value = (compile(each) for each in opens[-1])
        index = len(opens) - 1
        others = _make_heard(opens[:-1], own, compile)

        def heard(
            n: int, q: int, since: int, foresight: Foresight, past: Any
        ) -> tuple[float, float]:
            base, slope = others(n, q, since, foresight, past)
            i = last(min(newest(n, past), q), past)
            if i < since:
                return base, slope
            j, v, horizon = last(i - 1, past), value(i, past), foresight.opens[index]
            if j < since:
                b, s = extend(v, v, float(q - i), 1.0, horizon)
            else:
                b, s = extend(v, value(j, past), float(q - i), float(i - j), horizon)
            return base + b, slope + s

        return compile(heard)  # type: ignore[no-any-return]
    mine = compile(own)

    def acted(n: int, q: int, since: int, foresight: Foresight, past: Any) -> tuple[float, float]:
        s = q - foresight.lead
        if s < since:
            return 0.0, 0.0
        u = mine(s, past)
        before = mine(s - 1, past) if s > since else u
        b, rise = extend(u, before, 0.0, 1.0, foresight.horizon)
        return -b, -rise

    return compile(acted)  # type: ignore[no-any-return]
