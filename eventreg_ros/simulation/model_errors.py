# SPDX-License-Identifier: Apache-2.0
"""What the code of a model raises in a simulation, as an error in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from ..errors import EventregError, ModelError, described
from ..models import Model

ARITHMETIC = (ArithmeticError, ValueError)
"""What Python's arithmetic raises: overflow, division by zero, math domain error."""

ANYTHING = (Exception, SystemExit)
"""What may come of code that we do not know. sys.exit(0) there must not end as a verdict."""


def failed(error: BaseException, models: Sequence[Model]) -> str | None:
    """Say which of ``models`` failed, how, and what to do; None for another fault.

    Our models fail by arithmetic, those of other packages in any way, also by what they return.
    """
    others = [repr(model.name) for model in models if not model.is_ours]
    if isinstance(error, EventregError | MemoryError) or not isinstance(error, ANYTHING):
        return None
    words = f'cannot be evaluated: {described(error)}'
    if others:
        who = f'model {" or ".join(dict.fromkeys(others))}'
        return f'{who} {words}; fix the package that offers it, or take gentler parameters'
    if models and isinstance(error, ARITHMETIC):
        return f'a model {words}; take a shorter duration or gentler parameters'
    return None


@contextmanager
def in_words(models: Sequence[Model]) -> Iterator[None]:
    """Turn what the code of ``models`` raises into EventregError, ModelError for another's code."""
    try:
        yield
    except ANYTHING as error:
        words = failed(error, models)
        if words is None:
            raise
        foreign = any(not model.is_ours for model in models)
        raise (ModelError if foreign else EventregError)(words) from error
