# SPDX-License-Identifier: Apache-2.0
"""The scenario of what was identified: a controller for each generator."""

from __future__ import annotations

from collections.abc import Sequence

from .. import scenario as scenarios
from ..analysis.identification import Identification
from ..errors import EventregError
from ..scenario import Scenario
from ..scenario.derived import Given
from ..scenario.names import full_name, split

COMMON = ('time_scale', 'rate', 'hold', 'lead')
"""Parameters that a new node takes from the plant."""

SETTLE = 600.0
"""Model time that several controllers take to tell the generators apart."""


def with_identified(scenario: Scenario | None, found: Identification) -> Scenario:
    """Return the scenario with a controller for each generator that was found, with its tau.

    Controllers that are there keep all but tau, and get the tau next to theirs; those that are
    missing are added with the defaults. Without a scenario it is a shipped one, ``exact`` or
    ``two_generators``, whose exosystems get the taus as well, to stand for the generators. Raises
    EventregError where there are more controllers than generators, or not one plant.
    """
    taus = sorted((each.tau for each in found.all), reverse=True)
    base = scenario or scenarios.load('exact' if len(taus) == 1 else 'two_generators')
    extra: Given = {}
    outputs = _assign(base, 'controller', taus, extra)
    heard = {'inhibitory': outputs}
    if scenario is None:
        heard['excitatory'] = _assign(base, 'exosystem', taus, extra)
    _wire(base, heard, extra)
    changed = base.with_given(extra)
    if len(taus) > 1:
        changed = changed.with_criteria(settle=max(changed.criteria.settle, SETTLE))
    return changed


def _assign(base: Scenario, kind: str, taus: Sequence[float], extra: Given) -> list[str]:
    """Give the taus, the largest first, to the nodes of a kind, new ones if there are too few.

    Returns the outputs of the new ones, as the plant calls them.
    """
    there = sorted(base.of_kind(kind), key=lambda node: -float(base.nodes[node]['tau']))
    if len(there) > len(taus):
        raise EventregError(
            f'scenario {base.name} has {len(there)} nodes of kind {kind}, and {len(taus)} '
            f'generator{"s were" if len(taus) > 1 else " was"} identified; identify {len(there)}'
        )
    plant = _plant(base)
    home = base.name_of(plant).namespace
    common = {name: x for name, x in base.given[plant].items() if name in COMMON}
    numbered = [kind, *(f'{kind}_{i}' for i in range(2, len(taus) + len(there) + 2))]
    free = [name for each in numbered if (name := full_name(home, each)) not in base.nodes]
    added = free[: len(taus) - len(there)]
    for node, tau in zip([*there, *added], taus, strict=True):
        extra[node] = {**(common if node in added else {}), 'tau': tau}
    return [split(node).output for node in added]


def _wire(base: Scenario, heard: dict[str, list[str]], extra: Given) -> None:
    """Let the plant hear further outputs, and new controllers the plant."""
    plant = _plant(base)
    for key, outputs in heard.items():
        before = list(base.nodes[plant][key])
        if missing := [output for output in outputs if output not in before]:
            extra.setdefault(plant, {})[key] = before + missing
    own = str(base.nodes[plant]['output'])
    for node in extra:
        if node not in base.nodes and split(node).kind == 'controller' and own != 'y':
            extra[node]['excitatory'] = [own]


def _plant(base: Scenario) -> str:
    plants = base.of_kind('plant')
    if len(plants) != 1:
        raise EventregError(
            f'scenario {base.name} has {len(plants)} plants, and a controller belongs to one; '
            f'write the tau into the scenario by hand'
        )
    return plants[0]
