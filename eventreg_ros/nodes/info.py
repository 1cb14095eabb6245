# SPDX-License-Identifier: Apache-2.0
"""What the RMW says of a message beside its content."""

from __future__ import annotations

import time
from typing import Any


def number_of(info: dict[str, Any]) -> int | None:
    """Return the number of a sample, from 0, by its writer's count; None if the RMW has none."""
    number = info['publication_sequence_number']
    return None if number is None else int(number) - 1


def received_at(info: dict[str, Any]) -> int:
    """Return when a sample arrived, in nanoseconds of the system clock; now if unknown."""
    return int(info['received_timestamp']) or time.time_ns()
