# SPDX-License-Identifier: Apache-2.0
r"""The library: what the commands do, for notebooks and scripts.

    from eventreg_ros import load, simulate, certificates

    scenario = load('exact', {'controller.k': 3})
    run = simulate(scenario, duration=400)
    print(run.verdict, run.events['w'], run['y'][-1])
    print(*certificates(scenario), sep='\n')

All public names of this module are there as ``from eventreg_ros import ...``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np
import numpy.typing as npt

from . import scenario as scenario_files
from .analysis import recorded
from .analysis.comparison import Comparison
from .analysis.events import detect
from .analysis.identification import Identification
from .bags import reader
from .errors import EventregError, shown
from .robustness import margins as robustness
from .robustness.axes import spec_of
from .robustness.cluster import runner
from .robustness.plan import Plan
from .robustness.sweep import run_sweep
from .scenario import Override, Scenario
from .scenario.criteria import RESET, THRESHOLD
from .session import identified, simulated
from .session.bag import Recorded
from .session.bordered import Border, border_of
from .session.compared import compare, open_run
from .session.judged import judge
from .session.simulated import Run
from .session.swept import Sweep
from .theory.certificates import Certificate
from .theory.certify import certify

if TYPE_CHECKING:
    from .robustness.evaluator import Setting
    from .robustness.margins import Limit
    from .session.live import LiveRun

Overrides = Mapping[str, object]
"""Parameters by NODE.PARAM, NODE may be /**: {'controller.k': 3}."""

Given = Scenario | str | Path
"""A scenario: the name of a shipped one, the path of a file, or what :func:`load` returns."""

__all__ = [
    'Border',
    'Certificate',
    'Comparison',
    'Identification',
    'Recorded',
    'Run',
    'Scenario',
    'Sweep',
    'analyze',
    'border',
    'certificates',
    'compare',
    'events',
    'identify',
    'judge',
    'load',
    'margins',
    'open_run',
    'read_bag',
    'run',
    'scenarios',
    'simulate',
    'sweep',
]


def scenarios() -> list[str]:
    """Return the names of the shipped scenarios.

    >>> 'exact' in scenarios()
    True
    """
    return scenario_files.shipped()


def load(scenario: str | Path, *overrides: str | Overrides) -> Scenario:
    """Read a scenario, by the name of a shipped one or by the path of a parameter file.

    ``overrides`` are dictionaries {'NODE.PARAM': VALUE}, or texts as they follow -p on a command
    line, ``NODE.PARAM:=VALUE``; NODE may be ``/**``. Raises ScenarioError or ParameterError, one
    line with the remedy.

    >>> load('exact', {'controller.k': 3}, 'plant.tau:=1/10').nodes['controller']['k']
    3.0
    """
    return _with(scenario_files.load(str(scenario)), overrides)


def _with(scenario: Scenario, overrides: Iterable[str | Overrides]) -> Scenario:
    """Return ``scenario`` with all overrides at once: one by one they may contradict others."""
    read: list[str | Override] = []
    for each in overrides:
        if isinstance(each, str):
            read.append(each)
        elif not isinstance(each, Mapping):
            raise EventregError(
                "overrides are a dictionary {'NODE.PARAM': VALUE} or a text NODE.PARAM:=VALUE, got "
                f'{shown(each)}'
            )
        else:
            read += [Override.of(name, _plain(value)) for name, value in each.items()]
    return scenario_files.with_overrides(scenario, read) if read else scenario


def _plain(value: object) -> object:
    """Return an array or a number of numpy as Python's own."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _loaded(scenario: Given, overrides: str | Overrides | None = None) -> Scenario:
    """Return a scenario, given as one, by name or by path. Raises EventregError for all else."""
    if not isinstance(scenario, Scenario | str | Path):
        raise EventregError(
            f'a scenario is one of {", ".join(scenario_files.shipped())}, the path of a .yaml file '
            f'or what load returns, got {shown(scenario)}'
        )
    found = scenario if isinstance(scenario, Scenario) else load(scenario)
    return _with(found, [overrides]) if overrides else found


def simulate(
    scenario: Given,
    overrides: str | Overrides | float | None = None,
    duration: float | None = None,
    *,
    sampled: bool = False,
    delay: float = 0.0,
    loss: float = 0.0,
    jitter: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
    on: Collection[str] | None = None,
    at: Sequence[str] = (),
) -> Run:
    """Simulate a scenario (or the one of that name) over ``duration`` of model time.

    ``overrides`` are parameters by NODE.PARAM, as a dictionary or as one text,
    'NODE.PARAM:=VALUE'; a number in their place is the duration. That is 400 by default, or 300
    after settling if that is longer. The loop is one continuous system, or ``sampled``: sample by
    sample as the nodes do it in lockstep, each link with ``delay`` and ``jitter`` (model time) and
    ``loss`` (probability), drawn from ``seed``; ``on`` names the signals whose links are impaired
    (None: all). White ``noise`` of that standard deviation, drawn from ``seed`` too, is added to
    every sample of each plant's output: a sampled loop hears it, a continuous one is only judged
    through it. ``at`` holds interventions as texts ``T:NODE.PARAM:=VALUE``, ``T:NODE:activate`` or
    ``T:NODE:deactivate``, T in model time. Raises EventregError when the loop cannot be simulated
    or the state stops being finite.

    >>> run = simulate('exact', {'controller.k': 3})
    >>> run
    <Run of exact: w, y, u; 400 of model time; rejected>
    >>> run.reason
    'after t = 100 w had 8 events; none made y spike'
    >>> len(run.events['w']), run['y'].shape
    (10, (8001,))
    """
    if isinstance(overrides, SupportsFloat):  # a number, numpy's too
        duration, overrides = float(overrides), None
    if not (duration is None or isinstance(duration, SupportsFloat)):
        raise EventregError(f'duration must be a number, of model time, got {shown(duration)}')
    return simulated.simulate(
        _loaded(scenario, overrides),
        None if duration is None else float(duration),
        sampled=sampled,
        delay=delay,
        loss=loss,
        jitter=jitter,
        noise=noise,
        seed=seed,
        on=on,
        at=at,
    )


def run(
    scenario: Given,
    overrides: str | Overrides | None = None,
    duration: float | None = None,
    *,
    bag: str | Path | None = None,
    lockstep: bool = False,
    composed: bool = False,
    at: Sequence[str] = (),
) -> LiveRun:
    """Run a scenario as ROS nodes over real topics, record it for ``duration`` seconds, judge it.

    ``overrides`` are those of :func:`simulate`. ``duration`` is 40 s by default, or as long as 300
    of model time after settling take. The bag goes into the directory ``bag``, which must be new
    (eventreg_SCENARIO_TIME). In ``lockstep`` the nodes go as fast as they can, to the same bits as
    ``simulate(..., sampled=True)``, and ``duration`` is simulated; ``composed`` puts them into one
    process. ``at`` holds interventions like those of :func:`simulate`, at times in seconds.

    What is returned is read like a simulation (``run['y']``, ``run.plot()``), and holds ``bag``,
    ``troubles`` and ``warnings`` besides. Raises EventregError when there is no ROS or the run
    cannot be started.

    >>> run('exact', lockstep=True, at=['13:controller:deactivate'])  # doctest: +SKIP
    <LiveRun of exact: w, y, u; 400 of model time; not rejected>
    """
    from .session import live

    return live.run(
        _loaded(scenario, overrides),
        duration,
        bag=bag,
        lockstep=lockstep,
        composed=composed,
        at=at,
    )


def read_bag(
    bag: str | Path,
    namespace: str | None = None,
    *,
    topics: Sequence[str] = (),
    time: str | None = None,
    signals: Collection[str] | None = None,
) -> Recorded:
    """Read a bag: its signals over model time, and by ``recording`` as they were recorded.

    ``namespace`` says which topics to read where several hold a y, each of ``topics``,
    SIGNAL:=TOPIC[:FIELD], names a signal's source, and ``time`` (log, publish or header) which
    stamps count; ``signals``: only these. What is wrong with the bag is in ``findings``. It is
    judged, by its own scenario, when it is first asked for its verdict or events, where
    :func:`analyze` refuses a bag at once that lacks a signal. Raises EventregError, one line, where
    there is nothing to read.

    >>> read_bag('BAG', topics=['y:=/arm/joint_states:velocity[2]'])['y']  # doctest: +SKIP
    array([0., 0.01664, ...])
    """
    found = reader.read_bag(bag, namespace, topics=topics, time=time, signals=signals)
    scenario = recorded.scenario_of(found, None, namespace)
    return Recorded(recorded.by_scenario(found, scenario))


def analyze(
    bag: str | Path,
    scenario: Scenario | str | None = None,
    *,
    settle: float | None = None,
    window: float | None = None,
    blind: float | None = None,
    until: float | None = None,
    lenient: bool = False,
    namespace: str | None = None,
    topics: Sequence[str] = (),
    time: str | None = None,
) -> Recorded:
    """Read a bag, and judge it by ``scenario`` (an object, a name or a path), else by its own.

    ``settle``, ``window`` and ``blind``, in model time, replace the scenario's; what lies after
    ``until`` is not judged; ``lenient`` judges what was seen although something is missing.
    ``namespace``, ``topics`` and ``time`` say what is read: see :func:`read_bag`. Raises
    EventregError, one line, for what cannot be read or judged.

    >>> analyze('BAG', topics=['y:=/arm/joint_states:velocity[2]'])  # doctest: +SKIP
    <Recorded of exact: w, y, u; 400 of model time; rejected>
    """
    return Recorded(
        recorded.analyze(
            bag,
            scenario,
            settle=settle,
            window=window,
            blind=blind,
            until=until,
            lenient=lenient,
            namespace=namespace,
            topics=topics,
            time=time,
        )
    )


def margins(scenario: Given, setting: Setting | None = None) -> list[Limit]:
    """Return how much delay, loss and jitter a scenario tolerates, as ``eventreg margin`` prints.

    For each hold that of all links (delay, loss, jitter) and the delay of each signal alone; see
    :class:`.robustness.margins.Limit`. ``setting`` says how long each run is and how many seeds are
    tried. It takes seconds, without numba minutes. Raises EventregError when the scenario cannot be
    simulated or has no verdict.

    >>> [(x.hold, x.largest) for x in margins('exact') if x.name == 'delay']  # doctest: +SKIP
    [('zero', 0.38), ('zero', 0.35), ('linear', 0.4), ('linear', 0.4)]
    """
    return robustness.margins(_loaded(scenario), setting)


def _signals(on: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the signals that are named, one by itself too, None for all."""
    return on if on is None else (on,) if isinstance(on, str) else tuple(on)


def sweep(
    scenario: Given,
    parameters: Mapping[str, object],
    *,
    sets: int | None = None,
    seed: int = 0,
    sampling: str = 'random',
    on: Sequence[str] | None = None,
    duration: float | None = None,
    settle: float | None = None,
    window: float | None = None,
    out: str | Path | None = None,
    engine: str = 'local',
    scheduler: str | None = None,
) -> Sweep:
    """Run the sampled loop over many sets of parameters; judge each as :func:`simulate` does.

    ``parameters`` maps NODE.PARAM to what follows := on a command line, '0.5..4/50' or '2~10%'
    (:mod:`.robustness.axes`), to a list of values, or to one value, which is fixed; ``links.delay``
    and the like are of all links, or those of the signals ``on``, and ``noise.y`` is of y. With
    ``sets`` so many are drawn by ``seed``, ``sampling`` being 'random', 'sobol' or 'saltelli';
    without it is a grid. ``out`` is a directory that keeps the table, and from which a sweep that
    was stopped goes on. With ``engine`` 'dask' it runs on the cluster at ``scheduler``. Raises
    EventregError.

    >>> sweep('exact', {'controller.k': [1, 2, 3]}).rejected
    3
    """
    plan = Plan.of(
        _loaded(scenario),
        [f'{name}:={spec_of(value)}' for name, value in parameters.items()],
        sets=sets,
        seed=seed,
        sampling='grid' if sets is None else sampling,
        on=_signals(on),
        duration=duration,
        settle=settle,
        window=window,
    )
    found = run_sweep(plan, None if out is None else Path(out), runner(engine, scheduler))
    return Sweep.of(found)


def border(
    scenario: Given,
    parameters: Mapping[str, object],
    x: str,
    y: str,
    *,
    on: Sequence[str] | None = None,
    duration: float | None = None,
    settle: float | None = None,
    window: float | None = None,
) -> Border:
    """Find the border between rejected and not over two parameters, and follow it as an orbit.

    ``parameters`` are as for :func:`sweep`; those called ``x`` and ``y`` are ranges with a number
    of values, '0.5..2/200', and the others are fixed. Raises EventregError.

    >>> found = border(
    ...     'exact', {'exosystem.tau': '1/20..1/12/9', 'controller.k': '0.7..1/9'},
    ...     'exosystem.tau', 'controller.k',
    ... )
    >>> len(found.curves)
    1
    """
    plan = Plan.of(
        _loaded(scenario),
        [f'{name}:={spec_of(value)}' for name, value in parameters.items()],
        on=_signals(on),
        duration=duration,
        settle=settle,
        window=window,
    )
    return border_of(plan, [x, y])


def identify(
    source: Given,
    overrides: str | Overrides | None = None,
    *,
    signal: str | None = None,
    generators: int = 1,
    affine: bool = False,
    scenario: Scenario | str | None = None,
    start: float = 0.0,
    until: float | None = None,
    namespace: str | None = None,
    topics: Sequence[str] = (),
    time: str | None = None,
) -> Identification:
    """Identify the generator behind a recorded spike train: its tau, and its k if it can be known.

    ``source`` is a bag, or a scenario (with ``overrides``), which is simulated. ``signal`` is the
    output of an exosystem or of a plant, see :func:`.session.identified.identify`; ``affine``: a
    sensor's gain and offset are unknown. ``scenario`` belongs to the bag instead of its own; only
    what lies between ``start`` and ``until`` (model time) is used; the rest is how the bag is read,
    see :func:`read_bag`. Raises EventregError with the reason when nothing can be identified.

    >>> round(identify('mismatch', signal='y').tau * 12, 6)
    1.0
    """
    if overrides:
        source = _loaded(source if isinstance(source, Scenario) else str(source), overrides)
    seen = identified.observe(source, scenario, namespace=namespace, topics=topics, time=time)
    return identified.identify(seen.part(start, until), signal, generators, affine)


def events(
    t: npt.ArrayLike,
    values: npt.ArrayLike,
    threshold: float = THRESHOLD,
    reset: float = RESET,
    refractory: float = 0.0,
    min_width: float = 0.0,
) -> list[float]:
    """Return the times of the events of one signal.

    Samples ``values`` at ``t``, both of shape (n,), are arrays or lists. An event rises through
    ``threshold`` after the signal was at or below ``reset``, lasts until it is there again, at
    least ``min_width``, and begins at least ``refractory`` after the last event.

    >>> events([0, 1, 2, 3], [-1, 3, -1, 0])
    [0.5]
    """
    times, samples = (np.asarray(each, np.float64) for each in (t, values))
    return detect(times, samples, threshold, reset, refractory, min_width)


def certificates(scenario: Given) -> list[Certificate]:
    """Return what theory says of a scenario, and what is measured where theory is silent.

    What ``eventreg certify`` prints; the measured Lyapunov exponents take a second or two.

    >>> [each.status for each in certificates('linear') if each.claim == 'hurwitz']
    ['pass']
    """
    return certify(_loaded(scenario).loop)
