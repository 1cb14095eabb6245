"""Signals that did not travel sample by sample, as their receivers knew them."""

from __future__ import annotations

import math
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
"""Messages no further apart than so many steps are samples: of a simulation, or of lockstep."""


def as_received(signals: Signals, scenario: Scenario) -> Signals:
    """Return ``signals`` over model time, those that were coded as their receivers knew them.

    That is at every step between the messages: held, or made of spikes.
    """
    found = dict(signals)
    for name, (coding, h, time_scale) in codings(scenario).items():
        signal = signals.get(name)
        if signal is None or len(signal.t) < 2 or np.median(np.diff(signal.t)) < DENSE * h:
            continue
        if isinstance(coding, Delta):
            found[name] = held(signal, PATIENCE * coding.beat * time_scale, h)
        else:
            found[name] = made_of_spikes(signal, coding.tau, h)
    return found


class Coded(NamedTuple):
    """How a signal is coded; ``h`` is a step in model time, ``time_scale`` of which is a second."""

    coding: Delta | Spikes
    h: float
    time_scale: float


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


def held(signal: Signal, longest: float, h: float) -> Signal:
    """Return ``signal`` held between its samples, every ``h``, where they are near enough.

    ``longest`` is the largest interval that is no gap; all in model time.
    """
    apart = np.diff(signal.t, append=signal.t[-1])
    steps = np.where(apart <= longest, np.ceil(apart / h - 1e-6), 1.0).astype(np.int64)
    steps = np.maximum(steps, 1)
    first = np.repeat(np.cumsum(steps) - steps, steps)
    t = np.repeat(signal.t, steps) + (np.arange(steps.sum()) - first) * h
    return Signal(t, np.repeat(signal.x, steps))


def made_of_spikes(signal: Signal, tau: float, h: float) -> Signal:
    """Return what a receiver makes of spikes, every ``h`` of model time from the first one on."""
    receiver = Receiver(tau)
    messages = list(zip(signal.t.tolist(), signal.x.tolist(), strict=True))[::-1]
    count = int((signal.t[-1] - signal.t[0]) / h) + 1
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
