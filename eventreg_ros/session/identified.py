# SPDX-License-Identifier: Apache-2.0
"""A generator identified from a bag or a scenario: what ``eventreg identify`` does, for Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import scenario as scenarios
from ..analysis.identification import (
    Identification,
    Plant,
    identify_from_plant,
    identify_generator,
    identify_generators,
    identify_generators_from_plant,
)
from ..analysis.identification.recorded import THIN
from ..analysis.recorded import Analysis, scenario_of
from ..analysis.signal import Signal, Signals
from ..analysis.subject import JudgedPlant, Subject, subject_of
from ..bags.finding import Finding
from ..bags.reader import read_bag
from ..errors import EventregError
from ..scenario import Scenario
from ..scenario.inputs import signs_of
from ..simulation.trajectory import Array
from .compared import is_scenario
from .simulated import simulate


@dataclass(frozen=True)
class Observed:
    """The signals of a run, and what is known of it; times are in model time."""

    signals: Signals
    scenario: Scenario | None
    subject: Subject
    findings: tuple[Finding, ...] = ()

    def part(self, start: float = 0.0, until: float | None = None) -> Observed:
        """Return what was observed from ``start`` to ``until``."""
        end = np.inf if until is None else until
        kept = {}
        for name, (t, x) in self.signals.items():
            inside = (t >= start) & (t <= end)
            kept[name] = Signal(t[inside], x[inside])
        return replace(self, signals=kept)


def observe(
    source: Scenario | str | Path,
    scenario: Scenario | str | None = None,
    overrides: Sequence[str] = (),
    *,
    namespace: str | None = None,
    topics: Sequence[str] = (),
    time: str | None = None,
) -> Observed:
    """Return what ``source`` shows: a scenario, which is simulated as the nodes run it, or a bag.

    ``overrides`` (NODE.PARAM:=VALUE) are for the scenario, where it is given by name or path.
    A shipped name, or the path of a .yaml file, is a scenario; any other path a bag, to which
    ``scenario`` belongs instead of its own, and which is read with ``namespace``, ``topics`` and
    ``time`` as :func:`.bags.reader.read_bag` takes them. Raises EventregError.
    """
    if isinstance(source, str | Path) and is_scenario(source):
        source = scenarios.load(str(source), overrides)
    elif overrides:
        raise EventregError(
            f'-p {overrides[0]} changes a scenario before it is simulated, but {source} is a bag; '
            f'leave -p out'
        )
    if isinstance(source, Scenario):
        if scenario is not None or topics:
            raise EventregError(
                f'scenario and topics belong to a bag, but {source.name} is a scenario, which is '
                f'simulated; leave them out'
            )
        run = simulate(source, sampled=True)
        return Observed(run.over_time(), source, subject_of(source, run.signals))
    recording = read_bag(str(source), namespace, topics=topics, time=time)
    seen = Analysis(recording, scenario_of(recording, scenario, namespace))
    return Observed(seen.signals, seen.scenario, seen.subject, tuple(seen.findings))


def identify(
    observed: Observed, signal: str | None = None, generators: int = 1, affine: bool = False
) -> Identification:
    """Identify the generator behind ``signal``, an exosystem's or a plant's output.

    By default that is w, if it was seen (with several generators: if there is one w only), else y.
    Through a plant, the plant is that of the scenario; without a scenario it is fitted as well. Of
    several generators the slowest is returned, with the ``others``. Raises EventregError.
    """
    plant = _plant_of(observed, signal)
    seen = [name for name in plant.disturbances if len(observed.signals.get(name, ((),))[0])]
    if signal is None:
        signal = seen[0] if seen and (generators == 1 or len(seen) == 1) else plant.output
    t, x = _signal(observed, signal)
    if signal != plant.output:
        if generators == 1:
            return identify_generator(t, x, signal=signal, affine=affine)
        return _first(identify_generators(t, x, generators, signal=signal))
    own = _parameters(observed, signal)
    u, v = _given(observed, plant.controls, t), _given(observed, plant.stimuli, t)
    if generators == 1:
        return identify_from_plant(t, x, u, v, plant=own, signal=signal, affine=affine)
    return _first(identify_generators_from_plant(t, x, generators, u, v, plant=own, signal=signal))


def _first(found: Sequence[Identification]) -> Identification:
    return replace(found[0], others=tuple(found[1:]))


def _plant_of(observed: Observed, signal: str | None) -> JudgedPlant:
    """Return the plant whose output ``signal`` is, else the first one."""
    plants = observed.subject.plants
    named = [plant for plant in plants if plant.output == signal]
    return (*named, *plants, JudgedPlant('y', disturbances=('w',), controls=('u',)))[0]


def _signal(observed: Observed, name: str) -> Signal:
    found = observed.signals.get(name)
    if found is None or not len(found.t):
        have = ', '.join(n for n, s in observed.signals.items() if len(s.t)) or 'none'
        raise EventregError(
            f'there is no sample of {name}; the signals are {have}; name one of them, or give '
            f'its topic'
        )
    return found


def _parameters(observed: Observed, output: str) -> Plant | None:
    """Return the parameters of the plant with this output, None where nobody knows them."""
    scenario = observed.scenario
    node = None if scenario is None else scenario.publishers.get(output)
    if scenario is None or node is None or node in scenario.foreign:
        return None
    values = scenario.nodes[node]
    if values['model'] != 'neuron':
        raise EventregError(
            f'{output}: through a plant with model {values["model"]} nothing can be identified, '
            f'only through a neuron; record w'
        )
    return Plant(values['k'], values['tau'])


def _given(observed: Observed, names: Sequence[str], t: Array) -> Array | None:
    """Return the sum of signals at the times ``t`` where the plant hears them, or None of none.

    Not a number where one of them has a gap.
    """
    found = [name for name in names if len(observed.signals.get(name, ((),))[0])]
    if not found:
        return None
    parts = [_at(observed.signals[name], t, _lead(observed, name)) for name in found]
    return np.asarray(np.sum(parts, axis=0))


def _lead(observed: Observed, name: str) -> float:
    """Return the model time by which the plant plays a signal later than it is stamped."""
    scenario = observed.scenario
    if scenario is None:
        return 0.0
    plants = [scenario.nodes[node] for node in scenario.of_kind('plant')]
    leads = [float(plant['lead']) for plant in plants if (name, -1.0) in signs_of(plant)]
    return leads[0] if leads else 0.0


def _at(signal: Signal, t: Array, lead: float) -> Array:
    times = signal.t + lead
    found = np.interp(t, times, signal.x, np.nan, np.nan)
    if len(times) > 1:
        widths = np.diff(times)
        place = np.clip(np.searchsorted(times, t, 'right') - 1, 0, len(widths) - 1)
        found[widths[place] > max(THIN, 5.0 * float(np.median(widths)))] = np.nan
    return found
