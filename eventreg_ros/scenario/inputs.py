# SPDX-License-Identifier: Apache-2.0
"""What a block listens to, by its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import ParameterError

OSCILLATES = 0.001, 0.8
"""Bounds of tau of a generator that makes a signal of spikes; from 1 on it does not oscillate."""


def signs_of(values: Mapping[str, Any]) -> tuple[tuple[str, float], ...]:
    """Return the inputs of a block with their signs, in the order in which they are summed.

    A controller that predicts hears the plant's output and the plant's measured inputs; the plant
    that it has within takes the place of the reference.
    """
    keys = {'excitatory': 1.0, 'inhibitory': -1.0}
    if values.get('predict'):
        keys = {'excitatory': 1.0, 'plant_inputs': 1.0}
    return tuple((signal, sign) for key, sign in keys.items() for signal in values.get(key, ()))


def delays_of(values: Mapping[str, Any]) -> dict[str, float]:
    """Return how late the inputs of a block are in lockstep, in model time, by signal.

    Raises ParameterError for what is no SIGNAL:T.
    """
    return _numbers('lockstep_delays', values, 'T, T in model time >= 0 (u:2.0)', 0.0)


def templates_of(values: Mapping[str, Any]) -> dict[str, float]:
    """Return tau of the generator for each input of a block that comes as spikes, by signal.

    Raises ParameterError for what is no SIGNAL:TAU.
    """
    low, high = OSCILLATES
    return _numbers('spike_inputs', values, f'TAU, {low:g} <= TAU <= {high:g} (u:0.08)', low, high)


def _numbers(
    name: str, values: Mapping[str, Any], rule: str, low: float, high: float = 1e6
) -> dict[str, float]:
    found = {}
    for entry in values.get(name, ()):
        signal, _, text = entry.rpartition(':')
        try:
            number = float(text) if signal else -1.0
        except ValueError:
            number = -1.0
        if not low <= number <= high:
            raise ParameterError(f'{name} must be SIGNAL:{rule}, got {entry!r}')
        found[signal] = number
    return found
