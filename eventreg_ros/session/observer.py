# SPDX-License-Identifier: Apache-2.0
"""Who hears what happens in a run."""

from __future__ import annotations

from collections.abc import Mapping


class Observer:
    """Hears what happens in a run; this one keeps silent."""

    def began(self, line: str) -> None:
        """Take the nodes and the domain, in words, before they are started."""

    def warned(self, line: str) -> None:
        """Take what a person should know while the run goes on."""

    def progressed(self, elapsed: float, counts: Mapping[str, int], last: bool = False) -> None:
        """Take the seconds that have passed of the run, and the events counted so far."""
