# SPDX-License-Identifier: Apache-2.0
"""How much delay, loss and jitter a loop tolerates: the most at which it still rejects.

The question is put to sampled simulations (:mod:`.trial`) with each hold in turn. Where an
impairment is random, every one of several seeds must be rejected.

Bisection assumes that a loop that tolerates a delay tolerates shorter ones. That is no law, so a
coarse scan over the whole range comes first; between the scan's first failure and the value before
it, bisection finds the edge. What lies between two values of the scan is not looked at otherwise;
values of the scan beyond the first failure that are rejected again are reported, not counted.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..errors import EventregError
from ..scenario import Scenario
from ..simulation.hold import HOLDS
from ..simulation.impairment import PERFECT, Impairment
from ..simulation.loop import Loop
from ..simulation.trajectory import Array
from .evaluator import Evaluator, Setting, prepare
from .scans import AHEAD, FARTHEST_DELAY, finished, further, scan_of, search_on, searching

KINDS = ('delay', 'loss', 'jitter')

FINE = 0.01
"""Length of a step in the search for the delay (model time), unless the scenario's is shorter."""

FOLLOWS = 'delay'
"""The lead of a loop that predicts, where it is set to the delay that is tried."""

Progress = Callable[[int, int, str], None]
"""Takes how many of how many are done, and a few words on what was tried last."""


def _silent(done: int, count: int, words: str) -> None:
    """Show no progress."""


@dataclass(frozen=True)
class Limit:
    """How much of one impairment a loop tolerates: delay and jitter in model time, loss a share.

    ``largest``: the most at which all runs are rejected; None: not rejected at 0 either.
    ``fails_at``: the least beyond it that was seen to fail; None: nothing failed up to
    ``scanned_to``. ``rejected_again``: values of the scan beyond that one which do not fail.
    ``h`` (model time) is the length of a step at ``rate``, ``resolution`` in the unit of the kind.
    ``on`` is the one signal whose links are impaired, or some, None where all are. ``lead`` is that
    of a loop that predicts, :data:`FOLLOWS` where it is set to the delay; None for others.
    """

    kind: str
    hold: str
    on: str | tuple[str, ...] | None
    rate: float
    h: float
    resolution: float
    largest: float | None
    fails_at: float | None
    scanned_to: float
    rejected_again: tuple[float, ...]
    lead: float | str | None = None

    @property
    def name(self) -> str:
        """What was varied, in words."""
        if isinstance(self.on, tuple) and isinstance(self.lead, float):
            return f'at lead {self.lead:g}'
        return named(self.kind, self.on)


def named(kind: str, on: str | tuple[str, ...] | None) -> str:
    """Return what is varied, in words: ``kind``, or that of the signal ``on`` alone."""
    return f'{kind} of {on}' if isinstance(on, str) else kind


def margins(
    scenario: Scenario, setting: Setting | None = None, progress: Progress = _silent
) -> list[Limit]:
    """Return the limits of a scenario: for each hold that of delay, of loss and of jitter.

    These are with the same on every link. After them come that of the delay at the scenario's own
    rate, where it was searched at a finer one, and those of the delay of each signal alone. Of a
    loop that predicts, the first is with the lead set to the delay, and that with the scenario's
    lead comes next. Raises EventregError when the scenario cannot be simulated or its verdict is
    undecided.
    """
    setting = setting or Setting.of(scenario)
    linked = _need_verdict(scenario, setting).linked
    if scenario.loop.predicts:
        return _search_all(_of_predicting(scenario, setting, linked), progress)
    fine, own = (rate_for(kind, scenario, setting) for kind in ('delay', 'loss'))
    cases: list[tuple[str, float, str | None]] = [
        (kind, rate_for(kind, scenario, setting), None) for kind in KINDS
    ]
    cases += [('delay', own, None)] if own != fine else []
    cases += [('delay', fine, signal) for signal in linked]
    of = cache(lambda hold, rate: Evaluator(scenario, hold, rate, setting))
    searches = [
        (of(hold, rate).on_only(signal), kind) for hold in HOLDS for kind, rate, signal in cases
    ]
    return _search_all(searches, progress)


def _of_predicting(
    scenario: Scenario, setting: Setting, linked: Sequence[str]
) -> list[tuple[Evaluator, str]]:
    """Return what is searched of a loop that predicts, all at its own rate: its delays are long.

    Late are the links to the controller and from it, not those of the disturbance.
    """
    rate = rate_for('loss', scenario, setting)
    far = tuple(to_and_fro(scenario.loop))
    cases: list[tuple[str, str | tuple[str, ...] | None, bool]] = [('delay', far, True)]
    cases += [('loss', None, False), ('jitter', None, False), ('delay', far, False)]
    cases += [('delay', signal, False) for signal in linked]
    return [
        (Evaluator(scenario, hold, rate, setting, signal, led=led), kind)
        for hold in HOLDS
        for kind, signal, led in cases
    ]


def _search_all(searches: Sequence[tuple[Evaluator, str]], progress: Progress) -> list[Limit]:
    """Search all limits, those side by side whose runs can go so."""
    families: dict[object, list[int]] = defaultdict(list)
    for i, (trial, _) in enumerate(searches):
        families[trial.family or f'alone {i}'].append(i)
    found: dict[int, Limit] = {}

    def tried(words: str) -> None:
        progress(len(found), len(searches), words)

    for places in families.values():
        steps = {i: _limit_by_steps(*searches[i], tried) for i in places}
        while steps:
            asked: list[tuple[Evaluator, Impairment]] = []
            for i, step in list(steps.items()):
                try:
                    asked += [(searches[i][0], each) for each in next(step)]
                except StopIteration as end:
                    found[i] = end.value
                    del steps[i]
            prepare(asked)
    return [found[i] for i in range(len(searches))]


def to_and_fro(loop: Loop) -> list[str]:
    """Return what the controllers that predict hear of a plant, and what they send."""
    predicting = [spec for spec in loop.blocks.values() if spec.numbered is not None]
    found = [signal for spec in predicting for signal in (spec.inputs[0][0], spec.output)]
    return list(dict.fromkeys(found))


def rate_for(kind: str, scenario: Scenario, setting: Setting) -> float:
    """Return the steps per second at which ``kind`` is searched.

    Unless the setting says it: for loss and jitter, which depend on how often samples are sent, the
    scenario's own; for the delay, which is rounded to samples, one no coarser than :data:`FINE`.
    """
    own, scale = scenario.rate, scenario.time_scale
    if setting.rate is not None:
        return setting.rate
    return max(own, scale / FINE) if kind == 'delay' else own


def _need_verdict(scenario: Scenario, setting: Setting) -> Evaluator:
    trial = Evaluator(scenario, HOLDS[0], rate_for('loss', scenario, setting), setting)
    trial.prepare([PERFECT])
    if trial.verdict() == 'undecided':
        raise EventregError(
            f'scenario {scenario.name} has no verdict, so no margin, even without delay: '
            f'w has too few events between {setting.settle:g} and {setting.duration:g} of model '
            f'time; take a longer --duration or a scenario with a disturbance'
        )
    return trial


def _impairment(kind: str, value: float) -> Impairment:
    if kind == 'delay':
        return Impairment(delay=value)
    return Impairment(loss=value) if kind == 'loss' else Impairment(jitter=value)


def limit(trial: Evaluator, kind: str) -> Limit:
    """Search the largest ``kind`` (of :data:`KINDS`) that a trial tolerates, the others being 0."""
    return finished(_limit_by_steps(trial, kind, lambda words: None), trial.prepare)


def _limit_by_steps(
    trial: Evaluator, kind: str, tried: Callable[[str], None]
) -> Generator[list[Impairment], None, Limit]:
    """Search a limit step by step: yield the impairments that will be asked for, then go on.

    ``tried`` takes a few words on each value that was tried.
    """
    scan, unit = scan_of(kind, trial.h)
    name = named(kind, trial.on)

    def value(k: int) -> float:
        return round(k * unit, 12)

    def passes(k: int) -> bool:
        result = trial.rejected(_impairment(kind, value(k)))
        tried(f'{trial.hold} hold, {name} {value(k):g}: {"" if result else "not "}rejected')
        return result

    def asked(numbers: Iterable[int]) -> list[Impairment]:
        return [_impairment(kind, value(k)) for k in numbers]

    ahead = AHEAD if kind == 'delay' or trial.seeds == 1 else 1
    largest, failure, again = yield from searching(passes, scan, asked, ahead)
    if kind == 'delay' and trial.predicts and failure is None and largest is not None:
        beyond = further(trial.h)
        largest, failure = search_on(passes, [largest, *beyond])
        scan = [*scan, *beyond]
    return Limit(
        kind=kind,
        hold=trial.hold,
        on=trial.on,
        rate=trial.rate,
        h=trial.h,
        resolution=unit,
        largest=None if largest is None else value(largest),
        fails_at=None if failure is None else value(failure),
        scanned_to=value(scan[-1]),
        rejected_again=tuple(map(value, again)),
        lead=(FOLLOWS if trial.led else trial.lead) if trial.predicts else None,
    )


@dataclass(frozen=True)
class Map:
    """The part of the seeds that are rejected (0 to 1) over delay and loss, for each hold.

    ``delays`` (model time) has shape (m,), ``losses`` (n,), each array of ``rejected`` (n, m).
    """

    rate: float
    h: float
    delays: Array
    losses: Array
    rejected: Mapping[str, Array]


def delay_and_loss(
    scenario: Scenario,
    reach: float,
    setting: Setting | None = None,
    progress: Progress = _silent,
    *,
    columns: int = 16,
    rows: int = 20,
) -> Map:
    """Try all pairs of a delay from 0 to ``reach`` (model time) and a loss from 0 to 0.95.

    There are at most ``columns`` delays, whole samples at the rate at which loss is searched, and
    ``rows`` losses. Raises EventregError when the scenario cannot be simulated.
    """
    setting = setting or Setting.of(scenario)
    rate = rate_for('loss', scenario, setting)
    trials = [Evaluator(scenario, hold, rate, setting) for hold in HOLDS]
    h = trials[0].h
    last = max(round(reach / h), 1)
    delays = np.arange(0, last + 1, -(-last // (columns - 1)), dtype=np.float64) * h
    losses = np.arange(rows, dtype=np.float64) * 0.95 / (rows - 1)
    rejected = {hold: np.zeros((rows, len(delays))) for hold in HOLDS}
    for i, loss in enumerate(losses.tolist()):
        for trial in trials:
            cells = [Impairment(delay=delay, loss=loss) for delay in delays.tolist()]
            trial.prepare(cells, shares=True)
            row = [trial.share(cell) for cell in cells]
            rejected[trial.hold][i] = row
        progress(i + 1, rows, f'loss {loss:g}')
    return Map(rate, h, delays, losses, rejected)


def reach(limits: Sequence[Limit]) -> float:
    """Return the delay (model time) up to which a picture shows both holds' edges and beyond."""
    delay = [found for found in limits if found.kind == 'delay' and not isinstance(found.on, str)]
    delay = [found for found in delay if found.lead != FOLLOWS] or delay
    edges = [x.scanned_to if x.fails_at is None else x.fails_at for x in delay]
    return min(max(1.5 * max(edges), 0.3), FARTHEST_DELAY)
