# SPDX-License-Identifier: Apache-2.0
"""A leaky membrane: C y' = gain (w - u) - y, a resistor and a capacitor instead of a neuron."""

from __future__ import annotations

import math
import sys

from eventreg_ros.nodes.own import ACTIVE, Drive, OwnBlock, Parameter, run


class Membrane(OwnBlock):
    """A first-order plant: it hears +w +v -u and publishes y, as every plant does by default."""

    kind = 'plant'
    parameters = (
        Parameter('gain', 'double', 1.0, 'output per constant input', settable=ACTIVE),
        Parameter('leak', 'double', 1.0, 'time constant, model time', low=0.0, open_low=True),
    )

    def start(self) -> float:
        """Start discharged."""
        self.y = 0.0
        return self.y

    def advance(self, inputs: Drive, h: float) -> float:
        """Charge towards gain * input, exactly for an input that is constant over the step."""
        target = self.values['gain'] * inputs(0.5)
        self.y += (1.0 - math.exp(-h / self.values['leak'])) * (target - self.y)
        return self.y


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run(Membrane)


if __name__ == '__main__':
    sys.exit(main())
