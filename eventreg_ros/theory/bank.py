# SPDX-License-Identifier: Apache-2.0
"""A bank of controllers for several generators: which generator has its copy in which controller.

The plant hears the sum of all w_i less the sum of all u_j. If every generator has its copy in a
controller of its own, y = 0 is a steady state: each u_j is its w_i. Nothing more is proven; that
the bank goes there is measured by the exponent.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..control.adaptive import fixed
from ..simulation.block import BlockSpec
from .certificates import Certificate, Number
from .internal_model import Copy, compare, embeds
from .lemmas import Status

MEANING = 'largest relative difference of k and tau from the copy, or from the nearest controller'


def bank(controllers: Sequence[BlockSpec], exosystems: Sequence[BlockSpec]) -> list[Certificate]:
    """Return one certificate per generator: its copy, or that it has none.

    Each controller serves one generator; exact copies are assigned first. Without any controller
    no generator has a copy.
    """
    if not controllers:
        return [_without(e) for e in exosystems]
    alone = [fixed(c) for c in controllers]
    copies = assign(alone, exosystems)
    learners = [c.name for c in controllers if c.model.learned and c.name not in copies.values()]
    return [_certificate(e, copies.get(e.name), alone, learners) for e in exosystems]


def _without(e: BlockSpec) -> Certificate:
    text = 'There is no controller, so nothing has its copy: y cannot vanish while it goes on.'
    numbers: dict[str, Number] = {'copy_in': None, 'nearest': None, 'exact_copy': False}
    return Certificate(e.name, 'internal_model', 'fail', None, MEANING, text, numbers)


def assign(controllers: Sequence[BlockSpec], exosystems: Sequence[BlockSpec]) -> dict[str, str]:
    """Return the controller of each generator that has one, by name, as many as there can be."""
    taken: dict[str, str] = {}
    for exact in (True, False):
        for e in exosystems:
            for c in controllers:
                free = e.name not in taken and c.name not in taken.values()
                if free and _embeds(c, e) == 'pass' and (not exact or _copy(c, e).exact):
                    taken[e.name] = c.name
    return taken


def _embeds(c: BlockSpec, e: BlockSpec) -> Status:
    return embeds(c.model, c.params, e.model, e.params)


def _copy(c: BlockSpec, e: BlockSpec) -> Copy:
    return compare(c.model, c.params, e.model, e.params)


def _distance(c: BlockSpec, e: BlockSpec) -> float:
    """Return how far a controller is from a generator: by tau first of all, which must agree."""
    copy = _copy(c, e)
    if copy.exact:
        return 0.0
    return float('inf') if copy.tau is None else abs(copy.tau)


def _certificate(
    e: BlockSpec, name: str | None, controllers: Sequence[BlockSpec], learners: Sequence[str]
) -> Certificate:
    by_name = {c.name: c for c in controllers}
    nearest = by_name[name] if name else min(controllers, key=lambda c: _distance(c, e))
    copy = _copy(nearest, e)
    status: Status = 'pass' if name else _worst(controllers, e)
    known = [abs(value) for value in (copy.k, copy.tau) if value is not None]
    value = max(known) if known else 0.0 if copy.exact else None
    numbers: dict[str, Number] = {'copy_in': name, 'nearest': nearest.name}
    numbers |= {'exact_copy': copy.exact, 'k': copy.k, 'tau': copy.tau}
    if name:
        text = f'Its copy is in {name}' + ('.' if copy.exact else ': tau agrees, and k cancels.')
    elif learners:
        status = 'none'
        text = (
            f'No controller has its copy, but {" and ".join(learners)} may learn to be one. That '
            'each of a bank finds a generator of its own is measured and not proven.'
        )
    elif status == 'fail':
        text = f'No controller left has its copy (the nearest is {nearest.name}): y cannot vanish.'
    else:
        text = 'Whether a controller can produce it at y = 0 does not follow from the lemmas here.'
    return Certificate(e.name, 'internal_model', status, value, MEANING, text, numbers)


def _worst(controllers: Sequence[BlockSpec], e: BlockSpec) -> Status:
    """Return fail when it is sure that no controller is left that can produce the generator."""
    unsure = any(_embeds(c, e) == 'none' for c in controllers)
    return 'none' if unsure else 'fail'
