# SPDX-License-Identifier: Apache-2.0
"""The inputs of a node in real time: by time stamp, watched for silence, measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ..runtime.cdr import age_of, unpacked
from ..runtime.duration_histogram import DurationHistogram
from ..runtime.figures import MARGIN_USED, InputFigures, lead_figures
from ..runtime.stamped_input import Dropped, StampedInput
from ..runtime.tick_grid import SECOND
from ..runtime.waiting_input import WaitingInput
from .endpoints import Endpoints, InfoCallback
from .info import number_of, received_at
from .lead import Lead
from .managed import ERROR, OK, WARN, Status
from .pace import Lines, Tick
from .spike_input import SpikeInput


class DelayMargin(NamedTuple):
    """The delay that the scenario tolerates (model time), and the part of it that is a warning."""

    margin: float
    warn: float
    time_scale: float
    h: float


KNOWN, APART = 100, 1.25
"""Intervals after which the rate of an input is known, and the factor that makes it another."""


class StampedInputs:
    """All inputs of a node; ``signals`` are their names, in the order in which they are summed.

    ``horizons`` are those of their lines, in steps; an input of which nothing came for ``timeout``
    seconds counts as 0. ``samples`` are what each input keeps, :class:`.waiting_input.WaitingInput`
    say for one whose samples are played after a lead.
    """

    silence = 'it counts as 0'

    def __init__(self, samples: Mapping[str, StampedInput], node: Endpoints) -> None:
        self.signals = signals = tuple(samples)
        self.samples = list(samples.values())
        self.horizons: Sequence[float] = [0.0] * len(signals)
        self.timeout = 0.0
        self._node, self._log = node, node.get_logger()
        self.lead = Lead()
        self.silent = [False] * len(signals)
        self.quiet: list[str] = []
        self._logged: set[str] = set()
        self._reported = [Dropped() for _ in signals]
        self.ages = [DurationHistogram() for _ in signals]
        self.delays = [DurationHistogram() for _ in signals]
        self._travelled = [0] * len(signals)
        self._late = [0] * len(signals)
        self.margin: DelayMargin | None = None

    def receiver(self, i: int, go: Callable[[], None]) -> InfoCallback:
        """Return the callback of input ``i``; nobody waits for a sample."""

        def receive(data: bytes, info: dict[str, Any]) -> None:
            samples, value = self.samples[i], unpacked(data)
            before, stamp = samples.dropped, self._node.stamp_of(info)
            if isinstance(samples, WaitingInput) or samples.sparse:
                stamp = self._sent(stamp, i, data, info)
            samples.push(stamp, value, number_of(info))
            if samples.dropped is not before:
                self._log_once(self.signals[i], value)

        return receive

    def _sent(self, stamp: int, i: int, data: bytes, info: dict[str, Any]) -> int:
        """Return when a sample was made, before any relay, and measure how long it travelled."""
        if self._node.in_simulation_time:
            return stamp
        made = stamp - age_of(data)
        self._travelled[i] = received_at(info) - made
        self.delays[i].add(self._travelled[i] / SECOND)
        return made

    def play_after(self, lead: Lead) -> None:
        """Play the samples that wait ``lead`` after they were made."""
        self.lead = lead
        for samples in self.samples:
            if isinstance(samples, WaitingInput):
                samples.lead = round(lead.seconds * SECOND)
            if isinstance(samples, SpikeInput):
                samples.h = lead.h

    def limit(self, magnitude: float) -> None:
        """Drop samples of larger ``magnitude`` from now on."""
        for samples in self.samples:
            samples.limit = magnitude

    def _log_once(self, signal: str, value: float) -> None:
        if signal not in self._logged:
            self._logged.add(signal)
            self._log.warning(
                f'input {signal} sent {value:g}; samples that are not finite, beyond input_limit '
                'or alone far off are dropped and counted in the diagnostics'
            )

    def ready(self, n: int) -> bool:
        """Return True: a step takes what has come."""
        return True

    def missing(self, n: int) -> list[str]:
        """Return nothing: a step waits for no sample."""
        return []

    def over(self, tick: Tick) -> Lines:
        """Return the lines of all inputs, from the samples that came before the step."""
        base, slope = [], []
        for i, samples in enumerate(self.samples):
            found = samples.over(tick.start, tick.period, self._patience(i), self.horizons[i])
            self._watch(i, found is None and samples.begun)
            if samples.used is not None:
                self.ages[i].add((tick.now - samples.used) / SECOND)
                if not (isinstance(samples, WaitingInput) or samples.sparse):
                    self.delays[i].add((tick.start - samples.used) / SECOND)
            b, s = found or (0.0, 0.0)
            base.append(b)
            slope.append(s)
        return Lines(base, slope)

    def _patience(self, i: int) -> float:
        """Return the age (ns) of a sample that is silence; how late it came is not counted."""
        samples = self.samples[i]
        lead = samples.lead if isinstance(samples, WaitingInput) else 0
        return self.timeout * SECOND + max(self._travelled[i] - lead, 0)

    def _watch(self, i: int, silent: bool) -> None:
        """Report once that an input fell silent, and once that it is back."""
        if silent == self.silent[i]:
            return
        self.silent[i] = silent
        self.quiet = [s for s, quiet in zip(self.signals, self.silent, strict=True) if quiet]
        signal = self.signals[i]
        if silent:
            spikes = isinstance(self.samples[i], SpikeInput)
            words = 'has no more spikes' if spikes else f'silent for {self.timeout:g} s'
            self._log.warning(f'input {signal} {words}; {self.silence}')
        else:
            self._log.info(f'input {signal} is back')

    def report(self) -> list[Status]:
        """Return the figures; WARN when an input is silent, has two writers, or comes late."""
        figures = {k: v for i in range(len(self.signals)) for k, v in self._values(i).items()}
        found = [Status(OK, '', figures)]
        if dropped := self._newly_dropped():
            found.append(Status(WARN, dropped, {}))
        found += [Status(WARN, words, {}) for words in self._node.incompatible.values()]
        if several := self._node.several_writers():
            found.append(Status(WARN, several, {}))
        found += [Status(WARN, words, {}) for words in self._other_rates()]
        if self.quiet:
            found.append(Status(WARN, f'silent, {self.silence}: {", ".join(self.quiet)}', {}))
        delayed = self._judge_delays()
        return [*found, *self._judge_lead(), *([delayed] if delayed else [])]

    def _other_rates(self) -> list[str]:
        """Say which inputs come regularly, but much faster or slower than this node steps."""
        if self.margin is None or self._node.in_simulation_time:
            return []  # arrivals in simulation time say nothing of a rate
        words, rate = [], self.margin.time_scale / self.margin.h
        for signal, samples in zip(self.signals, self.samples, strict=True):
            period = 0.0 if samples.sparse else self._regular(samples.period)
            if period and not 1.0 / APART < period * rate < APART:
                words.append(
                    f'{signal} comes {1.0 / period:.3g} times a second, this node steps {rate:g} '
                    'times; give both the same rate'
                )
        return words

    def _regular(self, period: DurationHistogram) -> float:
        """Return the usual period in seconds; 0 where it is not known, or none: send_on_delta."""
        if period.count < KNOWN:
            return 0.0
        low, usual, high = (period.percentile(percent) for percent in (10, 50, 90))
        return usual if high < low * APART**2 and usual < 0.4 * self.timeout else 0.0

    def _newly_dropped(self) -> str:
        """Say which inputs had samples dropped since the last report, and how many."""
        words = []
        for i, signal in enumerate(self.signals):
            dropped = self.samples[i].dropped
            more, self._reported[i] = dropped.since(self._reported[i]), dropped
            if any(more):
                words.append(
                    f'{signal}: {more.not_finite} not finite, {more.out_of_range} beyond '
                    f'input_limit, {more.outliers} alone far off'
                )
        return f'samples dropped ({"; ".join(words)})' if words else ''

    def _values(self, i: int) -> dict[str, object]:
        samples = self.samples[i]
        spans = (samples.period, samples.jitter, self.ages[i], self.delays[i])
        percentiles = [span.percentiles if samples.received else None for span in spans]
        return InputFigures(
            samples.received,
            samples.lost,
            samples.gaps,
            samples.out_of_order,
            *samples.dropped,
            *percentiles,
        ).values(self.signals[i])

    def _judge_lead(self) -> list[Status]:
        """Return what to report of samples that came after their time, and how many there were."""
        found = []
        for i, (signal, samples) in enumerate(zip(self.signals, self.samples, strict=True)):
            if not isinstance(samples, WaitingInput):
                continue
            more, self._late[i] = samples.late - self._late[i], samples.late
            delay = self.delays[i].take_recent()
            figures = lead_figures(signal, samples.late, self.lead.lead)
            words = self.lead.complaint(signal, delay, more) if more else ''
            found.append(Status(WARN if more else OK, words, figures))
        return found

    def _judge_delays(self) -> Status | None:
        """Return what to report when a delay of the last second comes near the margin."""
        delays = {
            signal: self.delays[i].take_recent()
            for i, signal in enumerate(self.signals)
            if self.samples[i].received and not isinstance(self.samples[i], WaitingInput)
        }
        signal = max(delays, key=lambda name: delays[name], default=None)
        if signal is None or self.margin is None:
            return None
        margin, warn, time_scale, h = self.margin
        delay = delays[signal] * time_scale
        # Less than a step is made up for by the next sample, so that it is no delay.
        used = delay if delay >= h else 0.0
        figures = {MARGIN_USED: f'{used / margin:.3f}'} if margin else {}
        if delay < max(warn * margin, h):
            return Status(OK, '', figures)
        return Status(
            ERROR if delay >= margin else WARN,
            f'the measured delay of {signal} ({delays[signal] * 1e3:.1f} ms, {delay:.3f} of model '
            f'time) comes near the delay margin of the scenario ({margin:g})',
            figures,
        )
