# SPDX-License-Identifier: Apache-2.0
"""Which generator made a recorded spike train; see :mod:`.identify`."""

from .identify import (
    identify_from_plant,
    identify_generator,
    identify_generators,
    identify_generators_from_plant,
)
from .layout import Plant
from .result import Identifiable, Identification, Interval

__all__ = [
    'Identifiable',
    'Identification',
    'Interval',
    'Plant',
    'identify_from_plant',
    'identify_generator',
    'identify_generators',
    'identify_generators_from_plant',
]
