# SPDX-License-Identifier: Apache-2.0
"""What a reader returns: signals, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..models.roles import SIGNALS
from .changes import Changed
from .channel import Stamps
from .finding import Finding
from .messages import Values
from .times import Time


class Stamped(NamedTuple):
    """A signal, both of shape (n,): stamps in nanoseconds of ROS time, ascending, and values."""

    stamps: Stamps
    values: Values


@dataclass(frozen=True, repr=False)
class Recording:
    """The signals of a bag, and what is wrong with it.

    ``scenario`` is the parameter file's text that the recorder stored, or None; ``name`` what it is
    called. ``time`` says which time the stamps are, ``topics`` where each signal comes from.
    """

    signals: dict[str, Stamped]
    findings: tuple[Finding, ...]
    scenario: str | None
    name: str | None
    time: Time
    topics: dict[str, str]
    lead: int = 0
    """Nanoseconds by which the run began before the first stamp: by samples without a good one."""
    changes: tuple[Changed, ...] = ()
    """Parameters that were set, and nodes that were switched, while it was recorded."""

    def __repr__(self) -> str:
        signals = ', '.join(f'{name} {len(s.stamps)}' for name, s in self.signals.items())
        return f'<Recording of {signals} samples; {len(self.findings)} findings>'

    @property
    def start(self) -> int:
        """The stamp of the run's first sample; where there are ours, others do not count."""
        found = self.signals.items()
        return earliest({name: int(s.stamps[0]) for name, s in found if len(s.stamps)}) - self.lead

    def in_model_time(self, time_scale: float) -> dict[str, tuple[Values, Values]]:
        """Return the signals over model time, t = 0 at the first sample of the run."""
        return {
            name: ((stamps - self.start).astype(np.float64) * time_scale / 1e9, values)
            for name, (stamps, values) in self.signals.items()
        }


def earliest(stamps: Mapping[str, int]) -> int:
    """Return the earliest of stamps by signal: of the paper's, of all where there are none."""
    return min((stamps[name] for name in _ours(stamps)), default=0)


def beginning(first: Mapping[str, int], begins: Mapping[str, int]) -> int:
    """Return when a run began: at the ``first`` stamp that is there, if one began with it.

    Otherwise, where all signals lost samples at their beginning, where the earliest ``begins``: a
    file may hold bad stamps of a few samples first, wherever these belong.
    """
    whole = any(begins[name] == first[name] for name in _ours(first))
    return earliest(first if whole else begins)


def _ours(stamps: Mapping[str, int]) -> list[str]:
    return [name for name in stamps if name in SIGNALS] or list(stamps)
