# SPDX-License-Identifier: Apache-2.0
"""What is judged: each plant, what disturbs it, what it is compared with, and by which numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from ..models.roles import STIMULUS_OUTPUT
from ..scenario import Scenario
from ..scenario.criteria import Criteria
from ..scenario.names import OTHER, OUTPUTS, full_name
from ..scenario.table import TIME_SCALE
from .learning import Learner, learners_of
from .signal import is_of, ordered, with_events

UNKNOWN = 'unknown'
"""What a run is called whose scenario is not known."""

PASSING = ('link', OTHER)
"""Kinds of nodes that hand on what they hear: what reaches them reaches the plant behind them."""

_W, _Y, _Y_R, _U = (OUTPUTS[kind] for kind in ('exosystem', 'plant', 'reference', 'controller'))


class JudgedPlant(NamedTuple):
    """One plant, by its signals.

    ``output`` is compared with ``reference``, None where there is none. ``disturbances`` are the
    outputs of the exosystems, ``controls`` those of the controllers and ``stimuli`` those of the
    stimuli that reach the plant. It plays the controls ``lead`` (model time) after they are made.
    """

    output: str
    reference: str | None = None
    disturbances: tuple[str, ...] = ()
    controls: tuple[str, ...] = ()
    stimuli: tuple[str, ...] = ()
    lead: float = 0.0

    @property
    def compared(self) -> tuple[str, ...]:
        """The signals whose events are matched: the output, and its reference if there is one."""
        return (self.output,) if self.reference is None else (self.output, self.reference)

    @property
    def needed(self) -> tuple[str, ...]:
        """The signals that must have been seen for a verdict."""
        return (*self.disturbances, *self.compared)


@dataclass(frozen=True)
class Subject:
    """A run as it is judged; ``time_scale`` in model time units per second.

    ``duration`` is how long the run was meant to take, in model time; None where nothing says it.
    """

    scenario: str = UNKNOWN
    time_scale: float = float(TIME_SCALE.default)
    plants: tuple[JudgedPlant, ...] = ()
    criteria: Criteria = field(default_factory=Criteria)
    duration: float | None = None
    learners: tuple[Learner, ...] = ()

    @property
    def needed(self) -> list[str]:
        """The signals that decide the verdict, in the order in which they are shown."""
        return ordered({name for plant in self.plants for name in plant.needed})


# By the scenario ----------------------------------------------------------------------------------


def subject_of(scenario: Scenario, signals: Collection[str] = ()) -> Subject:
    """Return what is judged of a run of ``scenario``.

    ``signals`` are those of the run: where the scenario has no exosystem, controller or reference
    of a plant, a signal that nobody in it publishes plays that part by its name; so it is with the
    plant itself. Raises
    ScenarioError when the nodes disagree on time_scale.
    """
    nodes = scenario.of_kind('plant')
    alone = len(nodes) == 1
    plants = tuple(_plant(scenario, node, frozenset(signals), alone) for node in nodes)
    return Subject(
        scenario.name,
        scenario.time_scale,
        plants or subject_by_name(signals).plants,
        scenario.criteria,
        _duration(scenario),
        learners_of(scenario),
    )


def _plant(scenario: Scenario, node: str, signals: Collection[str], alone: bool) -> JudgedPlant:
    """Return one plant; ``alone``, all exosystems and controllers of the scenario are its own."""
    sources = list(_sources(scenario, node, {node}))
    foreign = [signal for kind, signal in sources if kind is None and signal in signals]

    def of(kind: str, usual: str) -> tuple[str, ...]:
        found = [signal for k, signal in sources if k == kind]
        if alone:
            found += [str(scenario.output_of(other)) for other in scenario.of_kind(kind)]
        found = found or [s for s in foreign if is_of(usual, s.rpartition('/')[2])]
        return tuple(dict.fromkeys(found))

    return JudgedPlant(
        str(scenario.output_of(node)),
        _reference(scenario, node, signals),
        of('exosystem', _W),
        of('controller', _U),
        of('stimulus', STIMULUS_OUTPUT),
        scenario.nodes[node].get('lead', 0.0),
    )


def _sources(scenario: Scenario, node: str, seen: set[str]) -> Iterator[tuple[str | None, str]]:
    """Yield each signal that reaches ``node`` with the kind of its publisher, None: nobody."""
    publishers = scenario.publishers
    for signal in scenario.inputs_of(node):
        publisher = publishers.get(signal)
        kind = None if publisher is None else scenario.name_of(publisher).kind
        if publisher is None or kind not in PASSING:
            yield kind, signal
        elif publisher not in seen:
            yield from _sources(scenario, publisher, seen | {publisher})


def _reference(scenario: Scenario, node: str, signals: Collection[str]) -> str | None:
    """Return the signal that plant ``node`` is compared with: plant_left has reference_left."""
    name = scenario.name_of(node)
    sibling = name.sibling('reference')
    if sibling in scenario.nodes:
        return scenario.output_of(sibling)
    usual = full_name(name.namespace, _Y_R + name.suffix)
    return usual if usual in signals and usual not in scenario.publishers else None


def _duration(scenario: Scenario) -> float | None:
    """Return the model time that the scenario itself asks for: the steps of its clock."""
    clocks = [scenario.nodes[node] for node in scenario.of_kind('clock')]
    steps = max((int(values['steps']) for values in clocks), default=0)
    return steps * scenario.time_scale / scenario.rate if steps else None


# By name ------------------------------------------------------------------------------------------


def subject_by_name(
    signals: Collection[str],
    criteria: Criteria | None = None,
    *,
    scenario: str = UNKNOWN,
    time_scale: float = float(TIME_SCALE.default),
) -> Subject:
    """Return what is judged where no scenario says it, by the names of the signals that are there.

    y is judged against y_r; without a y, each y_SUFFIX against y_r_SUFFIX. All w and w_SUFFIX
    disturb each plant, all u and u_SUFFIX act on it.
    """
    names = [n for n in with_events(signals) if n.removesuffix('_link') not in set(signals) - {n}]
    disturbances, controls = (tuple(n for n in names if is_of(s, n)) for s in (_W, _U))
    outputs = [n for n in names if is_of(_Y, n) and not is_of(_Y_R, n)]
    plants = tuple(
        JudgedPlant(
            output,
            _named_reference(output, names),
            disturbances,
            controls,
            tuple(n for n in names if is_of(STIMULUS_OUTPUT, n)),
        )
        for output in ([_Y] if _Y in outputs else outputs)
    )
    return Subject(scenario, time_scale, plants, criteria or Criteria())


def _named_reference(output: str, names: Collection[str]) -> str | None:
    reference = _Y_R + output.removeprefix(_Y)
    return reference if reference in names else None
