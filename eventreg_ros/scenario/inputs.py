# SPDX-License-Identifier: Apache-2.0
"""What a block listens to, by its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import ParameterError


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
    found = {}
    for entry in values.get('lockstep_delays', ()):
        signal, colon, text = entry.rpartition(':')
        try:
            found[signal] = float(text) if colon else -1.0
        except ValueError:
            found[signal] = -1.0
        if not 0.0 <= found[signal] <= 1e6:
            raise ParameterError(
                f'lockstep_delays must be SIGNAL:T, T in model time >= 0 (u:2.0), got {entry!r}'
            )
    return found
