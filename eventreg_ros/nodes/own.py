# SPDX-License-Identifier: Apache-2.0
"""Blocks of one's own: a plant, a controller, a sensor of about twenty lines.

    class Tank(OwnBlock):
        kind = 'plant'
        parameters = (Parameter('leak', 'double', 0.1, 'outflow', low=0.0, settable=ACTIVE),)

        def start(self) -> float:
            self.level = 0.0
            return self.level

        def advance(self, inputs: Drive, h: float) -> float:
            self.level += h * (inputs(0.5) - self.values['leak'] * self.level)
            return self.level

    if __name__ == '__main__':
        sys.exit(run(Tank))

Pace, inputs, watchdog, diagnostics, parameters and lifecycle come from here, in real time and in
lockstep. A scenario names such a node by the parameters ``package`` and ``executable``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from ..errors import described
from ..scenario.parameter import ACTIVE, INACTIVE, UNCONFIGURED, Parameter
from ..scenario.parameters import parameters_of
from ..simulation.hold import drive
from .managed import FaultError
from .pace import Lines
from .ros import run_node
from .signal import SignalNode

__all__ = ['ACTIVE', 'INACTIVE', 'UNCONFIGURED', 'Drive', 'OwnBlock', 'Parameter', 'run']


class Drive:
    """The inputs over one step: their signed sum, and each alone, at any part of the step."""

    def __init__(self, signs: tuple[tuple[str, float], ...], lines: Lines) -> None:
        self._signs, self._lines = signs, lines

    def __call__(self, theta: float = 0.0) -> float:
        """Return the signed sum of the inputs at ``theta``: 0 is the step's start, 1 its end."""
        return drive([sign for _, sign in self._signs], *self._lines, theta)

    def of(self, signal: str, theta: float = 0.0) -> float:
        """Return one input, without its sign. Raises KeyError when it is not listened to."""
        i = [name for name, _ in self._signs].index(signal) if signal in dict(self._signs) else None
        if i is None:
            raise KeyError(signal)
        return self._lines.base[i] + theta * self._lines.slope[i]


class OwnBlock(SignalNode):
    """A block whose step is yours: fill in ``start`` and ``advance``.

    ``kind`` says whose default signals it has: exosystem, plant, controller, reference, or block
    (none: give ``output``, and ``excitatory`` or ``inhibitory``). ``parameters`` are further ROS
    parameters; their checked values are in ``self.values``, beside those of every block (rate,
    time_scale, hold, ...). A value that is not finite, or an exception,
    puts the node in its fault state with a message.
    """

    kind: str = 'plant'
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(type(self).kind, **kwargs)

    @classmethod
    def all_parameters(cls) -> list[Parameter]:
        """Return all parameters with their defaults: the further ones, and those of every block."""
        return [*cls.parameters, *parameters_of(cls.kind, {'package': 'own'}).values()]

    def rows(self, given: Mapping[str, Any]) -> dict[str, Parameter]:
        """Return the parameters of a block without a model, and the further ones."""
        common = parameters_of(self.label, {'package': 'own'})
        return common | {parameter.name: parameter for parameter in self.parameters}

    def start(self) -> float:
        """Set the initial state and return the output there, sample 0."""
        raise NotImplementedError

    def advance(self, inputs: Drive, h: float) -> float:
        """Take one step of length ``h`` (model time) and return the output at its end."""
        raise NotImplementedError

    def initial(self) -> float:
        """Return sample 0."""
        return self._guarded('start', self.start)

    def step(self, n: int, lines: Lines) -> float:
        """Return sample ``n`` + 1."""
        return self._guarded('advance', self.advance, Drive(self.signs, lines), self.h)

    def _guarded(self, name: str, call: Callable[..., float], *arguments: object) -> float:
        """Call code of the user's. Raises FaultError with what it raises."""
        try:
            return float(call(*arguments))
        except Exception as error:
            raise FaultError(
                f'{type(self).__name__}.{name} failed at step {self.n + 1}: {described(error)}'
            ) from error


def run(block: type[OwnBlock], args: list[str] | None = None) -> int:
    """Run a node of this class until SIGINT or SIGTERM; return the exit code of its process."""
    return run_node(block, args)
