# SPDX-License-Identifier: Apache-2.0
"""What the code of a model raises on the way: its arithmetic, turned into an error in words."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import EventregError

ARITHMETIC = (ArithmeticError, ValueError)
"""What Python's arithmetic raises: overflow, division by zero, math domain error."""


@contextmanager
def in_words() -> Iterator[None]:
    """Turn what a model's arithmetic raises into EventregError."""
    try:
        yield
    except EventregError:
        raise
    except ARITHMETIC as error:
        raise EventregError(
            f'a model cannot be evaluated: {type(error).__name__}: {error}; take a shorter '
            'duration or gentler parameters'
        ) from error
