# SPDX-License-Identifier: Apache-2.0
"""A node that publishes one signal, sample by sample, and hears any number of others."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress

from rclpy.duration import Duration

from ..runtime.cdr import packed
from ..runtime.stamped_input import StampedInput
from ..runtime.waiting_input import WaitingInput
from ..scenario.blocks import coding_of
from ..scenario.inputs import delays_of, signs_of, templates_of
from ..scenario.parameter import ACTIVE, UNCONFIGURED
from ..simulation.block import leads_of
from ..simulation.coding import Coder, Coding
from ..simulation.hold import horizon_in_steps
from ..simulation.model_time import steps_of
from .lead import Lead
from .lockstep import Lockstep, Participant
from .managed import OK, WARN, FaultError, ManagedNode, Status
from .pace import Inputs, Lines, Pace, Tick
from .realtime import RealTime, Timing
from .ros import RCLError
from .sequenced import Schedule, SequencedInputs
from .spike_input import SpikeInput
from .stamped import DelayMargin, StampedInputs
from .topics import signal_topic

LAST_WORD = 0.1
"""Seconds that the last sample of a process that ends may take to arrive."""


class SignalNode(ManagedNode):
    """Publishes sample n of ``output`` when its pace says so: the clock's, or lockstep's.

    A subclass gives ``initial() -> value`` and ``step(n, lines) -> value``, from sample n to the
    next.
    """

    pace: Pace | None = None
    inputs: Inputs
    off = False
    """In lockstep: whether the node is switched off, so that it publishes 0."""
    cut_off = 0
    """Samples of the output that output_limit cut off."""
    _reported_cut_off = 0
    coding: Coding | None = None
    """How the output is coded, as listeners know it: as it was when the node was configured."""
    coder: Coder | None = None
    """What codes the output, where not every sample is sent."""
    sent = 0
    """Messages of the output since activation."""
    squares = 0.0
    """The sum of the squares of the output's samples since then, as receivers know them."""
    _looked = (0.0, 0)
    starting = False
    """In lockstep: whether it was just switched on again, so that it starts anew."""

    def initial(self) -> float:
        """Return sample 0."""
        raise NotImplementedError

    def step(self, n: int, lines: Lines) -> float:
        """Take the step from sample ``n``, with the inputs over it, and return the next sample."""
        raise NotImplementedError

    @property
    def signs(self) -> tuple[tuple[str, float], ...]:
        """The inputs with their signs, in the order in which they are summed."""
        return signs_of(self.values)

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return float(self.values['time_scale'] / self.values['rate'])

    @property
    def n(self) -> int:
        """The number of the newest sample; -1 before the first."""
        return self.pace.n if self.pace is not None else -1

    def open(self) -> None:
        """Create the publisher of the output and the subscriptions of the inputs."""
        self.pace = None
        self.coding = coding_of(self.values)
        lockstep = self.values['lockstep']
        topic = signal_topic(lockstep)
        self.publisher = self.advertise(topic, self.values['output'], always=lockstep)
        self.inputs = self._make_inputs()
        # Nobody need be woken by a sample: in real time it is used at the next tick. In simulation
        # time it counts from its arrival, and in lockstep a step may wait for it.
        polled = not (lockstep or self.in_simulation_time)
        for i, signal in enumerate(self.inputs.signals):
            self.subscribe(topic, signal, self.inputs.receiver(i, self._go), polled=polled)

    @property
    def lead(self) -> Lead:
        """By how much u is ahead of its stamps; 0 for a node that it does not concern."""
        given, h = self.values.get('lead', 0.0), self.h
        return Lead(steps_of(given, h), h, self.values['time_scale'])

    def _schedules(self) -> dict[str, Schedule]:
        """Return when the samples of each input come (in lockstep) and when they are played."""
        delays = delays_of(self.values)
        leads = leads_of(self.kind, self.signs, self.lead.steps)
        return {
            signal: Schedule(steps_of(delays.get(signal, 0.0), self.h), lead)
            for (signal, _), lead in zip(self.signs, leads, strict=True)
        }

    def _make_inputs(self) -> Inputs:
        schedules = self._schedules()
        if self.values['lockstep']:
            return SequencedInputs(schedules)
        return StampedInputs({s: self._input(s, each) for s, each in schedules.items()}, self)

    def _input(self, signal: str, schedule: Schedule) -> StampedInput:
        if (tau := templates_of(self.values).get(signal)) is not None:
            return SpikeInput(tau)
        return WaitingInput() if schedule.lead else StampedInput()

    def _tune_inputs(self) -> None:
        """Hand on the parameters that the inputs need."""
        values, inputs = self.values, self.inputs
        if 'hold' not in values:
            return  # a node without inputs
        horizon, held = horizon_in_steps(values['hold'], self.h), values['held_inputs']
        inputs.horizons = [0.0 if signal in held else horizon for signal in inputs.signals]
        if self.coder is not None:
            self.coder.h = self.h
        if isinstance(inputs, StampedInputs):
            inputs.timeout = values['input_timeout']
            inputs.limit(values['input_limit'])
            inputs.play_after(self.lead)
            for signal, samples in zip(inputs.signals, inputs.samples, strict=True):
                if signal in held:
                    samples.sparse, samples.patience = True, inputs.timeout
            own = 'delay_margin' if values['hold'] == 'linear' else 'delay_margin_zero'
            margin, warn = values[own], values['delay_warn']
            inputs.margin = DelayMargin(margin, warn, values['time_scale'], self.h)

    def begin(self) -> None:
        """Start at sample 0; on leaving, the output goes to 0, see :meth:`_leave_at_rest`.

        In lockstep, where the others wait for every sample, a node that is switched off goes on
        publishing 0, and its samples go on to be numbered when it is switched on again.
        """
        self.sent, self.squares, self._looked = 0, 0.0, (time.monotonic(), 0)
        if not (self.values['lockstep'] and self.pace is not None):
            coding, rate = self.coding, self.values['rate']
            self.coder = Coder(coding, rate, self.h) if coding is not None else None
        self._tune_inputs()
        if self.values['lockstep']:
            self._begin_lockstep()
            return
        self.stack.callback(self._leave_at_rest)
        timing = Timing(*(self.values[name] for name in Timing._fields))
        self.pace = RealTime(self, timing, self)
        self.pace.begin()

    def _leave_at_rest(self) -> None:
        """Publish a last 0; when the process ends, a controller alone does so.

        A plant may hold what it was given last. What others measure ends with their last sample.
        """
        if self.closing and self.kind != 'controller':
            return
        self.send(self.publisher, packed(0.0))
        if self.closing:
            with suppress(RCLError):  # a middleware that cannot wait for it
                self.publisher.wait_for_all_acked(Duration(seconds=LAST_WORD))

    def _begin_lockstep(self) -> None:
        self.off, self.starting = False, self.pace is not None
        self.stack.callback(self._switch_off)
        if self.pace is None:
            with self.until_cleanup():
                self.pace = Lockstep(self, self.inputs, self._join)
                self.pace.begin()

    def _switch_off(self) -> None:
        self.off = True

    def _join(self, go: Callable[[], None]) -> Participant:
        assert isinstance(self.pace, Lockstep)
        return Participant(self, go, self.pace.missing)

    def _go(self) -> None:
        if self.stage != UNCONFIGURED and self.pace is not None:
            self.pace.go()

    def changed(self) -> None:
        """Take over the parameters of the inputs."""
        if self.stage == ACTIVE:
            self._tune_inputs()

    # What the pace asks for

    def first(self) -> float:
        """Return sample 0. Raises FaultError when it is not finite."""
        return self._coded(0, self._sound(self.initial()))

    def following(self, tick: Tick) -> float:
        """Take one step with the inputs as they are known at its beginning."""
        if self.off or self.starting:
            self.inputs.over(tick)  # the samples are used up all the same
            off, self.starting = self.off, False
            if off and self.coder is not None:
                self.coder.forget()
            return 0.0 if off else self._coded(tick.n + 1, self._sound(self.initial()))
        value = self._sound(self._next(tick))
        limit = self.values.get('output_limit')
        if limit and not -limit < value < limit:
            self.cut_off += 1
            value = float(min(max(value, -limit), limit))
        return self._coded(tick.n + 1, value)

    def _coded(self, n: int, value: float) -> float:
        """Return what receivers make of sample ``n`` of the output."""
        if self.coder is not None:
            value = self.coder(value)
            self._published(n, value)
        self.squares += value * value
        return value

    def _published(self, n: int, value: float) -> None:
        """Note what receivers make of sample ``n`` of an output that is coded."""

    def _next(self, tick: Tick) -> float:
        return self.step(tick.n, self.inputs.over(tick))

    def put(self, value: float) -> bool:
        """Publish ``value``, or the messages that it has become; say whether anything was sent.

        In lockstep, where the others wait for every sample, what receivers make of them is sent.
        """
        coded = self.coder is not None and not self.values['lockstep']
        messages = self.coder.take() if coded and self.coder is not None else [value]
        for message in messages:
            self.send(self.publisher, packed(message))
        self.sent += len(messages)
        return bool(messages)

    def _sound(self, value: float) -> float:
        if not math.isfinite(value):
            raise FaultError(
                f'the state of {self.label} stopped being finite at step {self.n + 1}; '
                'lower time_scale or raise rate, and look at the inputs'
            )
        return value

    def _report_cut_off(self) -> list[Status]:
        more, self._reported_cut_off = self.cut_off - self._reported_cut_off, self.cut_off
        if not more:
            return []
        words = f'the output was cut off at {self.values["output_limit"]:g} in {more} samples'
        return [Status(WARN, words, {})]

    def _sent_so_far(self) -> dict[str, object]:
        """Return messages and energy of the output since activation, and messages a second."""
        now, before = time.monotonic(), self._looked
        self._looked = now, self.sent
        output = self.values['output']
        rate = (self.sent - before[1]) / (now - before[0]) if now > before[0] else 0.0
        return {
            f'{output}.sent': self.sent,
            f'{output}.sent_per_second': f'{rate:.2f}',
            f'{output}.energy': f'{self.squares * self.h:.4g}',
        }

    def report(self) -> Status:
        """Return the figures of pace and inputs; the worst of their findings is the level."""
        assert self.pace is not None
        pace = self.pace.report()
        found = [pace, *self.inputs.report(), *self._report_cut_off()]
        values = {key: value for each in found for key, value in each.values.items()}
        values |= self._sent_so_far()
        findings = [each.message for each in found if each.level != OK]
        level = max(each.level for each in found)
        return Status(level, '; '.join(findings) or pace.message, values)
