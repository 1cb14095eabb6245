# SPDX-License-Identifier: Apache-2.0
"""The table of roles: who has which model, which signed inputs, which output, which defaults."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Role:
    """One of the four blocks of the paper's loop and what it is by default.

    ``excitatory`` and ``inhibitory`` are the signals with sigma = +1 and -1; ``x0`` is the initial
    state of the default model, in the paper's order.
    """

    name: str
    model: str
    k: float
    tau: float
    x0: tuple[float, ...]
    excitatory: tuple[str, ...]
    inhibitory: tuple[str, ...]
    output: str


ROLES = {
    role.name: role
    for role in (
        Role('exosystem', 'oscillator', 2.0, 1 / 12, (1.0, 0.0, -1.0, 0.0),
             (), (), 'w'),
        Role('plant', 'neuron', 1.0, 1 / 11, (0.0, 0.0),
             ('w', 'v'), ('u',), 'y'),
        Role('controller', 'oscillator', 2.0, 1 / 12, (0.5, 0.0, -0.5, 0.0),
             ('y',), ('y_r',), 'u'),
        Role('reference', 'neuron', 1.0, 1 / 11, (0.0, 0.0),
             ('v',), (), 'y_r'),
    )
}  # fmt: skip

STIMULUS_OUTPUT = 'v'
SIGNALS = ('w', 'v', 'y', 'y_r', 'u')
"""The signals of the paper's loop, in the order in which tables and plots show them."""
