# SPDX-License-Identifier: Apache-2.0
"""How an output travels when not every sample does: what receivers make of it, and when they hear.

A coder stands behind a block's output. It is given every sample and gives what receivers make of
the messages so far, which is what counts: the simulated table of samples holds it, in lockstep it
is published, and in real time only the messages are.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from ..models import State
from .step import Compile, plain

Code = Callable[[float, State, Any, float], tuple[float, State]]
"""``code(y, c, tuning, h) -> (value, c)``: the next sample, and the coder's state.

``c`` begins with whether a message goes out (0 or 1), what is in it, and how many there were.
"""

MakeCode = Callable[[Compile], Code]


NEVER = 1e18
"""For how many steps nothing was sent by one who never sent anything."""


MakeCopy = Callable[[Compile], Any]
"""Makes ``copy(samples, i, stride, heard, message, tuning, h)``, what a receiver does in a step.

What it remembers is in rows of a table that are ``stride`` apart; the first is the signal as it
knows it. ``i`` is the place of the step's end in the first, i - 1 that of the beginning. ``heard``
is 1 when ``message`` came.
"""


class Copy(NamedTuple):
    """The first row of a receiver, and the row of its link in the table of what is lost."""

    row: int
    lost: int


class Coding(Protocol):
    """What a block whose output is coded adds to its spec; hashable."""

    @property
    def make(self) -> MakeCode:
        """What makes the code; the same for all settings."""

    @property
    def make_copy(self) -> MakeCopy:
        """What makes a receiver, for links that lose messages."""

    @property
    def unheard(self) -> State:
        """What a receiver remembers before the first message; it takes the signal for the first."""

    @property
    def start(self) -> State:
        """The coder's state before the first sample."""

    @property
    def held(self) -> bool:
        """Whether receivers are to hold a sample until the next, and draw no line."""

    def tuning(self, rate: float) -> Any:
        """Return what may change from run to run, as the code takes it; ``rate`` is in steps/s."""

    def aged(self, message: float, span: float) -> float:
        """Return the message of a sample that was made ``span`` of model time ago."""


class Coder:
    """A coder as a node runs it; ``h`` is the length of a step in model time."""

    def __init__(self, coding: Coding, rate: float, h: float) -> None:
        self.coding, self.h = coding, h
        self._code, self._tuning = coding.make(plain), coding.tuning(rate)
        self.state = coding.start
        self._unsent: list[tuple[float, float]] = []

    def __call__(self, y: float) -> float:
        """Return what receivers make of the output, which has come to its next sample ``y``."""
        value, self.state = self._code(y, self.state, self._tuning, self.h)
        self._unsent = [(message, span + self.h) for message, span in self._unsent]
        if self.state[0]:
            self._unsent.append((self.state[1], 0.0))
        return value

    def forget(self) -> None:
        """Begin anew."""
        self.state = self.coding.start
        self._unsent.clear()

    def take(self) -> list[float]:
        """Return the messages that are to be sent, once."""
        found = [self.coding.aged(message, span) for message, span in self._unsent]
        self._unsent.clear()
        return found


class Delta(NamedTuple):
    """Send on delta: what differs from the last one sent by ``delta`` is sent, and every ``beat``.

    ``beat`` is in seconds. Receivers hold the last one.
    """

    delta: float
    beat: float

    @property
    def make(self) -> MakeCode:
        """What makes the code."""
        return make_delta

    @property
    def make_copy(self) -> MakeCopy:
        """What makes a receiver."""
        return make_held

    @property
    def unheard(self) -> State:
        """0, which is held."""
        return (0.0,)

    @property
    def start(self) -> State:
        """Nothing was sent; behind the common part, for how many steps nothing has been."""
        return (0.0, 0.0, 0.0, NEVER)

    @property
    def held(self) -> bool:
        """Receivers hold."""
        return True

    def tuning(self, rate: float) -> tuple[float, float]:
        """Return delta, and the most steps between two messages."""
        return self.delta, max(float(int(self.beat * rate + 1e-9)), 1.0)

    def aged(self, message: float, span: float) -> float:
        """Return the message: a value is a value."""
        return message


def make_delta(compile: Compile) -> Code:
    """Return the code of send on delta (Miskowicz, Sensors 6, 2006)."""

    def code(y: float, c: State, tuning: Any, h: float) -> tuple[float, State]:
        sent, count, since = c[1], c[2], c[3] + 1.0
        if abs(y - sent) >= tuning[0] or since >= tuning[1]:
            return y, (1.0, y, count + 1.0, 0.0)
        return sent, (0.0, sent, count, since)

    return compile(code)  # type: ignore[no-any-return]


def make_held(compile: Compile) -> Any:
    """Return the receiver of what is sent on delta: it holds the last one that came."""

    def copy(
        samples: Any, i: int, stride: int, heard: float, message: float, tuning: Any, h: float
    ) -> None:
        samples[i] = message if heard != 0.0 else samples[i - 1]

    return compile(copy)


@lru_cache
def make_deaf(unheard: State) -> MakeCopy:
    """Return what makes the receiver of a block that is off, which knows it and forgets all."""

    def make(compile: Compile) -> Any:
        def copy(
            samples: Any, i: int, stride: int, heard: float, message: float, tuning: Any, h: float
        ) -> None:
            for k in range(len(unheard)):
                samples[i + k * stride] = unheard[k]

        return compile(copy)

    return make


def make_mute(compile: Compile) -> Code:
    """Return the code of a block that is off: nothing is sent, and receivers know that it is 0."""

    def code(y: float, c: State, tuning: Any, h: float) -> tuple[float, State]:
        return 0.0, c

    return compile(code)  # type: ignore[no-any-return]
