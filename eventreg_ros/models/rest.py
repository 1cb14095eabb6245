# SPDX-License-Identifier: Apache-2.0
"""The rest of a membrane: where the currents through it balance."""

from __future__ import annotations

from collections.abc import Callable

STEPS = 4000
"""Into so many parts the range is cut: finer than two equilibria of a neuron are apart."""


def lowest_root(balance: Callable[[float], float], low: float, high: float) -> float:
    """Return the lowest v in (``low``, ``high``) at which ``balance`` falls through 0.

    Positive at ``low``, negative at ``high``. By bisection to the last bit.
    """
    width = (high - low) / STEPS
    crossing = next(i for i in range(1, STEPS + 1) if balance(low + i * width) <= 0.0)
    low, high = low + (crossing - 1) * width, low + crossing * width
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if balance(middle) > 0.0 else (low, middle)
    return low
