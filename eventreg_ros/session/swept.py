# SPDX-License-Identifier: Apache-2.0
"""A sweep as the library returns it: it draws itself."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from ..robustness import sweep as module

if TYPE_CHECKING:
    from ..plots.run_plot import Figure


@dataclass(frozen=True, repr=False)
class Sweep(module.Sweep):
    """What came of a sweep; see :class:`.robustness.sweep.Sweep`."""

    @classmethod
    def of(cls, sweep: module.Sweep) -> Sweep:
        """Return the same sweep, which can draw itself."""
        return cls(*(getattr(sweep, each.name) for each in fields(sweep)))

    def plot(self) -> Figure:
        """Return a matplotlib figure, which a notebook shows; ``savefig('sweep.pdf')`` writes it.

        A grid of two parameters gives maps of verdict, wrong events and residual, one of one
        parameter a line, random sets histograms. Raises EventregError for a grid of more.
        """
        from ..plots.sweep_plot import draw_result

        return draw_result(self)  # type: ignore[no-any-return]
