# SPDX-License-Identifier: Apache-2.0
"""A model whose output is cut off at a magnitude; its state is not."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from .model import Model, Params, State


@lru_cache(maxsize=64)
def limited(model: Model, limit: float) -> Model:
    """Return ``model`` with its output kept between -``limit`` and ``limit`` (> 0)."""
    output = model.output

    def cut(x: State, drive: float, p: Params) -> float:
        y = output(x, drive, p)
        if y > limit:
            return limit
        return -limit if y < -limit else y

    return replace(model, output=cut, pointwise=True)
