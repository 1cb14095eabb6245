# SPDX-License-Identifier: Apache-2.0
"""Spikes: u as two events a period, and the generator by which the receiver makes u of them again.

An event is sent when the predicted x1 passes 0: its sign says whether x1 rises or falls, and by
interpolation it is known when between two samples. The receiver lets a neuron of its own run
freely (eq. fhn with k = 0, which is what a half of an oscillator in antiphase is) and sets it at
each event to the point of its limit cycle where x1 is 0, so that its phase is the sender's. Its
time runs faster or slower by the sender's period, as seen between events of the same sign.

The message is sign * (1 + a): a is how long before its own sample the event was, in model time.
0 says that the sender was switched off.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

from ..models import NEURON, State
from ..simulation.coding import Code, MakeCode, MakeCopy
from ..simulation.step import Compile, make_step, plain

FINE = 0.01
"""Step (model time) by which the limit cycle is found."""

PLAUSIBLE = 2.0
"""A period is believed when it is within this factor of the template's."""

TWICE = 0.2
"""An interval so near to two periods (in parts of one) is taken for two, with events lost."""

FAR = 0.5
"""A sample beyond it is far out: x1 must have been so on the other side to pass 0 for good."""

SILENCE = 3.0
"""Periods without an event after which u counts as 0."""

CYCLES = 4
"""Periods after which a neuron alone is on its limit cycle."""


class Template(NamedTuple):
    """The limit cycle of a neuron alone: its tau, period, and recovery where x1 rises through 0."""

    tau: float
    period: float
    recovery: float


@lru_cache(maxsize=64)
def template(tau: float) -> Template:
    """Return the limit cycle for a time constant. Raises ValueError where there is none."""
    step = make_step(NEURON.rhs, NEURON.dimension)
    x: State = (2.0, 0.0)
    t, rises = 0.0, list[tuple[float, float]]()
    while len(rises) <= CYCLES:
        y = step(x, 0.0, 0.0, 0.0, (0.0, tau), FINE)
        if x[0] < 0.0 <= y[0]:
            part = x[0] / (x[0] - y[0])
            rises.append((t + part * FINE, x[1] + part * (y[1] - x[1])))
        x, t = y, t + FINE
        if t > CYCLES * (50.0 + 10.0 / tau):
            raise ValueError(f'a neuron with tau = {tau:g} does not oscillate')
    return Template(tau, rises[-1][0] - rises[-2][0], rises[-1][1])


class Spikes(NamedTuple):
    """u coded in spikes; ``tau`` is that of the receiver's generator."""

    tau: float

    @property
    def make(self) -> MakeCode:
        """What makes the code."""
        return make_spikes

    @property
    def make_copy(self) -> MakeCopy:
        """What makes a receiver."""
        return make_listener

    @property
    def unheard(self) -> State:
        """What a receiver has before the first event."""
        return SILENT

    @property
    def start(self) -> State:
        """Nothing was sent.

        Behind the common part: the last sample, the side on which it last was far out (-1, 1; 0 for
        none), and what the receiver has (see :func:`make_receiver`).
        """
        return (0.0, 0.0, 0.0, 0.0, 0.0, *SILENT)

    @property
    def held(self) -> bool:
        """Receivers draw lines, as for any signal."""
        return False

    def tuning(self, rate: float) -> Template:
        """Return the limit cycle."""
        return template(self.tau)

    def aged(self, message: float, span: float) -> float:
        """Return the message, whose event is by ``span`` longer ago."""
        return message + math.copysign(span, message)


NEVER = 1e9
"""How long ago something was that never was; model time."""

SILENT = (0.0, 0.0, 0.0, 0.0, NEVER, NEVER, NEVER)
"""A receiver before the first event."""


def make_receiver(compile: Compile = plain) -> Any:
    """Return ``receive(sign, ago, r, template, h) -> r``, a receiver one step of ``h`` on.

    Its state ``r``: x1 and x2 of its generator, its period, the sign of the last event, and how
    long ago it was, the last rise, and the last fall; x1 is u. ``sign`` is that of an event that
    was ``ago`` before the end of the step, 0 for none; all in model time.
    """
    move = make_step(NEURON.rhs, NEURON.dimension, compile)

    def run(x: State, span: float, template: Template, h: float) -> State:
        while span > h:
            x = move(x, 0.0, 0.0, 0.0, (0.0, template.tau), h)
            span -= h
        return move(x, 0.0, 0.0, 0.0, (0.0, template.tau), span)

    go = compile(run)

    def receive(sign: float, ago: float, r: State, template: Template, h: float) -> State:
        x, period, before = (r[0], r[1]), r[2], r[3]
        since, rise, fall = r[4] + h, r[5] + h, r[6] + h
        if sign != 0.0:
            seen = (rise if sign > 0.0 else fall) - ago
            if period == 0.0:
                period = template.period
            # Of an interval and its double that one is a period which is nearer to the template's.
            twice = abs(seen - 2.0 * period) < TWICE * period and seen * period > template.period**2
            lost = before == sign or twice
            if not lost and template.period < PLAUSIBLE * seen < PLAUSIBLE**2 * template.period:
                period = seen
            x = go((0.0, sign * template.recovery), ago * template.period / period, template, h)
            since, before = ago, sign
            rise, fall = (ago, fall) if sign > 0.0 else (rise, ago)
        elif before != 0.0:
            x = go(x, h * template.period / period, template, h)
            if since > SILENCE * period:
                x, before = (0.0, 0.0), 0.0
        return (x[0], x[1], period, before, since, rise, fall)

    return compile(receive)


def make_spikes(compile: Compile) -> Code:
    """Return the code of the sender, who also does what the receiver does."""
    receive = compile(make_receiver(compile))

    def code(y: float, c: State, tuning: Any, h: float) -> tuple[float, State]:
        count, last, side, r = c[2], c[3], c[4], c[5:]
        sign, ago = 0.0, 0.0
        if last < 0.0 <= y and side < 0.0 and r[3] <= 0.0:
            sign, ago = 1.0, h * y / (y - last)
        elif last > 0.0 >= y and side > 0.0 and r[3] >= 0.0:
            sign, ago = -1.0, h * y / (y - last)
        if abs(y) > FAR:
            side = math.copysign(1.0, y)
        message = sign * (1.0 + ago)  # rounded, as the receiver gets it
        r = receive(sign, abs(message) - 1.0, r, tuning, h)
        if sign != 0.0:
            return r[0], (1.0, message, count + 1.0, y, side) + r  # noqa: RUF005
        return r[0], (0.0, 0.0, count, y, side) + r  # noqa: RUF005

    return compile(code)  # type: ignore[no-any-return]


def make_listener(compile: Compile) -> Any:
    """Return the receiver with its state in a table, see :data:`..simulation.coding.MakeCopy`."""
    receive = compile(make_receiver(compile))

    def copy(
        samples: Any, i: int, stride: int, heard: float, message: float, tuning: Any, h: float
    ) -> None:
        j, s = i - 1, stride
        r = (
            samples[j], samples[j + s], samples[j + 2 * s], samples[j + 3 * s],
            samples[j + 4 * s], samples[j + 5 * s], samples[j + 6 * s],
        )  # fmt: skip
        sign = math.copysign(1.0, message) if heard != 0.0 else 0.0
        ago = abs(message) - 1.0 if heard != 0.0 else 0.0
        r = receive(sign, ago, r, tuning, h)
        for k in range(7):
            samples[i + k * s] = r[k]

    return compile(copy)


class Receiver:
    """What a node makes of the messages of u, step by step."""

    def __init__(self, tau: float) -> None:
        self._template, self._receive = template(tau), make_receiver()
        self._state: State = SILENT

    @property
    def silent(self) -> bool:
        """Whether there was no event yet, or none for long."""
        return self._state[3] == 0.0

    def stop(self) -> None:
        """Forget all events: u is 0 until the next."""
        self._state = SILENT

    def __call__(self, events: list[tuple[float, float]], h: float) -> float:
        """Return u after another step of ``h`` with the events of that step, in order.

        An event is (sign, how long before the end of the step it was, model time).
        """
        if not events:
            self._state = self._receive(0.0, 0.0, self._state, self._template, h)
        for i, (sign, ago) in enumerate(events):
            span = h if i == 0 else 0.0
            self._state = self._receive(sign, ago, self._state, self._template, span)
        return self._state[0]
