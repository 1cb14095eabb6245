# SPDX-License-Identifier: Apache-2.0
"""Signals that did not travel sample by sample, as their receivers knew them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..control.spikes import Receiver, Spikes
from ..scenario import Scenario
from ..scenario.blocks import coding_of
from ..simulation.coding import Delta
from .signal import Signal, Signals

PATIENCE = 1.5
"""What was sent on delta counts as known for so many times the longest silence that is meant."""

DENSE = 2.0
"""Spikes no further apart than so many steps are samples: of a simulation, or of lockstep."""


class Coded(NamedTuple):
    """How a signal is coded; ``h`` is a step in model time, ``time_scale`` of which is a second."""

    coding: Delta | Spikes
    h: float
    time_scale: float

    @property
    def patience(self) -> float:
        """Seconds between two messages after which one is missing."""
        return PATIENCE * self.coding.beat if isinstance(self.coding, Delta) else math.inf

    @property
    def longest(self) -> float:
        """The same in model time; 0 for spikes, which a receiver does not hold."""
        return self.patience * self.time_scale if isinstance(self.coding, Delta) else 0.0


def codings(scenario: Scenario) -> dict[str, Coded]:
    """Return the signals that are coded, those behind links too."""
    found = {}
    behind = {scenario.inputs_of(link)[0]: link for link in scenario.of_kind('link')}
    for node, values in scenario.nodes.items():
        coding, signal = coding_of(values), scenario.output_of(node)
        while coding is not None and signal is not None:
            assert isinstance(coding, Delta | Spikes)
            scale = values['time_scale']
            found[signal] = Coded(coding, scale / values['rate'], scale)
            signal = scenario.output_of(behind[signal]) if signal in behind else None
    return found


def as_received(signals: Signals, coded: Mapping[str, Coded]) -> Signals:
    """Return ``signals`` over model time, those that were coded as their receivers knew them.

    That is at every step between the messages, to the end of the recording: held, or made of
    spikes.
    """
    found = dict(signals)
    end = max((float(s.t[-1]) for s in signals.values() if len(s.t)), default=0.0)
    for name, each in coded.items():
        signal = signals.get(name)
        if signal is None or not len(signal.t):
            continue
        if isinstance(each.coding, Delta):
            found[name] = held(signal, each.longest, each.h, end)
        elif len(signal.t) == 1 or np.median(np.diff(signal.t)) >= DENSE * each.h:
            found[name] = made_of_spikes(signal, each.coding.tau, each.h, end)
    return found


def held(signal: Signal, longest: float, h: float, end: float) -> Signal:
    """Return ``signal`` held between its samples and to the ``end``, every ``h``.

    But not over an interval of more than ``longest``, in which something is missing; all in model
    time.
    """
    apart = np.diff(signal.t, append=max(end, float(signal.t[-1])))
    steps = np.where(apart <= longest, np.ceil(apart / h - 0.5), 1.0).astype(np.int64)
    steps = np.maximum(steps, 1)
    first = np.repeat(np.cumsum(steps) - steps, steps)
    t = np.repeat(signal.t, steps) + (np.arange(steps.sum()) - first) * h
    return Signal(t, np.repeat(signal.x, steps))


def made_of_spikes(signal: Signal, tau: float, h: float, end: float) -> Signal:
    """Return what a receiver makes of spikes, every ``h`` from the first one to the ``end``."""
    receiver = Receiver(tau)
    messages = list(zip(signal.t.tolist(), signal.x.tolist(), strict=True))[::-1]
    count = int((end - signal.t[0]) / h + 1e-6) + 1
    t = signal.t[0] + h * np.arange(count)
    x = np.zeros(count)
    for k, now in enumerate(t.tolist()):
        events = []
        while messages and messages[-1][0] <= now + 1e-9:
            sent, message = messages.pop()
            if message == 0.0:
                receiver.stop()
            else:
                ago = now - sent + abs(message) - 1.0
                events.append((math.copysign(1.0, message), max(ago, 0.0)))
        x[k] = receiver(events, h)
    return Signal(t, x)
