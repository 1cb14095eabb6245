# SPDX-License-Identifier: Apache-2.0
"""What the nodes of a run warned of, and when."""

from __future__ import annotations

from typing import NamedTuple


class Noted(NamedTuple):
    """What a node warned of: when (nanoseconds of ROS time), which node, and what."""

    stamp: int
    node: str
    text: str
