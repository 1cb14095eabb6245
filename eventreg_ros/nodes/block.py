"""The one node that runs a block; exosystem, plant, controller and reference are its four names."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ..runtime.cdr import unpacked
from ..runtime.duration_histogram import DurationHistogram
from ..runtime.sequenced_input import SequencedInput
from ..runtime.stamped_input import StampedInput
from ..runtime.tick_grid import SECOND
from ..scenario import block_spec
from ..scenario.parameter import ACTIVE
from ..simulation.block import Block
from .info import number_of
from .managed import ERROR, OK, WARN, InfoCallback
from .realtime import RealTime
from .signal import SignalNode


class BlockNode(SignalNode):
    """Steps its block on the grid, with the samples of its inputs."""

    def open(self) -> None:
        """Create the publisher of the output and the subscriptions of the inputs."""
        super().open()
        self.spec = block_spec(self.kind, self.values)
        self.samples = [StampedInput() for _ in self.spec.inputs]
        self.numbered = [SequencedInput() for _ in self.spec.inputs]
        self.silent = [False] * len(self.samples)
        self.not_finite_told = [False] * len(self.samples)
        self.ages = [DurationHistogram() for _ in self.samples]
        self.delays = [DurationHistogram() for _ in self.samples]
        make = self._numbered_receiver if self.values['lockstep'] else self._receiver
        for i, (signal, _) in enumerate(self.spec.inputs):
            self.subscribe(self.signal_topic, signal, make(i))

    def shut(self) -> None:
        """Destroy them."""
        super().shut()
        self.unsubscribe()

    def begin(self) -> None:
        """Start from x0."""
        self.spec = block_spec(self.kind, self.values)
        self.block = Block(self.spec)
        super().begin()

    def changed(self) -> None:
        """Take over k, tau, gain and time_scale, from the next step on."""
        if hasattr(self, 'block'):
            spec = block_spec(self.kind, self.values)
            self.block.retune(
                replace(self.block.spec, params=spec.params, time_scale=spec.time_scale)
            )

    def first(self) -> float:
        """Return the output of the initial state."""
        return self.block.y

    def following(self, n: int) -> float:
        """Take one step with the inputs as they are known at its beginning."""
        lines = self._numbered_lines(n) if self.values['lockstep'] else self._lines(n)
        y = self.block.advance(*lines)
        return y if math.isfinite(sum(self.block.x)) else math.nan

    # In real time: by time stamp

    def _receiver(self, i: int) -> InfoCallback:
        def receive(data: bytes, info: dict[str, Any]) -> None:
            samples, value = self.samples[i], unpacked(data)
            before = samples.not_finite
            samples.push(self.stamp_of(info), value, number_of(info))
            if samples.not_finite > before and not self.not_finite_told[i]:
                self.not_finite_told[i] = True
                self.get_logger().warning(
                    f'input {self.spec.inputs[i][0]} sent {value}; samples that are not '
                    'finite are dropped and counted in the diagnostics'
                )

        return receive

    def _lines(self, n: int) -> tuple[list[float], list[float]]:
        assert isinstance(self.pace, RealTime)
        assert self.pace.origin is not None
        grid = self.pace.grid
        start = grid.stamp(self.pace.origin + n)
        timeout = self.values['input_timeout'] * SECOND
        horizon = self.block.spec.horizon
        base, slope = [], []
        for i, samples in enumerate(self.samples):
            found = samples.over(start, grid.period, timeout, horizon)
            self._watch(i, found is None and samples.last_stamp is not None)
            if samples.used is not None:
                self.ages[i].add((self.pace.now - samples.used) / SECOND)
                self.delays[i].add((start - samples.used) / SECOND)
            b, s = found or (0.0, 0.0)
            base.append(b)
            slope.append(s)
        return base, slope

    def _watch(self, i: int, silent: bool) -> None:
        """Say once that an input fell silent, and once that it is back."""
        if silent == self.silent[i]:
            return
        self.silent[i] = silent
        signal = self.spec.inputs[i][0]
        if silent:
            self.get_logger().warning(
                f'input {signal} silent for {self.values["input_timeout"]:g} s; it counts as 0'
            )
        else:
            self.get_logger().info(f'input {signal} is back')

    # In lockstep: by number

    def _numbered_receiver(self, i: int) -> InfoCallback:
        push = self.numbered[i].push

        def receive(data: bytes, info: dict[str, Any]) -> None:
            push(number_of(info), unpacked(data))
            if self.stage == ACTIVE:
                self.pace.go()  # type: ignore[union-attr]

        return receive

    def ready(self, n: int) -> bool:
        """Say whether sample ``n`` of every input has come."""
        for samples in self.numbered:  # noqa: SIM110 (all() takes twice as long)
            if samples.received <= n:
                return False
        return True

    def missing(self, n: int) -> list[str]:
        """Return the inputs whose sample ``n`` has not come, and what is wrong with them."""
        return [
            f'input {signal}' + (f' ({samples.flaw})' if samples.flaw else '')
            for (signal, _), samples in zip(self.spec.inputs, self.numbered, strict=True)
            if not samples.has(n)
        ]

    def _numbered_lines(self, n: int) -> tuple[list[float], list[float]]:
        horizon = self.block.spec.horizon
        base, slope = [], []
        for samples in self.numbered:
            b, s = samples.over(n, horizon)
            base.append(b)
            slope.append(s)
        return base, slope

    # What is told

    def report(self) -> tuple[bytes, str, dict[str, Any]]:
        """Add what is known of the inputs; WARN when one is silent."""
        level, message, values = super().report()
        if self.values['lockstep']:
            for (signal, _), numbered in zip(self.spec.inputs, self.numbered, strict=True):
                values[f'{signal}.received'] = numbered.received
            return level, message, values
        delays = {}
        for i, (signal, _) in enumerate(self.spec.inputs):
            samples = self.samples[i]
            values[f'{signal}.received'] = samples.received
            values[f'{signal}.lost'] = samples.lost
            values[f'{signal}.gaps'] = samples.gaps
            values[f'{signal}.out_of_order'] = samples.out_of_order
            values[f'{signal}.not_finite'] = samples.not_finite
            if samples.received:
                values.update(samples.period.figures(f'{signal}.period'))
                values.update(samples.jitter.figures(f'{signal}.jitter'))
                values.update(self.ages[i].figures(f'{signal}.age'))
                values.update(self.delays[i].figures(f'{signal}.delay'))
                delays[signal] = self.delays[i].take_recent()
        quiet = [s for (s, _), silent in zip(self.spec.inputs, self.silent, strict=True) if silent]
        found = [(level, message)]
        if several := self.several_writers():
            found.append((WARN, several))
        if quiet:
            found.append((WARN, f'silent, counted as 0: {", ".join(quiet)}'))
        if delayed := self._judge_delays(delays):
            found.append(delayed)
        worst = max(level for level, _ in found)
        messages = [message for level, message in found if level != OK]
        return worst, '; '.join(messages) or message, values

    def _judge_delays(self, delays: dict[str, float]) -> tuple[bytes, str] | None:
        """Return level and message when a delay of the last second comes near the margin."""
        own = 'delay_margin' if self.spec.hold == 'linear' else 'delay_margin_zero'
        margin = self.values[own]
        signal = max(delays, key=lambda name: delays[name], default=None)
        if signal is None:
            return None
        delay = delays[signal] * self.values['time_scale']
        # Less than a step is made up for by the next sample, so that it is no delay.
        if delay < max(self.values['delay_warn'] * margin, self.spec.h):
            return None
        level = ERROR if delay >= margin else WARN
        return level, (
            f'the measured delay of {signal} ({delays[signal] * 1e3:.1f} ms, {delay:.3f} of model '
            f'time) comes near the delay margin of the scenario ({margin:g})'
        )
