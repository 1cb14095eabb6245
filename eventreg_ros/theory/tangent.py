# SPDX-License-Identifier: Apache-2.0
"""The closed loop together with its variational equation."""

from __future__ import annotations

from operator import mul

from ..simulation.system import System


class Tangent(System):
    """The loop and its variational equation."""

    def flow(self, v: list[float], x: list[float], dx: list[float]) -> list[float]:
        """Return x' followed by dx' = J(v, x) dx.

        The outputs are linear, so :meth:`signals` maps a perturbation as it maps a state.
        """
        values, changes = self.signals(v, x), self.signals([0.0] * len(v), dx)
        slope: list[float] = []
        change: list[float] = []
        for part in self._parts:
            state = tuple(x[part.first : part.last])
            drive = self._drive(part, values)
            slope += part.model.rhs(state, drive, part.params)
            own = dx[part.first : part.last]
            own.append(self._drive(part, changes))
            if any(own):
                assert part.model.jacobian is not None
                rows = part.model.jacobian(state, drive, part.params)
                change += [sum(map(mul, row, own)) for row in rows]
            else:
                change += own[:-1]
        return slope + change
